"""Faults of one line that an outsider planted and nothing found, with their siblings.

A row says where a function is, what one of its lines says and what it says in its place, and which
script shows it. ``laws`` and ``model`` see all of them.
"""

import inspect
import pkgutil
import textwrap
from collections.abc import Mapping
from types import FunctionType
from typing import Any, Final, NamedTuple

from simulation.mutants import Fault
from simulation.script import Act, Ending, Life, Player, Script, Visit

PACE_S: Final = 0.3  # from word to word


class Planted(NamedTuple):
    """One line of a function that is another."""

    kind: str
    where: str  # module:name, of a function, a property, or a number of a module
    before: str  # in its source, once
    after: str
    script: str  # by its name


def fault_of(planted: Planted) -> Fault:
    """Return what changes the function; ValueError where the line is not there any more."""
    name, found = planted.where, resolved(planted.where)
    function = found.fget if isinstance(found, property) else found
    assert isinstance(function, FunctionType), name
    source = textwrap.dedent(inspect.getsource(function))
    if source.count(planted.before) != 1:
        raise ValueError(f"{name} has {planted.before!r} {source.count(planted.before)} times")
    made: dict[str, Any] = {}
    exec(source.replace(planted.before, planted.after), function.__globals__, made)  # noqa: S102
    other = next(iter(made.values()))
    code = getattr(other, "fget", other).__code__
    return lambda patch: patch.setattr(function, "__code__", code)


def resolved(where: str) -> Any:
    """Return what has a name; a property as it stands in its class."""
    module, _, names = where.partition(":")
    *owners, name = names.split(".")
    owner = pkgutil.resolve_name(f"{module}:{'.'.join(owners)}" if owners else module)
    return vars(owner)[name]


def lone(words: str, **more: Any) -> Script:
    """Return the script of an instructor alone who says a row of words."""
    acts = tuple(Act(PACE_S, each) for each in words.split("|"))
    given: dict[str, Any] = {"seconds": PACE_S * len(acts) + 4.0, "ending": Ending.SIGNAL} | more
    exercise, fleet, speed = (given.pop(name, "") for name in ("exercise", "fleet", "speed"))
    tokens, later = given.pop("tokens", ()), given.pop("later", ())
    first = Player("instructor", (Visit(0.2, acts),), token=given.pop("token", ""))
    players = (first, *given.pop("others", ()))
    again = Life(2, 3.0 + (5.0 if later else 0.0), Ending.SIGNAL, 1, later)
    lives = (
        Life(1, turns=1, players=players, **given),
        *((again,) if given["ending"] is not Ending.SIGNAL else ()),
    )
    return Script(exercise, 0.0, speed or 1.0, lives, fleet=fleet or 0, tokens=tokens)


def newcomer(words: str, comes: float, role: str = "instructor", token: str = "") -> Player:
    """Return who comes later, and says a row of words, one each second."""
    acts = tuple(Act(1.0, each) for each in words.split("|"))
    return Player(role, (Visit(comes, acts),), token=token)


QUIET: Final = "|".join(10 * ["who"])
LATER: Final = (newcomer(2 * f"{QUIET}|" + "who", 0.4), newcomer(f"take command|{QUIET}", 0.6))
BUSES: Final = "freeze|casualty bus-port-lost|casualty bus-starboard-lost|step 4"  # two alerts
WORDS: Final = ("instructor=keel-0815-lead", "helm=oak-2207-wheel", "ballast=tide-4711-mast")
TEACHER: Final = "keel-0815-lead"
ORDERS: Final = "depth 80|rudder left 5|blow aft|status"
SCRIPTS: Final[Mapping[str, Script]] = {
    "jump": lone(
        "subscribe motion|subscribe gauges at 2 hz|freeze|step 4|snapshot A|step 4|restore A|"
        f"{QUIET}|restore A|step 6|backtrack 1 s|{QUIET}",
    ),
    "step": lone(
        "freeze|step 1000|step 1000|step 1000|backtrack 1 s|who|who|branch 1|who|step 3|who",
        laden=True,
    ),
    "run": lone("run|who|who|branch 1|who|step 3|replay 1 s|who|who|who|who|who"),
    "schedule": lone(
        "freeze|step 110|run",
        exercise="depth-changes",
        ending=Ending.KILLED,
        amidst=True,
        interleaving=1.0,
        seconds=1.3,
        speed=5.0,
    ),
    "schedule long ago": lone(
        f"freeze|step 150|{QUIET}", exercise="depth-changes", ending=Ending.KILLED
    ),
    "fleet": lone(
        "|".join(f"contact s{n} course 0{n}0" for n in range(10)),
        fleet=1,
        speed=20.0,
        instruments=True,
    ),
    "memory": lone(
        "freeze|step 90|snapshot A|step 90|replay 15 s|who|take over|step 50|backtrack 12 s|"
        "depth 90|step 60|branch 1|step 30|restore A|step 30|who"
    ),
    "give": lone(f"freeze|who|who|who|who|who|who|give command|{QUIET}", others=LATER),
    "keep": lone(
        "freeze|who|who|who|who|who|who|keep command" + 40 * "|who",
        others=LATER,
    ),
    "silent": lone("freeze" + 50 * "|who", others=LATER),
    "snapshot": lone(
        "freeze|step 4|snapshot A|who|who|who|who|who", ending=Ending.POWER, seconds=4
    ),
    "branch": lone(
        "freeze|step 4|backtrack 1 s|who|who|who|who|who", ending=Ending.POWER, seconds=4
    ),
    "mark": lone("freeze|step 4|mark here|who|who|who|who|who", ending=Ending.POWER, seconds=4),
    "order": lone("freeze|step 4|depth 80|who|who|who|who|who", ending=Ending.POWER, seconds=4),
    "whose": lone(
        f"{BUSES}|{QUIET}",
        others=(
            newcomer("who|who|ack 2|ack all|ack silent 2|who", 0.3, "planes"),
            newcomer("who|who|ack all|ack 1|who|who", 0.5, "ballast"),
        ),
    ),
    "seen, and killed": lone(
        f"{BUSES}|ack 1|ack silent 2|who|who|who|who|who", ending=Ending.KILLED, seconds=4
    ),
    "seen, and killed at the start": lone(
        f"{BUSES}|ack 1|snapshot A|reset|who|who|who|who",
        ending=Ending.KILLED,
        seconds=4,
        later=(newcomer("restore A|who", 0.3),),
    ),
    "seen, and back": lone(
        f"{BUSES}|snapshot A|restore A|step 2|ack 1|ack silent 2|who|restore A|step 10|"
        "backtrack 1 s|who|branch 2|who"
    ),
    "silent elsewhere": lone(
        f"{BUSES}|{QUIET}",
        others=(
            newcomer("who|who|who|who|who|who", 0.3, "planes"),
            newcomer("who|who|ack silent 2|who|who", 0.5, "ballast"),
        ),
    ),
    "silent for long": lone(
        f"{BUSES}|ack silent 2|who", others=(newcomer(4 * f"{QUIET}|" + "who", 0.4),), seconds=44
    ),
    "words": lone(
        f"freeze|step 4|{QUIET}",
        tokens=WORDS,
        token=TEACHER,
        others=(
            newcomer(ORDERS, 0.3, "helm", "oak-2207-wheel"),
            newcomer(ORDERS, 0.4, "helm", "oak-2207-wheels"),
            newcomer(ORDERS, 0.5, "ballast", "oak-2207-wheel"),
            newcomer(ORDERS, 0.6, "planes"),
            newcomer("planes tide-4711-mast|subscribe gauges", 0.7, "planes", "none"),
        ),
    ),
    "words after a kill": lone(
        "freeze|step 4|who|who|who",
        tokens=WORDS,
        token=TEACHER,
        ending=Ending.KILLED,
        later=(newcomer(ORDERS, 0.3, "helm"), newcomer("run|who|who", 0.5, token=TEACHER)),
    ),
    "several broken": lone(
        "freeze|casualty grounding-aft|casualty bow-slow|step 4|clear grounding-aft|step 60|"
        "clear all|step 60"
    ),
    "broken by degrees": lone(
        "freeze|casualty stern-slow 0.5 ramp 20|step 20|clear stern-slow|step 40|casualty "
        "flooding-aft 2|in 2 s casualty rudder-slow 0.3|step 20|clear all|step 40"
    ),
    "scheduled, and back": lone(
        f"freeze|step 250|who|backtrack 100 s|step 250|{QUIET}", exercise="rise-jam-shallow"
    ),
    "scheduled, and amid a kill": lone(
        "freeze|step 110|run",
        exercise="depth-changes",
        ending=Ending.KILLED,
        amidst=True,
        interleaving=1.0,
        seconds=1.3,
        speed=5.0,
        later=(newcomer("freeze|step 900|who|who", 0.3),),
    ),
    "scheduled, and killed": lone(
        f"freeze|step 111|{QUIET}",
        exercise="depth-changes",
        ending=Ending.KILLED,
        later=(newcomer("step 400|who|step 400|who", 0.3),),
    ),
}
SESSION, IO = "trainer.session", "trainer.io"
ALERTS, DAMAGE = f"{SESSION}.stations", "trainer.boat.casualties"
LOG = f"{ALERTS}.event_log:EventLog"
PLANTED: Final = tuple(
    Planted(kind, where, before, after, script)
    for kind, rows in {
        "nothing to the line after a jump": (
            (
                f"{SESSION}.stations.subscriptions:Subscription.wait",
                "self.seen is picture or",
                "self.seen and self.seen.tick > picture.tick or",
                "jump",
            ),
            (
                f"{SESSION}.stations.subscriptions:Publisher.offer",
                "if not self.roster.empty:",
                "if not self.roster.empty and pace.branch < 3:",
                "jump",
            ),
            (
                f"{SESSION}.stations.subscriptions:Publisher._run",
                "if self._offered is not None:",
                "if self._offered is not None and self._offered[2].branch == 1:",
                "jump",
            ),
            (
                f"{SESSION}.stations.display:SentenceDisplay.lines",
                "return [values]",
                "return [values] if frame.pace.branch == 1 else []",
                "jump",
            ),
        ),
        "time runs on after a jump": (
            (f"{SESSION}.past.control:Control._begin_again", "self.steps = 0", "pass", "step"),
            (f"{SESSION}.past.control:Control._return", "self.time.pacer.freeze()", "pass", "run"),
            (f"{SESSION}.past.control:Control._step", "+= int(", "+= 1 + int(", "step"),
            (f"{SESSION}.past.control:Control.stop", "self.time.pacer.freeze()", "pass", "run"),
        ),
        "an order of the schedule is given twice after a kill": (
            (
                f"{SESSION}.past.journal:Journal.include",
                "self.entry = given.entry + 1",
                "self.entry = given.entry",
                "schedule",
            ),
            (
                f"{SESSION}.resume:bring_up",
                "latest.after, latest.entry)",
                "latest.after)",
                "schedule long ago",
            ),
            (
                f"{SESSION}.resume:obey_anew",
                "history.include(entry)",
                "history.after = entry.id",
                "schedule",
            ),
            (
                f"{SESSION}.resume:bring_up",
                "latest.after, latest.entry)",
                "latest.after, max(latest.entry - 1, 0))",
                "schedule long ago",
            ),
        ),
        "a ship says by AIS what is not so": (
            (
                f"{SESSION}.nmea.transponders:Transponders._report",
                ".turning) *",
                ".turning) * -",
                "fleet",
            ),
            (
                f"{SESSION}.nmea.transponders:Transponders._report",
                "math.degrees(ship.heading)",
                "-math.degrees(ship.heading)",
                "fleet",
            ),
            (
                f"{SESSION}.nmea.transponders:Transponders._report",
                "ship.course",
                "ship.heading + 3.1",
                "fleet",
            ),
            (
                f"{SESSION}.nmea.transponders:Transponders._report",
                "ship.speed / KNOT",
                "ship.speed",
                "fleet",
            ),
            (
                f"{SESSION}.nmea.transponders:Transponders._report",
                "ship.north, ship.east",
                "ship.east, ship.north",
                "fleet",
            ),
            (f"{IO}.ais:rate_of_turn", "-size if degrees", "size if degrees", "fleet"),
            (
                f"{IO}.ais:_location",
                "(longitude, 28), (latitude, 27)",
                "(latitude, 28), (longitude, 27)",
                "fleet",
            ),
            (f"{IO}.ais:static_a", "ship.name, 20", "ship.name[1:], 20", "fleet"),
            (f"{IO}.ais:_sizes", "min(ship.bow, 511)", "min(ship.bow // 2, 511)", "fleet"),
        ),
        "a moment of another branch is kept in memory": (
            (f"{SESSION}.past.history:History.fork_at", "self.automatic.clear()", "pass", "memory"),
            (
                f"{SESSION}.past.history:History.fork_at",
                "self.automatic.forget_after(self.tick)",
                "pass",
                "memory",
            ),
            (
                f"{SESSION}.past.history:History.take_over",
                "self.automatic.forget_after(self.tick)",
                "pass",
                "memory",
            ),
            (
                f"{SESSION}.past.journal:Moments.forget_after",
                ".tick > tick:",
                ".tick > tick + 30:",
                "memory",
            ),
        ),
        "command comes to another": (
            (
                f"{SESSION}.people.command:Command.give",
                "taker = self.asker",
                "taker = None",
                "give",
            ),
            (
                f"{SESSION}.people.command:Command.tend",
                "self._pass_to(self.asker)",
                "self._pass_to(self._instructors()[1])",
                "silent",
            ),
            (
                f"{SESSION}.people.command:Command.keep",
                "self.asker, None",
                "self.asker, self.asker",
                "keep",
            ),
            (
                f"{SESSION}.people.command:Command.ask",
                "self.clock() + ANSWER",
                "self.clock() + 0.1 * ANSWER",
                "silent",
            ),
        ),
        "not on the disk in time": (
            (
                f"{IO}.recording.recording:Recording._has_promised",
                "in PROMISED_STATEMENTS",
                "in PROMISED_STATEMENTS[:3]",
                "snapshot",
            ),
            (
                f"{IO}.recording.recording:Recording._has_promised",
                "in PROMISED_STATEMENTS",
                "in PROMISED_STATEMENTS[1:]",
                "branch",
            ),
            (f"{IO}.recording.recording:Recording._has_promised", " or any(marks)", "", "mark"),
            (
                f"{IO}.recording.recording:Recording._has_promised",
                "in PROMISED_STATEMENTS",
                "in PROMISED_STATEMENTS[::3]",
                "order",
            ),
        ),
        "an alert is seen by another than whose it is": (
            (f"{LOG}._answerers", "if self.attended(role)]", "if not role]", "whose"),
            (f"{LOG}._answerers", "(TRAINEE, *manned)", '(TRAINEE, "planes", *manned)', "whose"),
            (f"{LOG}.acknowledge", "for number in wanted:", "for number in heard:", "whose"),
            (
                f"{LOG}.acknowledge",
                "if others := self._answerers(found, by):",
                (
                    "if (others := self._answerers(found, by)) and "
                    "self.alerts.see(found, 'helm', self._now):"
                ),
                "whose",
            ),
            (f"{LOG}.acknowledge", "by.role is not INSTRUCTOR_ROLE and heard", "False", "whose"),
        ),
        "an acknowledgement is lost": (
            (
                f"{LOG}._keep_note",
                "if not self.history.flown.replaying:",
                'if not (self.history.flown.replaying or note.step.value == "seen"):',
                "seen, and killed",
            ),
            (
                f"{ALERTS}.alerts:AlertBook.recall",
                "extend(notes)",
                'extend(n for n in notes if n.step.value != "seen")',
                "seen, and killed",
            ),
            (
                f"{SESSION}.run:fly_session",
                "session.event_log.recall_alerts()",
                "boat.ticks and session.event_log.recall_alerts()",
                "seen, and killed at the start",
            ),
            (
                f"{LOG}._follow_alerts",
                "-1 if ends else math.inf",
                "math.inf",
                "seen, and back",
            ),
            (
                f"{ALERTS}.alerts:AlertBook.follow",
                "known and stands(note.when)",
                'known and (stands(note.when) or note.step.value == "seen")',
                "seen, and back",
            ),
        ),
        "a silence says more than it should": (
            (
                f"{LOG}.silence",
                "self.own_alerts.silence(str(number), by.role.name",
                'self.own_alerts.silence(str(number), "ballast"',
                "whose",
            ),
            (
                f"{ALERTS}.own_alerts:OwnAlerts.silence",
                "+ SILENCE_S",
                "+ 1.3 * SILENCE_S",
                "silent for long",
            ),
            (
                f"{ALERTS}.own_alerts:OwnAlerts.follow",
                "said.tick <= moment.tick",
                "said",
                "seen, and back",
            ),
            (
                f"{LOG}.silence",
                "self.alerts.silence(alert, by.role.name",
                "self.alerts.see(alert, by.role.name",
                "whose",
            ),
        ),
        "an alert is told to be what it is not": (
            (f"{LOG}._state_of", "station.role.name)", '"ballast")', "silent elsewhere"),
            (f"{LOG}._state_of", "left > 0.0", "alert.silenced", "silent elsewhere"),
            (
                f"{LOG}._state_of",
                "left = self.own_alerts.silent_for(str(alert.number)",
                "left = 30.0 - 0.0 * self.own_alerts.silent_for(str(alert.number)",
                "silent elsewhere",
            ),
            (
                f"{ALERTS}.alerts:Alert.state",
                "not self.calls and",
                "not (self.calls and self.silenced) and",
                "silent elsewhere",
            ),
        ),
        "a door stands open": (
            (f"{ALERTS}.roles:Access.admits", "and bool(wanted)", "or bool(given)", "words"),
            (f"{ALERTS}.roles:Access.admits", "given.encode()", "given.encode()[:14]", "words"),
            (
                f"{ALERTS}.roles:Access.admits",
                "hmac.compare_digest(given.encode(), wanted.encode())",
                "given in self.tokens.values()",
                "words",
            ),
            (f"{ALERTS}.roles:Access.admits", "if not self.tokens:", "if not given:", "words"),
            (
                f"{ALERTS}.roles:Access.first",
                "STRANGER_ROLE if self.tokens",
                "STRANGER_ROLE if not self.tokens",
                "words",
            ),
            (
                f"{SESSION}.resume:options_as_begun",
                "record=path.parent,",
                "record=path.parent, token=(),",
                "words after a kill",
            ),
        ),
        "a line without its word is told something": (
            (f"{ALERTS}.roles:Access.hide", "in self.tokens.values()", "in ()", "words"),
            (
                f"{ALERTS}.station:Station.note",
                "and self.role is not STRANGER_ROLE",
                "",
                "words",
            ),
            (
                f"{SESSION}.attendance:Attendance._admit_newcomers",
                "station.role is not STRANGER_ROLE",
                "station",
                "words",
            ),
            (f"{ALERTS}.roles:hears_kind", "kind in role.events", "role", "words"),
        ),
        "other things are broken than was ordered": (
            (
                f"{DAMAGE}:_insert_parts",
                "part in casualty.parts:",
                "part in casualty.parts[1:]:",
                "several broken",
            ),
            (
                f"{DAMAGE}:clear_casualty",
                "each in casualty.broken]",
                "each in casualty.broken[:1]]",
                "several broken",
            ),
            (
                f"{DAMAGE}:clear_casualty",
                "slot in suffered:",
                "slot in suffered[:1]:",
                "broken by degrees",
            ),
            (f"{DAMAGE}:_insert_parts", "part.severity)", "1.0)", "several broken"),
        ),
        "something is broken by another degree, or not mended in its time": (
            (
                f"{DAMAGE}:insert_casualty",
                "_amount(boat, casualty, wanted)",
                "_amount(boat, casualty, casualty.severity)",
                "broken by degrees",
            ),
            (
                f"{DAMAGE}:insert_casualty",
                "boat.ticks_in(ramp)",
                "boat.ticks_in(casualty.ramp_s)",
                "broken by degrees",
            ),
            (f"{DAMAGE}:_end", "casualty.clear_ramp_s", "casualty.ramp_s", "broken by degrees"),
            (
                f"{DAMAGE}:_amount",
                "severity * casualty.full",
                "max(severity, 0.4) * casualty.full",
                "broken by degrees",
            ),
        ),
        "an order of the schedule is not given": (
            (
                f"{SESSION}.past.journal:Journal._restore",
                "self.after, self.entry = moment.after, moment.entry",
                "self.after = moment.after",
                "scheduled, and back",
            ),
            (
                f"{SESSION}.past.journal:Journal.order",
                "self.entry = entry + 1",
                "self.entry = entry + 2",
                "scheduled, and back",
            ),
            (
                f"{SESSION}.past.journal:Journal.include",
                "given.entry + 1",
                "given.entry + 2",
                "scheduled, and amid a kill",
            ),
            (
                f"{IO}.recording.queries:Past.moment",
                "else done + 1",
                "else done + 2",
                "scheduled, and back",
            ),
        ),
    }.items()
    for where, before, after, script in rows
)
