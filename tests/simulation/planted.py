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
    players = (Player("instructor", (Visit(0.2, acts),)), *given.pop("others", ()))
    lives = (
        Life(1, turns=1, players=players, **given),
        *((Life(2, 3.0, Ending.SIGNAL, 1, ()),) if given["ending"] is not Ending.SIGNAL else ()),
    )
    return Script(exercise, 0.0, speed or 1.0, lives, fleet=fleet or 0)


def instructor(words: str, comes: float) -> Player:
    """Return an instructor who comes later, and says a row of words, one each second."""
    acts = tuple(Act(1.0, each) for each in words.split("|"))
    return Player("instructor", (Visit(comes, acts),))


QUIET: Final = "|".join(10 * ["who"])
LATER: Final = (instructor(2 * f"{QUIET}|" + "who", 0.4), instructor(f"take command|{QUIET}", 0.6))
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
}
SESSION, IO = "trainer.session", "trainer.io"
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
    }.items()
    for where, before, after, script in rows
)
