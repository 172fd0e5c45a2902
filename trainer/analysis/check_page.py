"""The report of ``trainer boat check`` for a terminal, and the readiness at its end.

``cli/workshop/vessel`` prints both in 79 columns of ASCII. ``check`` has the figures of the report;
here they are only put into tables and sentences. For the readiness a few flights of the guide are
judged in the way in which ``trainer boat reduce --check`` judges all; each part that the file lacks
is told with the command that makes it.
"""

import textwrap
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Final

from trainer.analysis.check import STABILITY_METHODS, CheckReport, StraightFlight, TurnComparison
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
from trainer.boat.linear import NEUTRAL_TOLERANCE
from trainer.boat.plant import PlantFacts
from trainer.boat.stability import BLAMED_GROWTH
from trainer.config.boat.vessel import VesselFile
from trainer.config.files import SHIPPED_PREFIX, as_typed, key_of
from trainer.report.text import INDENT, PAGE_WIDTH, cut_text, format_number, wrap

TURN_LABELS = {
    "diameter_m": "diameter [m]",
    "speed_kn": "speed [kn]",
    "yaw_rate_deg_s": "yaw rate [deg/s]",
    "heel_deg": "heel [deg]",
}
FLOWN_MANOEUVRES: Final = ("turn", "overshoot", "zigzag-10")  # of the guide


def _coefficients(report: CheckReport) -> list[str]:
    """Return the absent coefficients, and the numbers that make port and starboard differ."""
    lines = ["", "COEFFICIENTS (absent ones count as zero)"]
    kept = "absent, which the compact set would keep", report.absent_but_kept
    dropped = "absent, of no use to the compact set", report.absent_and_dropped
    for title, groups in (kept, dropped):
        lines += wrap(f"{title}: {sum(map(len, groups.values())) or 'none'}")
        for equation, names in groups.items():
            lines += wrap(" ".join(names), f"{2 * INDENT}{equation}  ", 2 * INDENT + "   ")
    sides = ", ".join(f"{name} {value:.4g}" for name, value in report.asymmetries.items())
    return lines + wrap("port and starboard differ by: " + (sides or "nothing"))


def _hull(report: CheckReport) -> list[str]:
    """Return inertia, margins of stability and critical speeds."""
    inertia = report.inertia
    definite = "positive definite" if inertia.definite else "NOT POSITIVE DEFINITE"
    sweep = ", ".join(f"{name} {rate:.3f}" for name, rate in inertia.contraction.items())
    critical = ", ".join(
        f"{plane} planes {'none' if speed is None else f'{speed:.1f} kn'}"
        for plane, speed in report.critical_speed_kn.items()
    )
    margins = ", ".join(f"{name} {format_number(value)}" for name, value in report.margins.items())
    return [
        "",
        "HULL",
        f"{INDENT}mass matrix             {definite}, condition {inertia.condition:.3g}",
        f"{INDENT}lagged sweep            keeps of an error: {sweep}",
        f"{INDENT}margins of stability    {margins}",
        f"{INDENT}depth control reverses  {critical}",
    ]


def _flight(flight: StraightFlight) -> Iterator[str]:
    """Yield trim and modes at one speed."""
    trim = (
        f"pitch {flight.pitch_deg:+.2f}, stern planes {flight.stern_planes_deg:+.2f}, "
        f"bow planes {flight.bow_planes_deg:+.2f} deg"
        if flight.trimmed
        else "no trim within the plane limits; about level flight, planes at zero"
    )
    yield f"{INDENT}{flight.speed_kn:g} kn: {trim}"
    for row in flight.modes:
        steps = "".join(f"{row.largest_s.get(name, 0.0):>8.3g}" for name in STABILITY_METHODS)
        if not row.stable:
            steps = f"{'unstable' if row.real > NEUTRAL_TOLERANCE else 'neutral':>16}"
        root = f"{row.real:+.4f}" + (f" +-{row.imaginary:.4f}i" if row.imaginary else "")
        period, time = (format_number(x, ".1f") for x in (row.period_s, row.time_constant_s))
        numbers = f"{period:>8}{format_number(row.damping_ratio):>8}{time:>9}"
        yield f"{2 * INDENT}{row.name:<9}{root:<20}{numbers}{steps}"


def _modes(report: CheckReport) -> list[str]:
    """Return the modes by speed, and which modes the boat does not damp."""
    lines = [
        "",
        "MODES (full set; the steps are those of the method's stability region)",
        f"{2 * INDENT}{'':<29}{'period':>8}{'damping':>8}{'1/Re':>9}{'largest step [s]':>18}",
        f"{2 * INDENT}{'':9}{'root [1/s]':20}{'[s]':>8}{'ratio':>8}{'[s]':>9} Adams 2   Euler",
    ]
    wild: dict[str, list[tuple[float, float]]] = {}
    for flight in report.flights:
        lines += _flight(flight)
        for row in flight.modes:
            if row.real > NEUTRAL_TOLERANCE:
                wild.setdefault(row.name, []).append((row.real, flight.speed_kn))
    phrases = []
    for name, entries in wild.items():
        rates, speeds = zip(*entries, strict=True)
        phrases.append(f"{name} up to {max(rates):+.3g} /s ({min(speeds):g} to {max(speeds):g} kn)")
    sentence = "UNSTABLE BY NATURE, at any step: " + "; ".join(phrases)
    return lines + (wrap(sentence) if phrases else [])


def _steps(report: CheckReport) -> list[str]:
    """Return the largest steps of the map flown, and the verdicts."""
    lines = ["", "STEPS (as flown, lagged accelerations; what grows by nature is not counted)"]
    lines += wrap(
        "stable: nothing grows; only a swing that the boat damps by less than "
        f"{BLAMED_GROWTH:.0%} may, by {BLAMED_GROWTH:.0%} of its frequency"
    )
    for equations, limits in report.largest_flown_s.items():
        steps = (limits[name] for name in STABILITY_METHODS)
        adams, euler = ("any" if step is None else f"{step:.3f} s" for step in steps)
        lines.append(f"{INDENT}{equations:<9} largest: Adams 2 {adams}, Euler {euler}")
    for verdict in report.verdicts:
        word = "stable" if verdict.stable else "NOT STABLE"
        why = "" if verdict.stable else f": {verdict.worst} x {verdict.growth:.3f} per tick"
        lines.append(f"{INDENT}{verdict.equations:<9} {verdict.step_s:g} s, Adams 2: {word}{why}")
    return lines


def _turn_lines(turn: TurnComparison) -> Iterator[str]:
    """Yield the compact turn beside the full one."""
    yield ""
    yield f"TURN ({turn.rudder_deg:g} deg rudder at {turn.speed_kn:g} kn; depth {turn.depth})"
    if turn.full is None or turn.modified is None:
        yield from wrap("cannot be compared: " + turn.problem)
        return
    yield f"{INDENT}{'':<18}{'full':>10}{'compact':>10}{'change':>10}"
    for name, label in TURN_LABELS.items():
        change = f"{turn.percent[name]:+.1f} %" if name in turn.percent else "-"
        full, compact = getattr(turn.full, name), getattr(turn.modified, name)
        yield f"{INDENT}{label:<18}{full:>10.3f}{compact:>10.3f}{change:>10}"


def render(report: CheckReport) -> str:
    """Return the report as text."""
    periods = ", ".join(f"{name} {period:.1f} s" for name, period in report.afloat.period_s.items())
    parts = ", ".join(f"{step:g} s in {count}" for step, count in report.afloat.parts.items())
    cut_off = "linear coefficients would feed the boat beyond their range: that is cut off"
    texts = [f"from the defaults file: {', '.join(report.defaulted)}"] * bool(report.defaulted)
    texts += [f"remark: {remark}" for remark in report.remarks]
    texts += [
        f"bound: {each.key} {each.given:g} is flown as {each.flown:.4g} afloat or "
        "beyond the coefficients' range: as given it would feed the boat"
        for each in report.bounded
    ]
    texts += [f"note: {note}" for note in report.notes]
    verb = "is" if report.own_step_stable else "is NOT"
    verdict = f"Not every step above is stable; the boat's own, {report.own_step_s:g} s, {verb}."
    lines = [
        report.vessel,
        INDENT + cut_text(report.path, PAGE_WIDTH - len(INDENT)),
        *(line for text in texts for line in wrap(text)),
        *_coefficients(report),
        *_hull(report),
        *_modes(report),
        *_steps(report),
        "",
        "AFLOAT (at the lightest)",
        f"{INDENT}periods                 {periods}",
        f"{INDENT}steps are divided       {parts}",
        *(wrap(cut_off) if report.clipped else []),
        *_turn_lines(report.turn),
        *_plant_lines(report.plant),
        "",
        "All steps above are stable." if report.stable else verdict,
    ]
    return "\n".join(lines)


def _plant_lines(plant: PlantFacts | None) -> Iterator[str]:
    """Yield how long the battery lasts, and what the oil moves without pumps."""
    if plant is None:
        return
    hours = ", ".join(f"{value:.3g} h at {knots} kn" for knots, value in plant.endurance_h.items())
    strokes = ", ".join(f"{name} {value:.2g}" for name, value in plant.strokes.items())
    yield ""
    yield "PLANT (submerged, all well)"
    yield from wrap(f"battery                 {hours}", INDENT)
    yield from wrap(f"strokes without pumps   {strokes} of the stern planes", INDENT)


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


def render_readiness(found: Readiness) -> str:
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
