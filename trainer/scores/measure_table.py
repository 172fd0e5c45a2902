"""The measures by name: what a rule must say for each, its unit, and its formula in words."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Final

from trainer.scores import measures
from trainer.scores.measures import ITS_OWN, Attained
from trainer.scores.passage import Passage, Rows
from trainer.scores.score_rule import Rule

SURFACES: Final = ("rudder", "stern", "bow")
TANKS: Final = ("bank_main", "bank_emergency")


@dataclass(frozen=True)
class Measure:
    """One measure: what a rule must and may say for it, its unit, and its formula in words."""

    take: Callable[[Passage, Rows, Rule], Attained]
    needs: tuple[str, ...]
    may: tuple[str, ...]
    unit: str  # ITS_OWN: that of the quantity
    formula: str  # {q} the quantity, {t} its target, {b} its band, {u} their unit, {c} the casualty
    place: str  # which moment is told
    quantities: tuple[str, ...] = ()  # the only ones it takes; () any


MEASURES: Final[Mapping[str, Measure]] = {
    "overshoot": Measure(
        measures.overshoot,
        ("quantity", "target"),
        ("band",),
        ITS_OWN,
        "furthest of {q} beyond {t}, seen from where it began; no value short of it{by}",
        "the furthest",
    ),
    "time-to": Measure(
        measures.time_to,
        ("quantity", "target", "band"),
        (),
        "s",
        "time until {q} is within {b} of {t} and stays there to the end",
        "when it is",
    ),
    "rms": Measure(
        measures.rms,
        ("quantity",),
        ("target",),
        ITS_OWN,
        "root of the mean of ({q} - {t})^2, a term for each tick",
        "the furthest from it",
    ),
    "in-band": Measure(
        measures.in_band,
        ("quantity", "band"),
        ("target",),
        "%",
        "share of the ticks with {q} within {b} of {t}",
        "the furthest from it",
    ),
    "highest": Measure(measures.highest, ("quantity",), (), ITS_OWN, "greatest {q}", "when it was"),
    "lowest": Measure(measures.lowest, ("quantity",), (), ITS_OWN, "least {q}", "when it was"),
    "largest": Measure(
        measures.largest, ("quantity",), (), ITS_OWN, "greatest {q} either way", "when it was"
    ),
    "activity": Measure(
        measures.activity,
        (),
        ("quantity",),
        "deg/min",
        "sum of what {q} moved from tick to tick, by the time",
        "the fastest",
        SURFACES,
    ),
    "distance": Measure(
        measures.distance,
        (),
        (),
        "m",
        "sum of the way over the ground from tick to tick",
        "the last",
    ),
    "broaches": Measure(
        measures.broaches,
        (),
        (),
        "-",
        "times that sail or deck came out of the sea, main ballast not being blown",
        "the first",
    ),
    "beyond-limits": Measure(
        measures.beyond_limits,
        (),
        (),
        "s",
        "number of ticks beyond any limit of the exercise, times the step",
        "the first",
    ),
    "response": Measure(
        measures.response,
        ("casualty",),
        ("orders",),
        "s",
        "time from the first onset of {c} to the crew's next order{o}",
        "the order",
    ),
    "reserve-air": Measure(
        measures.reserve_air,
        (),
        ("quantity",),
        "%",
        "least of the air in {q} as a share of full",
        "when it was",
        TANKS,
    ),
}
WHOLE: Final = {"activity": "stern and bow planes", "reserve-air": "all banks"}  # no quantity named
TIMELESS: Final = ("response",)  # look at the whole record
WINDOW: Final = ("from_s", "to_s", "when")


def formula_of(rule: Rule) -> str:
    """Return how the value of a rule is found, in words."""
    score, measure = rule.score, MEASURES[rule.score.measure]
    unit = rule.measured.unit if rule.measured else ""
    words = {
        "q": str(rule.measured or WHOLE.get(score.measure, "")),
        "t": "what is ordered" if score.target is None else f"{score.target:g} {unit}",
        "b": f"{score.band:g} {unit}" if score.band is not None else "",
        "by": f" by {score.band:g} {unit}" if score.band is not None else "",
        "c": score.casualty or "",
        "o": f" of {', '.join(score.orders)}" if score.orders else "",
    }
    return measure.formula.format(**words) + _window(rule)


def _window(rule: Rule) -> str:
    """Return which moments are looked at, in words, '' for all."""
    score = rule.score
    parts = [
        "" if score.from_s is None else f"from {score.from_s:g} s",
        "" if score.to_s is None else f"to {score.to_s:g} s",
        f"while {score.when}" if score.when else "",
    ]
    told = " ".join(filter(None, parts))
    return told and f", {told}"


def unit_of(rule: Rule) -> str:
    """Return the unit of a rule's value."""
    unit = MEASURES[rule.score.measure].unit
    return unit if unit != ITS_OWN or rule.measured is None else rule.measured.unit


def measure_rows() -> str:
    """Return the Markdown table of the measures, as docs/debrief.md shows it."""
    rows = [
        "| measure | unit | needs | may have | value | place told |",
        "|---|---|---|---|---|---|",
    ]
    spoken = {"q": "quantity", "t": "target", "b": "band", "by": " by band", "c": "casualty"}
    for name, measure in MEASURES.items():
        timed = () if name in TIMELESS else WINDOW
        cells = (
            f"`{name}`",
            measure.unit or "the quantity's",
            ", ".join(measure.needs) or "nothing",
            ", ".join((*measure.may, *timed)),
            measure.formula.format(**spoken, o=" (of the orders named)"),
            measure.place,
        )
        rows.append(f"| {' | '.join(cells)} |")
    return "\n".join(rows) + "\n"
