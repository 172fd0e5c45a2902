"""The table of orders: every word, number and unit that an order line may hold.

The parser, the help text and docs/orders.md are all read from the tables below. A pattern is a row
of slots: `a|b` one of these words, `a=b` the spelling b stands for a, `[a]` may be left out,
CAPITALS are a number (``quantities``), a set of words (WORD_SETS), any name (NAME_SLOTS) or a
secret (TOKEN). The first word heads the order.
"""

import itertools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from trainer.io.orders.quantities import NUMBER_KINDS, Number
from trainer.units import DEGREE

# Starboard and rising are positive, as everywhere outside the core.
SIDE_SIGNS = {"left": -1.0, "right": 1.0, "dive": -1.0, "rise": 1.0}
# "Full" is worth the largest angle of the grammar; the boat's own limit is applied later.
FULL_RUDDER = 90.0 * DEGREE
WORD_SETS = {
    "SIDE": "left=port|right=starboard",
    "TILT": "dive|rise",
    "MODE": "manual|auto",
    "BOW": "bow=fairwater=sail",
    "AHEAD": "one-third=1/3|two-thirds=2/3|standard|full|flank",
    "ASTERN": "one-third=1/3|two-thirds=2/3|full",
    "GROUP": "forward|mid|aft|all",
    "TANK": "auxiliary|depth-control",
    "SPACE": "forward|centre=center|aft",
    "PART": "depth|position|tanks",
    "ROLE": "instructor|helm|planes|pilot|ballast|diving=officer|deck|observer|visitor|scope"
    "|trainee|class",
    "SHIP": "tanker|cargo|ferry|fishing|yacht|tug|submarine",
    "AXIS": "rudder|planes|speed|ballast",
    "SUPPLY": "normal|emergency|hand",
    "PIPE": "rudder|stern|bow|main|vital",
}
SESSION_TOPIC = "session"  # what `help` is asked for the other overview
WHICH_WAY = "say which way: {} or {}"
WHICH_PLANES = "which planes? say stern planes or bow planes"
GOING_WORDS = ("go", "come")  # before a direction that says what is meant
# Words that beginners type, and the order that the answer then suggests.
MEANT_ORDERS = {
    **dict.fromkeys(("pause", "hold"), "freeze"),
    **dict.fromkeys(("resume", "continue", "go", "start", "play"), "run"),
    **dict.fromkeys(("undo", "rewind"), "backtrack"),
    "save": "snapshot",
    "load": "restore",
    **dict.fromkeys(("break", "fail", "jam", "stuck", "fault", "failure"), "casualty"),
    **dict.fromkeys(("repair", "fix", "mend"), "clear"),
    **dict.fromkeys(("ship", "ships", "target", "vessel", "contacts"), "contact"),
    **dict.fromkeys(("look", "bearing", "mast"), "scope"),
    **dict.fromkeys(("tide", "stream", "drift"), "current"),
    **dict.fromkeys(("wave", "waves", "wind", "weather", "swell"), "sea"),
    **dict.fromkeys(("deep", "deeper", "shallow", "shallower", "up", "down"), "depth"),
    **dict.fromkeys(("descend", "ascend", "goto"), "depth"),
    **dict.fromkeys(("fast", "faster", "slow", "slower", "knots"), "speed"),
    **dict.fromkeys(("left", "right", "port", "starboard"), "rudder or course"),
    **dict.fromkeys(("throttle", "engine", "engines", "propeller"), "bell"),
    **dict.fromkeys(("where", "show", "state"), "status"),
}


@dataclass(frozen=True)
class Word:
    """A slot for one word: pairs of a spelling and the word it stands for."""

    spellings: tuple[tuple[str, str], ...]


@dataclass(frozen=True)
class UnitWord:
    """A slot for the unit of the number before it."""

    number: Number


@dataclass(frozen=True)
class Name:
    """A slot for a name that only the session knows, such as a casualty's."""

    says: str


@dataclass(frozen=True)
class Secret:
    """A slot for a secret word, which is taken as typed and never shown."""


Slot = Word | Number | UnitWord | Name | Secret


@dataclass(frozen=True)
class Form:
    """One wording of an order. A wrong but likely one has the right one as its refusal."""

    pattern: str
    says: str = ""
    name: str = ""  # of the order, where it is not the head
    value: float = 0.0  # [SI, rad]  where the wording has no number
    refusal: str = ""


NAME_SLOTS = {
    "NAME": Name("the name of a casualty"),
    "SHIP_NAME": Name("the name of a contact"),
    "LABEL": Name("a name for a moment"),
    "OWN_ALERT": Name("the name of an alert of a page's own"),
    "CALLED": Name("a name for a station"),
    "CHANNEL": Name("the name of a channel"),
    "EXERCISE": Name("the name of an exercise"),
    "CONDITION": Name("a condition such as depth > 60"),
    "ORDER": Name("an order"),  # both of many words: see trainer.io.orders.grammar
    "REMARK": Name("words"),  # of any kind: see trainer.io.orders.grammar
}

FORMS = (
    Form("depth DEPTH", "keep this depth"),
    Form("depth auto", "depth keeping automatic again"),
    Form("course=heading COURSE", "keep this course; 360 is 000"),
    Form("course=heading SIDE CHANGE", "change course by so much", name="course-by"),
    Form("course=heading SIDE to COURSE", "keep this course, turning that way", name="course-to"),
    Form("course=heading steady", "keep the heading of this moment"),
    Form("course=heading auto", "course keeping automatic again"),
    Form("speed SPEED", "keep this speed through the water"),
    Form("speed auto", "speed keeping automatic again"),
    Form("turns TURNS", "revolutions that give this speed, held constant"),
    Form("rpm RPM", "revolutions a minute, held constant"),
    Form("[bell] ahead AHEAD", "engine order ahead"),
    Form("bell stop", "propeller stopped"),
    Form("[bell] astern ASTERN", "engine order astern"),
    Form("stop", refusal="stop what? say bell stop, freeze or quit"),
    Form("rudder SIDE ANGLE", "rudder by hand, to this angle"),
    Form("rudder SIDE full=hard", "rudder by hand, hard over", value=FULL_RUDDER),
    Form("[rudder] full=hard SIDE", "the same", value=FULL_RUDDER),
    Form("rudder amidships=midships=zero", "rudder by hand, to zero"),
    Form("rudder ease ANGLE", "rudder eased to this angle, on the same side"),
    Form("rudder shift", "rudder to the same angle on the other side"),
    Form("rudder meet", "rudder against the swing until it stops, then amidships"),
    Form("rudder MODE", "by hand, or automatic"),
    Form("rudder ANGLE", refusal=WHICH_WAY.format("rudder left", "rudder right")),
    Form("stern [planes] TILT ANGLE", "stern planes by hand, to this angle"),
    Form("stern [planes] TILT full", "stern planes by hand, as far as they go", value=FULL_RUDDER),
    Form("stern [planes] zero", "stern planes by hand, to zero"),
    Form("stern [planes] MODE", "by hand, or automatic"),
    Form(
        "stern [planes] ANGLE", refusal=WHICH_WAY.format("stern planes dive", "stern planes rise")
    ),
    Form("BOW [planes] TILT ANGLE", "bow planes by hand, to this angle"),
    Form("BOW [planes] TILT full", "bow planes by hand, as far as they go", value=FULL_RUDDER),
    Form("BOW [planes] zero", "bow planes by hand, to zero"),
    Form("BOW [planes] MODE", "by hand, or automatic"),
    Form("BOW [planes] ANGLE", refusal=WHICH_WAY.format("bow planes dive", "bow planes rise")),
    Form("planes MODE", "both pairs by hand, or automatic"),
    Form("planes zero", "both pairs by hand, to zero"),
    Form("planes TILT", refusal=WHICH_PLANES),
    Form("planes TILT ANGLE", refusal=WHICH_PLANES),
    Form("lever TILT ANGLE", "both pairs by one lever: bow to this angle, stern to 0.6 of it"),
    Form("lever zero", "both pairs by one lever, to zero"),
    Form("autopilot on|off", "everything automatic, or by hand"),
    Form("autopilot trainer|report|literal", "which law of control it follows"),
    Form("surface", "blow main ballast and come up"),
    Form("dive", "open the main vents, blows shut"),
    Form("periscope [depth]", "keep the boat's periscope depth"),
    Form("scope raise|lower", "the periscope's mast out, or in"),
    Form("scope train TRAIN", "turn it to an angle from the bow, clockwise"),
    Form("scope power 1.5|6", "its magnification"),
    Form("scope range MAST", "distance of the ship at the wire, from its masthead's height"),
    Form("blow GROUP", "blow main ballast, its vents shut"),
    Form("blow stop", "shut all blow valves and the negative tank"),
    Form("emergency blow", "blow all main ballast from both banks"),
    Form("vent GROUP open|shut", "main vents"),
    Form("negative flood|blow", "fill the negative tank, or empty it by air"),
    Form("flood TANK AMOUNT", "let in so much from the sea"),
    Form("pump TANK AMOUNT", "pump so much out to the sea"),
    Form("pump trim forward|aft AMOUNT", "move trim water that way"),
    Form("trim MODE", "by hand, or by the pumps as the planes show it"),
    Form("drain SPACE", "pump a flooded compartment out"),
    Form("drain stop", "stop draining"),
    Form("hover on|off", "keep the present depth by the depth-control tank"),
    Form("hover DEPTH", "keep this depth by it"),
    Form("compressor on|off", "charge the air banks"),
    Form("rudder SUPPLY", "shift what moves it: main oil, vital oil, or hands", name="rudder-mode"),
    Form("stern [planes] SUPPLY", "shift what moves them, likewise", name="planes-mode"),
    Form("BOW [planes] SUPPLY", "shift what moves them, likewise", name="planes-mode"),
    Form("planes SUPPLY", "shift what moves both pairs", name="planes-mode"),
    Form("isolate PIPE", "shut the valve of a surface's leg, or of main or vital oil"),
    Form("open PIPE", "open it again"),
    Form("hydraulic pump 1|2|vital run|stop", "a pump of oil: run and stand by, or stop"),
    Form("bus tie shut|open", "let one side's battery feed both buses, or not"),
    Form("breaker port|starboard shut|open", "a side's battery on its bus, or off it"),
    Form("loads shed|back", "take the loads off that can be spared, or put them back"),
    Form("ventilation secure|run|exhaust", "stop it, run it, or exhaust smoke"),
    Form("fight fire forward|control|aft", "send the party to a compartment's fire"),
    Form("sea state DEGREE", "raise the sea of this degree"),
    Form("sea wind WIND", "raise the sea of this wind"),
    Form("sea height HEIGHT", "raise a sea of this significant height"),
    Form("sea from COURSE", "turn the sea, to come from there"),
    Form("sea calm", "let the sea go down"),
    Form("contact add SHIP_NAME SHIP at NORTH EAST course COURSE speed SPEED", "add a ship"),
    Form("contact SHIP_NAME course COURSE", "turn it to a course, the shorter way round"),
    Form("contact SHIP_NAME speed SPEED", "its speed over the ground, on the way it has"),
    Form("contact SHIP_NAME move NORTH EAST", "put it elsewhere; it goes straight on"),
    Form("contact SHIP_NAME remove", "take it away"),
    Form(
        "contact boat BOAT at NORTH EAST depth DEPTH course COURSE speed SPEED",
        "another boat of the class is there; it goes straight on",
    ),
    Form("contact boats gone", "take the other boats of the class away"),
    Form("current set COURSE drift DRIFT", "let the water go that way, towards it, so fast"),
    Form("current off", "let it stand still over the ground"),
    Form("casualty NAME", "as severe and sudden as its table says"),
    Form("casualty NAME SEVERITY", "as severe as this"),
    Form("casualty NAME ramp SECONDS", "growing over this time"),
    Form("casualty NAME SEVERITY ramp SECONDS", "both"),
    Form("clear NAME", "clear a casualty, or all"),
    Form("in TIME ORDER", "plan an order, for so long from now", name="plan"),
    Form("at TIME ORDER", "plan an order, for this time since the start", name="plan"),
    Form("when CONDITION then ORDER", "plan an order, for when this first holds", name="plan"),
    Form("plans", "the orders that are ahead, the exercise's own too"),
    Form("cancel PLAN", "take the planned order of this number away"),
    Form("cancel all", "take all away that were planned"),
    Form("casualties", "what can break: name, severity and ramp unless ordered"),
    Form("freeze", "stop time; orders are still taken"),
    Form("freeze PART", "hold this still, while time goes on", name="hold"),
    Form("release PART", "let this move again"),
    Form("release all", "let everything move again"),
    Form("run", "let time go on"),
    Form("step COUNT", "so many ticks, then frozen again"),
    Form("step", "one tick, then frozen again", value=1.0),
    Form("time FACTOR", "time so many times faster than the clock"),
    Form("time max", "time as fast as the machine can"),
    Form("snapshot LABEL", "keep this moment under this name"),
    Form("snapshots", "the moments kept"),
    Form("restore LABEL", "go back to a moment kept"),
    Form("reset", "go back to the start"),
    Form("backtrack LAPSE", "go back by so much"),
    Form("replay LAPSE", "go back by so much, and give the orders again as they were given"),
    Form("take over", "end the replay here, and go on"),
    Form("branches", "what has been flown: each branch, from when, why, and its last moment"),
    Form("branch BRANCH", "go back to the end of that branch, and on from there"),
    Form("end exercise", "end the exercise here: time stands still, the session goes on"),
    Form("release marks", "let everybody have the marks", name="release-marks"),
    Form("debrief", "write the debrief of what has been flown so far"),
    Form("what now", refusal="say hint, which tells what to order now, briefing or status"),
    Form("what if ORDER", "the marks still to be had with an order and without", name="what-if"),
    Form("again", "the exercise again, from the start"),
    Form("again from LABEL", "from a moment kept, or from `here`: the end comes at its time"),
    Form("again from LAPSE", "from so long ago"),
    Form("restart", "the exercise again, from the start, and time goes on at once"),
    Form("next", "the exercises there are"),
    Form("next course", "what follows in the class's course, once the marks are reached"),
    Form("next EXERCISE", "end this one, and begin that one at the same stations"),
    Form("demonstrate", "have the reference crew show the way from here, for 2 min", value=120.0),
    Form("demonstrate for LENGTH", "for so long; then back to this moment, frozen"),
    Form("demonstrate off", "end that now"),
    Form("hint", "what to order now, and what it is worth; it costs marks"),
    Form("ghost on|off", "the reference crew's run from the start beside yours, or not"),
    Form("predictor REACH", "where depth, pitch and heading go, with the controls as they stand"),
    Form("predictor off", "no longer"),
    Form("take command", "ask for command, where there are several instructors", name="command"),
    Form("give command", "let the instructor who asked have it"),
    Form("keep command", "refuse it"),
    Form("ready", "this station is ready for the exercise to begin"),
    Form("role ROLE", "what this line may do; who is alone may change it"),
    Form("role ROLE TOKEN", "the same, where the session asks for a token"),
    Form("subscribe CHANNEL", "have what it shows sent whenever it changes"),
    Form("subscribe CHANNEL at RATE", "at most so many times a second"),
    Form("unsubscribe CHANNEL", "no longer, or none at all: unsubscribe all"),
    Form("history CHANNEL", "what it has shown in the last hour", value=3600.0),
    Form("history CHANNEL LAPSE", "what it has shown for so long; also of `events`"),
    Form("order course COURSE", "order the crew to steer it, the shorter way round"),
    Form("order course SIDE COURSE", "the same, turning that way"),
    Form("order depth DEPTH", "order the crew to this depth"),
    Form("order course steady", "order the crew to steer the heading of this moment"),
    Form("order periscope", "order the crew to the boat's periscope depth"),
    Form("order periscope depth", "the same"),
    Form("order speed SPEED", "order the crew to this speed"),
    Form("order pitch ANGLE up|down", "order the crew to hold this angle, bow up or down"),
    Form("order pitch zero", "order the crew to an even keel"),
    Form("order clear course|depth|speed|pitch|all", "an order to the crew stands no longer"),
    Form("tell REMARK", "an order to the crew in other words"),
    Form("report REMARK", "report to the instructor, as the crew does"),
    Form("aye", "the newest order to the crew repeated; also its words: course 045 aye"),
    Form("have AXIS", "say that this station works it from now on: I have the planes"),
    Form("relief REMARK", "that person has the watch at this station from now on"),
    Form("belay", "the newest order to the crew stands no longer"),
    Form("belay course|depth|speed|pitch|words", "that on one axis, or in words"),
    Form("allow AXIS", "let these be automatic, though in hand; the run then has no marks"),
    Form("alerts", "the alerts that are open; to an instructor also the last that are over"),
    Form("ack ALERT", "the alert of this number has been seen"),
    Form("ack all", "all that are an instructor's to acknowledge have been seen"),
    Form("ack silent ALERT", "it is silent at this station for 30 s"),
    Form("ack seen OWN_ALERT", "an alert that a page has found has been seen at its station"),
    Form("ack silent OWN_ALERT", "it is silent there for 30 s"),
    Form("ack over OWN_ALERT", "it is over: it sounds when it comes again"),
    Form("mark", "mark this moment in the record"),
    Form("mark REMARK", "the same, with a remark of any words"),
    Form("log", "the last of what has happened", value=10.0),
    Form("log COUNT", "so many of them"),
    Form("briefing", "what the exercise is about"),
    Form("who", "the stations attached"),
    Form("name CALLED", "what this station is called in that list, such as wall"),
    Form("detach=bye", "leave the session, which goes on"),
    Form("status", "everything about the boat, once"),
    Form("status CHANNEL", "what a channel shows, once"),
    Form("help", "the list of orders"),
    Form("help TOPIC", "all about one order"),
    Form("quit=exit", "end the session"),
)


def read_slot(text: str) -> Word | Number | Name | Secret:
    """Return the slot that one item of a pattern stands for."""
    if text in NUMBER_KINDS:
        return NUMBER_KINDS[text]
    if text in NAME_SLOTS:
        return NAME_SLOTS[text]
    if text == "TOKEN":
        return Secret()
    return topic_slot() if text == "TOPIC" else Word(tuple(spellings(WORD_SETS.get(text, text))))


def topic_slot() -> Word:
    """Return the slot for what help may be asked about."""
    heads = (form.pattern.split()[0].strip("[]") for form in FORMS if not form.refusal)
    known = dict(pair for head in heads for pair in spellings(WORD_SETS.get(head, head)))
    return Word((*known.items(), (SESSION_TOPIC, SESSION_TOPIC)))


def spellings(text: str) -> Iterator[tuple[str, str]]:
    """Yield each spelling in `a=b|c` with the word it stands for."""
    for alternative in text.split("|"):
        names = alternative.split("=")
        yield from ((name, names[0]) for name in names)


def variants(form: Form) -> Iterator[tuple[Slot, ...]]:
    """Yield every row of slots that the form allows, with and without the optional ones."""
    items: list[list[tuple[Slot, ...]]] = []
    for text in form.pattern.split():
        item = read_slot(text.strip("[]"))
        items.append([(item,)])
        if text.startswith("["):
            items[-1].append(())
        if isinstance(item, Number) and item.units[0].names:
            items.append([(), (UnitWord(item),)])
    for row in itertools.product(*items):
        yield tuple(itertools.chain.from_iterable(row))


def heading_word(form: Form) -> str:
    """Return the word that heads the form, also where it may be left out."""
    first = form.pattern.split()[0].strip("[]")
    return next(word for _, word in spellings(WORD_SETS.get(first, first)))


def word_of(form: Form) -> str:
    """Return the name of the order that a form words."""
    return form.name or heading_word(form)


def _forms_by_word() -> dict[str, tuple[Form, ...]]:
    found: dict[str, list[Form]] = {}
    for form in FORMS:
        if not form.refusal:
            found.setdefault(word_of(form), []).append(form)
    return {name: tuple(forms) for name, forms in found.items()}


# The wordings of each order, without those that are refused.
FORMS_BY_WORD: Mapping[str, Sequence[Form]] = _forms_by_word()
HELP_TOPICS = tuple(dict.fromkeys(heading_word(form) for form in FORMS if not form.refusal))
# Orders whose words a person is free to choose; those of all others are the grammar's.
REMARK_ORDERS = {word_of(form) for form in FORMS if form.pattern.endswith(" REMARK")}
