"""The readiness of a vessel file: its compact set, and what it lacks.

The end of ``trainer boat check``. It judges a few flights of the guide in the way in which
``trainer boat reduce --check`` judges all, and names the command that makes each missing part.
"""

import textwrap
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Final

from trainer.analysis.guide.programme import Leg, guide_legs
from trainer.analysis.guide.verdicts import (
    BEYOND_TOLERANCE,
    MAX_DIFFERENCE,
    Judgement,
    allowed_multiple,
)
from trainer.analysis.manoeuvres.vehicle import ALLOWED_PERCENT
from trainer.analysis.reduce.objective import Candidate, Yardstick
from trainer.analysis.reduce.reduction import as_filed
from trainer.config.files import SHIPPED_PREFIX, as_typed, key_of
from trainer.config.vessel import VesselFile
from trainer.report.text import format_number, wrap

FLOWN_MANOEUVRES: Final = ("turn", "overshoot", "zigzag-10")  # of the guide


@dataclass(frozen=True)
class WorstNumber:
    """The number of a flight with the largest difference from the full set. SI and radians."""

    leg: str
    quantity: str  # "" where nothing is judged
    unit: str
    full: float | None
    compact: float | None
    of_allowed: float  # [-] the difference; above 1 it is beyond


@dataclass(frozen=True)
class MissingPart:
    """Something that a file does not say, and what to type or write."""

    what: str
    remedy: str


@dataclass(frozen=True)
class Readiness:
    """The readiness of a boat: the last part of what ``trainer boat check`` prints."""

    own_compact_set: bool
    compact: tuple[WorstNumber, ...]  # none without a compact set
    lacks: tuple[MissingPart, ...]

    @property
    def passed(self) -> bool:
        """Return whether nothing that was judged is beyond what is allowed."""
        return all(one.of_allowed <= 1.0 for one in self.compact)


def examine_boat(file: VesselFile) -> Readiness:
    """Return how ready a boat is."""
    compact = tuple(_compared(file)) if file.has_compact_set else ()
    readiness = Readiness(file.has_compact_set, compact, ())
    return replace(readiness, lacks=tuple(_lacks(file, readiness)))


def _compared(file: VesselFile) -> Iterator[WorstNumber]:
    """Yield the worst number of each flight, by the compact set as it is filed."""
    candidate = Candidate(file, "modified")
    factors = as_filed(file)
    candidate.take([factors[name] for name in candidate.terms])
    wanted = [leg for leg in guide_legs(file) if leg.name in FLOWN_MANOEUVRES]
    for leg, judgements in Yardstick(file, wanted).judged(candidate):
        yield _worst(leg, judgements)


def _worst(leg: Leg, judgements: tuple[Judgement, ...]) -> WorstNumber:
    """Return the number of a flight with the largest difference from the full set."""
    if not judgements:
        return WorstNumber(leg.title, "it cannot start", "", None, None, MAX_DIFFERENCE)
    judged = (one for one in judgements if one.allowed or one.verdict == BEYOND_TOLERANCE)
    sizes = {one: abs(allowed_multiple(one)) for one in judged}
    if not sizes:
        return WorstNumber(leg.title, "", "", None, None, 0.0)
    one = max(sizes, key=lambda each: sizes[each])
    return WorstNumber(leg.title, one.quantity, one.unit, one.full, one.other, sizes[one])


def _lacks(file: VesselFile, found: Readiness) -> Iterator[MissingPart]:
    """Yield what the file lacks, the most needed first."""
    shipped = key_of(file.path).startswith(SHIPPED_PREFIX)
    typed = file.path.stem if shipped else as_typed(file.path)
    example = f"take it from trainer boat new like.toml --from bb2 --length {file.hull.length:g}"
    reduction = f"trainer boat reduce {typed} --write"
    if not file.has_compact_set:
        yield MissingPart("a compact set: the full set is flown", reduction)
    elif not found.passed:
        yield MissingPart("a compact set within tolerance", reduction)
    surface = "[free_surface]: it does not feel a calm surface"
    for part, what, remedy in (
        (file.autopilot, "gains: it is steered by hand", f"trainer boat gains {typed} >> {typed}"),
        (file.ballast, "[ballast]: it has no tanks, and does not surface by air", example),
        (file.wave_strips, "[wave_strips]: waves push on a usual hull of its length", example),
        (file.free_surface, surface, "docs/vessel-keys.md"),
        (file.hull.test_depth_m, "test_depth_m: none is known", "a line in [vessel]"),
        (file.hull.collapse_depth_m, "collapse_depth_m: none is known", "a line in [vessel]"),
        (file.run.periscope_depth_m, "periscope_depth_m: none is known", "a line in [run]"),
    ):
        if part is None:
            yield MissingPart(what, remedy)


def render(found: Readiness) -> str:
    """Return the end of the page of a check, 79 columns."""
    return "\n".join((*_compact_lines(found), *_lack_lines(found)))


def _compact_lines(found: Readiness) -> Iterator[str]:
    """Yield the flights by the compact set, the worst number of each."""
    yield ""
    if not found.own_compact_set:
        yield "COMPACT SET: the file has none of its own; the full set is flown."
        return
    yield f"COMPACT SET (flights of the guide beside the full set's; {ALLOWED_PERCENT:g} % allowed)"
    yield f"  {'flight':<43}{'full':>10}{'compact':>10}{'of allowed':>12}"
    for one in found.compact:
        mark = " BEYOND" if one.of_allowed > 1.0 else ""
        yield f"  {one.leg}{mark}"
        if not one.quantity:
            yield "    not judged: the full set does not end it"
            continue
        unit = f" [{one.unit}]" if one.unit else ""
        name = textwrap.shorten(f"{one.quantity}{unit}", 40, placeholder="...")
        full, other = (format_number(x, ".4g") for x in (one.full, one.compact))
        yield f"    {name:<41}{full:>10}{other:>10}{one.of_allowed:>12.2f}"
    yield (
        "The compact set is within tolerance in all of them."
        if found.passed
        else "The compact set is NOT within tolerance."
    )


def _lack_lines(found: Readiness) -> Iterator[str]:
    """Yield the missing entries as lines, each with the command that makes it."""
    yield ""
    if not found.lacks:
        yield "MISSING: nothing."
        return
    yield "MISSING, and what makes it"
    for lack in found.lacks:
        yield from wrap(lack.what)
        yield f"    {lack.remedy}"
