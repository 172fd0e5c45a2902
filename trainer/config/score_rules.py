"""The measures by name, and the tables ``[[scores]]`` that are checked against them."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from typing import Final

from trainer.config.casualties import Casualty
from trainer.config.derived import EVERY, Condition, compile_conditions, parse_name
from trainer.config.derived import nearest_quantity as guess
from trainer.config.files import ConfigError, Place, collecting, nearest, refuse
from trainer.config.schema import Choice, Choices, Quantity, Rows, Text, above, of, optional, within
from trainer.config.sound_rows import Readers, sound_rows
from trainer.core.surfaces import SURFACES
from trainer.io.orders.schedule import LATEST
from trainer.io.orders.table import BOAT_ORDERS, CREW_TALK

ITS_OWN: Final = ""  # the unit of a measure that is a quantity's
COURSE: Final = "course"  # a quantity beside those of conditions: it goes round
ORDERED: Final[Mapping[str, str]] = {  # places of the state that hold what is ordered
    "depth": "ordered_depth",
    COURSE: "ordered_psi",
    "speed": "ordered_speed",
}
TANKS: Final = ("bank_main", "bank_emergency")
TIMELESS: Final = ("response",)  # look at the whole record
WINDOW: Final = ("since", "from_s", "to_s", "when")
ENOUGH: Final = within(-1e9, 1e9)
# orders of the instructor, and words, which answer no casualty
INSTRUCTING: Final = (
    frozenset({"casualty", "clear", "sea", "current", "contact", "hold", "release"}) | CREW_TALK
)
PARTS: Final = ("task", "answer", "keeping")
ANSWERS: Final = tuple(sorted(BOAT_ORDERS - INSTRUCTING))
OF_ITSELF: Final = ("final", "largest")  # without a target
# what a rule may say for some measures only
OPTIONAL: Final = ("quantity", "target", "band", "casualty", "orders", *WINDOW)


@dataclass(frozen=True)
class Measure:
    """One measure: what a rule must and may say, its unit, and its formula."""

    unit: str  # ITS_OWN: that of the quantity
    formula: str  # {q} the quantity, {t} its target, {b} its band, {u} their unit, {c} the casualty
    place: str  # which moment is told
    needs: tuple[str, ...] = ()
    may: tuple[str, ...] = ()
    quantities: tuple[str, ...] = ()  # the only ones it takes; () any


MEASURES: Final[Mapping[str, Measure]] = {
    "overshoot": Measure(
        ITS_OWN,
        "furthest of {q} beyond {t}, seen from where it began; no value short of it{by}",
        "the furthest",
        needs=("quantity", "target"),
        may=("band",),
    ),
    "time-to": Measure(
        "s",
        "time until {q} is within {b} of {t} and stays there to the end",
        "when it is",
        needs=("quantity", "target", "band"),
    ),
    "reach": Measure(
        "s",
        "time until {q} is within {b} of {t} and stays there; no value if it was there at once",
        "when it is",
        needs=("quantity", "target", "band"),
    ),
    "settled": Measure(
        "%",
        "share of the last 120 s with {q} within {b} of {t}; no value if it was there at once",
        "the furthest from it",
        needs=("quantity", "target", "band"),
    ),
    "final": Measure(ITS_OWN, "{q} at the end{f}", "the end", needs=("quantity",), may=("target",)),
    "rms": Measure(
        ITS_OWN,
        "root of the mean of ({q} - {t})^2, a term for each tick",
        "the furthest from it",
        needs=("quantity",),
        may=("target",),
    ),
    "in-band": Measure(
        "%",
        "share of the ticks with {q} within {b} of {t}",
        "the furthest from it",
        needs=("quantity", "band"),
        may=("target",),
    ),
    "highest": Measure(ITS_OWN, "greatest {q}", "when it was", needs=("quantity",)),
    "lowest": Measure(ITS_OWN, "least {q}", "when it was", needs=("quantity",)),
    "largest": Measure(
        ITS_OWN, "greatest {q} either way{f}", "when it was", needs=("quantity",), may=("target",)
    ),
    "activity": Measure(
        "deg/min",
        "sum of what {q} moved from tick to tick, by the time",
        "the fastest",
        may=("quantity",),
        quantities=tuple(SURFACES),
    ),
    "distance": Measure("m", "sum of the way over the ground from tick to tick", "the last"),
    "closest-approach": Measure(
        "m", "least range to any ship, middle to middle, straight between ticks", "when it was"
    ),
    "exposed": Measure(
        "s",
        "number of ticks with the periscope's head out of the water, times the step",
        "the first",
    ),
    "exposed-raise": Measure("s", "the same of the raise of the mast that has most", "its first"),
    "time-to-detect": Measure(
        "s",
        "longest time from when a ship came in sight to a mark of it: `mark contact 045`, "
        "within 3 deg; 30 s more for each mark of no ship seen; no value where a ship was not "
        "marked, or not seen that a raised mast would have shown for 2 min",
        "the mark",
    ),
    "broaches": Measure(
        "-",
        "times that sail or deck came out of the sea, main ballast not being blown",
        "the first",
    ),
    "aground": Measure(
        "-",
        "times that the ground carried the boat, not counting where it was laid down well",
        "the first",
    ),
    "beyond-limits": Measure(
        "s", "number of ticks beyond any limit of the exercise, times the step", "the first"
    ),
    "beyond-test-depth": Measure(
        "m", "furthest that the hull's lowest point was beyond test depth", "the furthest"
    ),
    "time-beyond-test-depth": Measure(
        "s",
        "number of ticks with the hull's lowest point beyond test depth, times the step",
        "the first",
    ),
    "response": Measure(
        "s",
        "time from the first onset of {c} to the crew's next order{o}",
        "the order",
        needs=("casualty",),
        may=("orders",),
    ),
    "reserve-air": Measure(
        "%",
        "least of the air in {q} as a share of full",
        "when it was",
        may=("quantity",),
        quantities=TANKS,
    ),
}


@dataclass(frozen=True, kw_only=True)
class Score:
    """One rule as it stands in the file."""

    name: str = of(Text(60, "what is judged, for the debrief"))
    measure: str = of(Text(30, "one of the measures of docs/debrief.md"))
    quantity: str | None = optional(Text(40, "what is measured, its unit after it: depth_m"))
    target: float | None = optional(
        Quantity("its own", ENOUGH, "where it should be; else as ordered at each moment")
    )
    band: float | None = optional(Quantity("its own", above(0, 1e9), "how far off it may be"))
    casualty: str | None = optional(Text(40, "what is to be answered"))
    orders: tuple[str, ...] | None = optional(
        Choices(ANSWERS, "which orders answer it, by docs/orders.md; else any")
    )
    since: str | None = optional(
        Text(40, "a casualty: from_s and to_s count from when it first came; else from the start")
    )
    from_s: float | None = optional(Quantity("s", within(0, LATEST), "first moment looked at"))
    to_s: float | None = optional(Quantity("s", within(0, LATEST), "last moment looked at"))
    when: str | None = optional(Text(79, "conditions, with and: only moments at which they hold"))
    full: float = of(Quantity("measure's", ENOUGH, "value that earns full marks"))
    zero: float = of(Quantity("measure's", ENOUGH, "value that earns none; between, in proportion"))
    weight: float | None = optional(Quantity("-", above(0, 1000), "in the total; else 1"))
    part: str | None = optional(
        Choice(PARTS, "of the marks; else answer for a response, and task for all others")
    )


SCORES: Final = Rows(Score, ("note",), 0, 50, "how the crew is judged, below")


@dataclass(frozen=True)
class Measured:
    """A quantity in a unit; ``size`` is the unit's [SI]."""

    name: str
    unit: str
    size: float

    def __str__(self) -> str:
        return self.name.replace("_", " ")


@dataclass(frozen=True, kw_only=True)
class Rule:
    """One rule, its names understood."""

    score: Score
    measured: Measured | None
    conditions: tuple[Condition, ...]
    casualty: Casualty | None
    since: Casualty | None = None

    @property
    def part(self) -> str:
        """Return which part of the marks it belongs to."""
        return self.score.part or ("answer" if self.score.measure == "response" else "task")

    @property
    def weight(self) -> float:
        """Return the weight in the total."""
        return 1.0 if self.score.weight is None else self.score.weight


def understood(score: Score, place: Place, known: Mapping[str, Casualty]) -> Rule:
    """Return the rule of a table; ConfigError with all that is wrong in it."""
    problems: list[str] = []
    measured = None
    conditions: tuple[Condition, ...] = ()
    with collecting(problems):
        measured = score.quantity and parse_quantity(score.quantity, place)
    with collecting(problems):
        conditions = compile_conditions(score.when, place) if score.when else ()
    found: dict[str, Casualty | None] = {}
    for key in ("casualty", "since"):
        name = getattr(score, key)
        with collecting(problems):
            found[key] = None if name is None else _casualty_named(known, key, name, place)
    if score.full == score.zero:
        problems.append(place.wrong("zero", score.zero, "must not be the value of full"))
    if score.to_s is not None and score.to_s < (score.from_s or 0.0):
        problems.append(place.wrong("to_s", score.to_s, "is before from_s"))
    refuse(problems)
    return Rule(score=score, measured=measured or None, conditions=conditions, **found)


def _casualty_named(known: Mapping[str, Casualty], key: str, name: str, place: Place) -> Casualty:
    """Return the casualty that a key names; ConfigError if there is none."""
    if name not in known:
        raise ConfigError(place.wrong(key, name, f"no such casualty{nearest(name, known)}"))
    return known[name]


def _refuse_unknown(measure: str, place: Place) -> None:
    """Raise ConfigError if there is no such measure."""
    if measure not in MEASURES:
        guess = nearest(measure, MEASURES) or f"; there are: {', '.join(MEASURES)}"
        raise ConfigError(place.wrong("measure", measure, f"no such measure{guess}"))


def parse_quantity(text: str, place: Place) -> Measured:
    """Return the quantity that is named, in its unit or else its own. ConfigError if none is."""
    found = parse_name(text)
    if found is None:
        raise ConfigError(place.wrong("quantity", text, f"no such quantity{guess(text)}"))
    name, unit = found
    units = EVERY[name].units
    unit = unit or next(iter(units))
    return Measured(name, unit.replace("_", "/").replace("mpa", "MPa"), units[unit])


def read_rules(
    table: Mapping[str, object], place: Place, known: Mapping[str, Casualty]
) -> tuple[Rule, ...]:
    """Return the rules of an exercise file; ConfigError with all that is wrong in them."""
    problems: list[str] = []
    rules: list[Rule] = []
    readers: Readers = {
        "measure": _refuse_unknown,
        "quantity": parse_quantity,
        "when": compile_conditions,
        "casualty": partial(_casualty_named, known, "casualty"),
        "since": partial(_casualty_named, known, "since"),
    }
    rows, array = table.get("scores", []), place.inside("scores")
    for _, inside, score in sound_rows(SCORES, rows, array, readers, problems):
        with collecting(problems):
            rules.append(_read_rule(score, inside, known))
    names = [rule.score.name for rule in rules]
    problems += [
        place.problem(f'two [[scores]] have the name "{name}"')
        for name in dict.fromkeys(names)
        if names.count(name) > 1
    ]
    refuse(problems)
    return tuple(rules)


def _read_rule(score: Score, place: Place, known: Mapping[str, Casualty]) -> Rule:
    """Return one rule; ConfigError with all that is wrong in it."""
    problems: list[str] = []
    with collecting(problems):
        rule = understood(score, place, known)
    with collecting(problems):
        _refuse_unknown(score.measure, place)
        problems += _unfit(score, place)
    if not problems:
        problems += _check_target(rule, place)
    refuse(problems)
    return rule


def _unfit(score: Score, place: Place) -> list[str]:
    """Return which keys the measure has no use for, and which it lacks."""
    measure = MEASURES[score.measure]
    timed = () if score.measure in TIMELESS else WINDOW
    taken = (*measure.needs, *measure.may, *timed)
    given = [key for key in OPTIONAL if getattr(score, key) is not None]
    found = [
        place.wrong(key, getattr(score, key), f"{score.measure} has no use for it")
        for key in given
        if key not in taken
    ]
    lacking = [key for key in measure.needs if key not in given]
    if lacking:
        found.append(place.problem(f"{score.measure} lacks {', '.join(lacking)}"))
    return found


def _check_target(rule: Rule, place: Place) -> list[str]:
    """Return what is wrong with the quantity, or with the lack of its target."""
    measure, measured, score = MEASURES[rule.score.measure], rule.measured, rule.score
    if measured is None:
        return []
    if measure.quantities and measured.name not in measure.quantities:
        told = f"{score.measure} is of {' or '.join(measure.quantities)}"
        return [place.wrong("quantity", score.quantity, told)]
    aims = "target" in measure.may and score.measure not in OF_ITSELF
    if score.target is None and aims and measured.name not in ORDERED:
        told = f"nobody orders it as such ({', '.join(ORDERED)} are): give a target"
        return [place.wrong("quantity", score.quantity, told)]
    return []
