"""The table of orders: every word, number and unit that an order line may hold.

The parser, the help text and docs/orders.md are all read from the tables below. A pattern is a row
of places: `a|b` one of these words, `a=b` the spelling b stands for a, `[a]` may be left out,
CAPITALS are a number (NUMBERS), a set of words (SETS) or any name (NAME). The first word heads the
order.
"""

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass

KNOT = 1852.0 / 3600.0  # [m/s]  exact: 1852 m in an hour
FOOT = 0.3048  # [m]  exact
DEGREE = math.pi / 180.0  # [rad]
MINUTE = 60.0  # [s]

# Starboard and rising are positive, as everywhere outside the core.
SIGNS = {"left": -1.0, "right": 1.0, "dive": -1.0, "rise": 1.0}


@dataclass(frozen=True)
class Unit:
    """A unit: how it is written back ("" when it is understood), its spellings, its size in SI."""

    text: str
    names: tuple[str, ...]
    factor: float


@dataclass(frozen=True)
class Number:
    """A kind of number; the limits are in its first unit, the one understood when none is given."""

    says: str
    units: tuple[Unit, ...]
    low: float
    high: float
    decimals: int = 9
    prefix: str = ""  # may be stuck before the digits

    @property
    def limits(self) -> str:
        """Return the limits in words, with their unit."""
        return f"{self.low:g} to {self.high:g} {''.join(self.units[0].names[:1])}".rstrip()


@dataclass(frozen=True)
class Word:
    """A place for one word: pairs of a spelling and the word it stands for."""

    spellings: tuple[tuple[str, str], ...]


@dataclass(frozen=True)
class UnitWord:
    """A place for the unit of the number before it."""

    number: Number


@dataclass(frozen=True)
class Name:
    """A place for a name that the grammar does not know, such as a casualty's."""

    says: str


Place = Word | Number | UnitWord | Name


@dataclass(frozen=True)
class Form:
    """One wording of an order; a refusal answers a tempting wrong one with the right one."""

    pattern: str
    says: str = ""
    name: str = ""  # of the order, where it is not the head
    value: float = 0.0  # [SI, rad]  where the wording has no number
    refusal: str = ""


@dataclass(frozen=True)
class Topic:
    """One line of the overview: the heads of its orders, how to type them, what they do."""

    heads: tuple[str, ...]
    example: str
    says: str


DEGREES = Unit("", ("deg", "degrees", "degree"), DEGREE)
METRES = Unit("m", ("m", "metres", "metre", "meters", "meter"), 1.0)
FEET = Unit("ft", ("ft", "feet", "foot"), FOOT)
KNOTS = Unit("kn", ("kn", "knots", "knot", "kts", "kt"), KNOT)
METRES_PER_SECOND = Unit("m/s", ("m/s", "mps"), 1.0)
PER_MINUTE = Unit("", ("rpm",), 1.0 / MINUTE)
TONNES = Unit("t", ("t", "tonnes", "tonne", "tons", "ton"), 1000.0)
SECONDS = Unit("s", ("s", "seconds", "second", "sec"), 1.0)
PLAIN = Unit("", (), 1.0)

NUMBERS = {
    "DEPTH": Number("a depth", (METRES, FEET), 0.0, 2000.0),
    "COURSE": Number("a course", (DEGREES,), 0.0, 360.0),
    "CHANGE": Number("a change of course", (DEGREES,), 0.0, 360.0),
    "ANGLE": Number("an angle", (DEGREES,), 0.0, 90.0),
    "SPEED": Number("a speed", (KNOTS, METRES_PER_SECOND), 0.0, 60.0),
    "TURNS": Number("a speed, negative astern", (KNOTS, METRES_PER_SECOND), -60.0, 60.0),
    "RPM": Number("a rate of revolutions, negative astern", (PER_MINUTE,), -2000.0, 2000.0),
    "FACTOR": Number("a time speed", (Unit("", ("x",), 1.0),), 0.1, 100.0, prefix="x"),
    "COUNT": Number("a number of ticks", (PLAIN,), 1.0, 1000.0, decimals=0),
    "DEGREE": Number("a sea state", (PLAIN,), 0.0, 8.0, decimals=0),
    "WIND": Number("a wind", (KNOTS, METRES_PER_SECOND), 0.0, 100.0),
    "HEIGHT": Number("a significant height", (METRES, FEET), 0.0, 25.0),
    "AMOUNT": Number("an amount of water", (TONNES,), 0.0, 1000.0),
    "SEVERITY": Number("a severity after a name like stern-stuck", (PLAIN,), -1000.0, 1000.0),
    "SECONDS": Number("a time", (SECONDS,), 0.0, 3600.0),
}

# A "full" rudder is worth the largest angle of the grammar; the boat's own limit is applied later.
FULL_RUDDER = 90.0 * DEGREE

SETS = {
    "SIDE": "left=port|right=starboard",
    "TILT": "dive|rise",
    "MODE": "manual|auto",
    "BOW": "bow=fairwater=sail",
    "AHEAD": "one-third=1/3|two-thirds=2/3|standard|full|flank",
    "ASTERN": "one-third=1/3|two-thirds=2/3|full",
    "GROUP": "forward|mid|aft|all",
    "TANK": "auxiliary|depth-control",
    "SPACE": "forward|centre=center|aft",
}
CASUALTY = Name("the name of a casualty")

# One line each in the overview, which must fit in 24 lines of 79 columns.
TOPICS = (
    Topic(("depth",), "depth 80 | 260 ft | auto", "keep a depth"),
    Topic(("course",), "course 090 | left 30 | auto", "keep a course, or change it"),
    Topic(("speed",), "speed 12 | 6 m/s | auto", "keep a speed, in knots"),
    Topic(("turns", "rpm"), "turns 12 | rpm 80", "revolutions, held constant"),
    Topic(("bell",), "bell ahead standard | stop", "engine order; `ahead 2/3` is enough"),
    Topic(("rudder",), "rudder left 15 | amidships", "also right, full, manual, auto"),
    Topic(("stern",), "stern planes dive 10", "also rise, zero, manual, auto"),
    Topic(("bow",), "bow planes rise 10", "also dive, zero, manual, auto"),
    Topic(("planes",), "planes manual | auto", "both pairs of planes at once"),
    Topic(("autopilot",), "autopilot on | off | report", "switch it, or choose its law"),
    Topic(
        ("surface", "dive", "periscope"),
        "surface | dive | periscope depth",
        "blow and come up; flood; periscope",
    ),
    Topic(("blow", "emergency"), "blow all | stop | emergency blow", "main ballast; also mid, aft"),
    Topic(("vent", "negative"), "vent all open | negative flood", "air out; the negative tank"),
    Topic(
        ("flood", "pump", "drain"), "flood auxiliary 5 | pump | drain", "trim: tonnes to be moved"
    ),
    Topic(("hover", "compressor"), "hover on | compressor on", "keep depth stopped; charge air"),
    Topic(("sea",), "sea state 5 | wind 30 | calm", "also height 3 m, from 045"),
    Topic(("casualty", "clear"), "casualty NAME | clear all", "also casualty NAME 0.5 ramp 30"),
    Topic(("freeze", "run", "step"), "freeze | run | step 10", "stop time, let it go on, 10 ticks"),
    Topic(("time",), "time x2 | max", "speed of time"),
    Topic(("status",), "status", "everything about the boat, once"),
    Topic(("help",), "help rudder", "all about one order"),
    Topic(("quit",), "quit", "end the session"),
)

WHICH_WAY = "say which way: {} or {}"
WHICH_PLANES = "which planes? say stern planes or bow planes"

FORMS = (
    Form("depth DEPTH", "keep this depth"),
    Form("depth auto", "depth keeping automatic again"),
    Form("course=heading COURSE", "keep this course; 360 is 000"),
    Form("course=heading SIDE CHANGE", "change course by so much", name="course-by"),
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
    Form("rudder MODE", "by hand, or automatic"),
    Form("rudder ANGLE", refusal=WHICH_WAY.format("rudder left", "rudder right")),
    Form("stern [planes] TILT ANGLE", "stern planes by hand, to this angle"),
    Form("stern [planes] zero", "stern planes by hand, to zero"),
    Form("stern [planes] MODE", "by hand, or automatic"),
    Form(
        "stern [planes] ANGLE", refusal=WHICH_WAY.format("stern planes dive", "stern planes rise")
    ),
    Form("BOW [planes] TILT ANGLE", "bow planes by hand, to this angle"),
    Form("BOW [planes] zero", "bow planes by hand, to zero"),
    Form("BOW [planes] MODE", "by hand, or automatic"),
    Form("BOW [planes] ANGLE", refusal=WHICH_WAY.format("bow planes dive", "bow planes rise")),
    Form("planes MODE", "both pairs by hand, or automatic"),
    Form("planes TILT ANGLE", refusal=WHICH_PLANES),
    Form("planes zero", refusal=WHICH_PLANES),
    Form("autopilot on|off", "everything automatic, or by hand"),
    Form("autopilot trainer|report|literal", "which law of control it follows"),
    Form("surface", "blow main ballast and come up"),
    Form("dive", "open the main vents, blows shut"),
    Form("periscope [depth]", "keep the boat's periscope depth"),
    Form("blow GROUP", "blow main ballast, its vents shut"),
    Form("blow stop", "shut all blow valves and the negative tank"),
    Form("emergency blow", "blow all main ballast from both banks"),
    Form("vent GROUP open|shut", "main vents"),
    Form("negative flood|blow", "fill the negative tank, or empty it by air"),
    Form("flood TANK AMOUNT", "let in so much from the sea"),
    Form("pump TANK AMOUNT", "pump so much out to the sea"),
    Form("pump trim forward|aft AMOUNT", "move trim water that way"),
    Form("drain SPACE", "pump a flooded compartment out"),
    Form("drain stop", "stop draining"),
    Form("hover on|off", "keep the present depth by the depth-control tank"),
    Form("compressor on|off", "charge the air banks"),
    Form("sea state DEGREE", "raise the sea of this degree"),
    Form("sea wind WIND", "raise the sea of this wind"),
    Form("sea height HEIGHT", "raise a sea of this significant height"),
    Form("sea from COURSE", "turn the sea, to come from there"),
    Form("sea calm", "let the sea go down"),
    Form("casualty NAME", "as severe and sudden as its table says"),
    Form("casualty NAME SEVERITY", "as severe as this"),
    Form("casualty NAME ramp SECONDS", "growing over this time"),
    Form("casualty NAME SEVERITY ramp SECONDS", "both"),
    Form("clear NAME", "clear a casualty, or all"),
    Form("freeze", "stop time; orders are still taken"),
    Form("run", "let time go on"),
    Form("step COUNT", "so many ticks, then frozen again"),
    Form("step", "one tick, then frozen again", value=1.0),
    Form("time FACTOR", "time so many times faster than the clock"),
    Form("time max", "time as fast as the machine can"),
    Form("status", "everything about the boat, once"),
    Form("help", "the list of orders"),
    Form("help TOPIC", "all about one order"),
    Form("quit=exit", "end the session"),
)


def place(text: str) -> Word | Number | Name:
    """Return the place that one item of a pattern stands for."""
    if text in NUMBERS:
        return NUMBERS[text]
    if text == "NAME":
        return CASUALTY
    if text == "TOPIC":
        heads = (form.pattern.split()[0].strip("[]") for form in FORMS if not form.refusal)
        names = {head for topic in TOPICS for head in topic.heads}
        words = dict(pair for head in heads for pair in spellings(SETS.get(head, head)))
        return Word(tuple((said, word) for said, word in words.items() if word in names))
    return Word(tuple(spellings(SETS.get(text, text))))


def spellings(text: str) -> Iterator[tuple[str, str]]:
    """Yield each spelling in `a=b|c` with the word it stands for."""
    for alternative in text.split("|"):
        names = alternative.split("=")
        yield from ((name, names[0]) for name in names)


def variants(form: Form) -> Iterator[tuple[Place, ...]]:
    """Yield every row of places that the form allows, with and without what may be left out."""
    items: list[list[tuple[Place, ...]]] = []
    for text in form.pattern.split():
        item = place(text.strip("[]"))
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
    return next(word for _, word in spellings(SETS.get(first, first)))
