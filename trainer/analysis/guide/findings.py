"""The findings of the 1969 study, flown again on this boat; the step-size study first.

``contents`` puts them into a guide. Each finding is worded as in the model document. Where it does
not hold here, the figures of this hull say why.

The manoeuvres of the step-size study have no events, because a longer step would delay an event and
that delay would count as an error. Controls act at once for the same reason.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from enum import StrEnum
from itertools import pairwise
from typing import Final

import numpy as np

from trainer.analysis.check import critical_speed, round_speeds
from trainer.analysis.guide.programme import FlightTable, Task
from trainer.analysis.manoeuvres.flight import Flight, Manoeuvre
from trainer.analysis.manoeuvres.submarine import Rig
from trainer.analysis.manoeuvres.turns import Turn
from trainer.analysis.manoeuvres.vehicle import largest_value
from trainer.analysis.manoeuvres.vertical import Meander, TrimChange
from trainer.boat.assemble import Method
from trainer.config.boat.vessel import VesselFile
from trainer.units import KNOT

STEP_SHARES: Final = (0.5, 1.0, 2.0, 3.0)  # of the boat's own step: 0.25, 0.5, 1 and 1.5 s of 1969
FINE_STEP_SHARE: Final = 0.1  # of it, the standard
LEAD_STEPS: Final = 12.0  # own steps before controls move: whole ones of every share
STUDIED_SCHEMES: Final = (
    ("Adams 2", "adams2", "lagged"),
    ("Adams 2", "adams2", "exact"),
    ("Euler", "euler", "lagged"),
    ("Runge-Kutta 4", "rk4", "exact"),
)
WATCHED_COLUMNS: Final = ("u", "w", "v", "r", "theta", "phi", "psi")
GOOD_ERROR_PERCENT: Final = 1.0  # [%] error up to which a step is fine,
BAD_ERROR_PERCENT: Final = 5.0  # and from which it is of no use
MIN_COLUMN_CHANGE: Final = 1e-3  # [rad] or of the speed: a column that moves less is not looked at
INSTANT_RIG: Final = Rig(controls="once")
# of the critical speed
CRITICAL_SPEED_RATIOS: Final = (0.6, 0.7, 0.8, 0.9, 0.95, 1.05, 1.1, 1.2, 1.4, 1.8)
REVERSAL_TOLERANCE: Final = 0.15  # [-] of it: where the reversal has to be
FLIGHT_TAIL_SHARE: Final = 0.1  # [-] of a flight, its last part
PLANE_OFFSET: Final = TrimChange(angle_deg=2.0, duration_s=600.0)
TURN_COEFFICIENTS: Final = ("Z_rr", "Z_vr", "Z_vv", "M_rr", "M_vr", "M_vv")
RUINED_DEPTH_RATIO: Final = 1.5  # [-] times the depth change with all terms
LOST_DEPTH_EFFECT: Final = "depth is lost"
LESS_DEPTH_EFFECT: Final = "depth changes less"
LITTLE_EFFECT: Final = "little changes"
ABSENT_EFFECT: Final = "not in this hull's data"
STUDIED_TURN: Final = Turn()
STUDIED_MEANDER: Final = Meander()
REPORT_RIG: Final = Rig(law="report")
NONLINEAR_COEFFICIENTS: Final = ("Z_waw", "Z_ww", "Z_aw", "M_waw", "M_ww", "M_aw", "M_awq", "M_qaq")


class ClaimVerdict(StrEnum):
    """Whether a finding of 1969 is so on a hull. The value is how the guide says it."""

    HOLDS = "holds"
    HOLDS_IN_PART = "holds in part"
    FAILS = "does not hold on this hull"
    NOT_SHOWN = "cannot be shown on this hull"


class StepVerdict(StrEnum):
    """How good a step is. The value is how the guide says it."""

    FINE = "fine"
    COARSE = "coarse"
    USELESS = "of no use"
    LOST = "lost"


@dataclass(frozen=True)
class StepRun:
    """One scheme at one step in one manoeuvre."""

    case: str
    scheme: str
    rates: str
    step_s: float
    percent: float | None  # worst error of any column, of its largest change; None: lost
    worst: str  # the column
    verdict: StepVerdict


def step_verdict(percent: float | None) -> StepVerdict:
    """Return how good a step is by its worst error [%], None if lost."""
    if percent is None:
        return StepVerdict.LOST
    if percent <= GOOD_ERROR_PERCENT:
        return StepVerdict.FINE
    return StepVerdict.COARSE if percent <= BAD_ERROR_PERCENT else StepVerdict.USELESS


def cases(file: VesselFile) -> dict[str, tuple[Manoeuvre, float]]:
    """Return the manoeuvres of the study and their speeds [m/s]."""
    lead, own_speed = LEAD_STEPS * file.run.step_s, file.run.start_speed_kn
    top = round_speeds(*file.run.speed_range_kn)[-1]
    turn = Turn(duration_s=300.0 * file.run.step_s / 0.5, keep=(), lead_s=lead)
    trim = TrimChange(duration_s=240.0 * file.run.step_s / 0.5, lead_s=lead)
    return {
        f"planes offset 3 deg, {own_speed:g} kn": (trim, own_speed * KNOT),
        f"rudder 15 deg, {own_speed:g} kn": (turn, own_speed * KNOT),
        f"rudder 15 deg, {top:g} kn": (turn, top * KNOT),
    }


def standard_flight(file: VesselFile, manoeuvre: Manoeuvre, speed: float) -> Task:
    """Return the flight that others are compared with: the finest step."""
    fine = Method("full", "exact", "exact", "rk4", FINE_STEP_SHARE * file.run.step_s)
    return Task(manoeuvre, speed, fine, INSTANT_RIG)


def fly_schemes(
    file: VesselFile, manoeuvre: Manoeuvre, speed: float
) -> Iterator[tuple[tuple[str, str, str], float, Task]]:
    """Yield every scheme and step [s] of the study, each with its flight."""
    for scheme in STUDIED_SCHEMES:
        for share in STEP_SHARES:
            step = share * file.run.step_s
            method = Method("full", scheme[2], "exact", scheme[1], step)
            yield scheme, step, Task(manoeuvre, speed, method, INSTANT_RIG)


def step_tasks(file: VesselFile) -> Iterator[Task]:
    """Yield the flights of the study."""
    for manoeuvre, speed in cases(file).values():
        yield standard_flight(file, manoeuvre, speed)
        yield from (task for _, _, task in fly_schemes(file, manoeuvre, speed))


def step_study(file: VesselFile, flown: FlightTable) -> tuple[StepRun, ...]:
    """Return how far every scheme and step is from the standard."""
    runs = []
    for case, (manoeuvre, speed) in cases(file).items():
        true = flown[standard_flight(file, manoeuvre, speed)]
        if isinstance(true, str) or true.lost:
            continue
        for (name, _, rates), step, task in fly_schemes(file, manoeuvre, speed):
            percent, worst = worst_error(true, flown[task])
            verdict = step_verdict(percent)
            runs.append(StepRun(case, name, rates, step, percent, worst, verdict))
    return tuple(runs)


def worst_error(true: Flight, other: Flight | str) -> tuple[float | None, str]:
    """Return the worst error [%] of any column's extremes and end, and which; None: lost.

    The error is a share of the column's own change. Phase is not judged, because Adams answers a
    step of a control as if it had come half a cycle earlier.
    """
    if isinstance(other, str) or other.lost:
        return None, ""
    worst = (0.0, "")
    for name in WATCHED_COLUMNS:
        span = float(np.ptp(true.column(name)))
        unit = true.speed if name in "uvw" else 1.0
        if span < MIN_COLUMN_CHANGE * unit:
            continue
        pairs = zip(_ends(true, name), _ends(other, name), strict=True)
        worst = max(worst, (100.0 * max(abs(a - b) for a, b in pairs) / span, name))
    return worst


def _ends(flight: Flight, name: str) -> tuple[float, float, float]:
    """Return the largest, the smallest and the last value of a column."""
    values = flight.column(name)
    return float(values.max()), float(values.min()), float(values[-1])


@dataclass(frozen=True)
class GuideFinding:
    """One finding of 1969, and whether it holds for this boat."""

    title: str
    claim: str  # of 1969
    verdict: ClaimVerdict
    words: str  # why, with figures
    heads: tuple[str, ...] = ()
    rows: tuple[tuple[str, ...], ...] = ()


def _graded(*, holds: bool, in_part: bool = False) -> ClaimVerdict:
    """Return whether a finding holds, holds in part, or fails."""
    if holds:
        return ClaimVerdict.HOLDS
    return ClaimVerdict.HOLDS_IN_PART if in_part else ClaimVerdict.FAILS


def _standard(file: VesselFile) -> Method:
    """Return the reference method: the full set by Runge and Kutta, at the boat's own step."""
    return Method("full", "exact", "exact", "rk4", file.run.step_s)


def _offset(file: VesselFile, speed: float) -> Task:
    """Return planes to dive by a little, held, at ``speed`` [m/s]."""
    return Task(PLANE_OFFSET, speed, _standard(file))


def _turn(file: VesselFile, *zeroed: str) -> Task:
    """Return the turn at the top speed, depth by the law of 1969, with coefficients at zero."""
    top = round_speeds(*file.run.speed_range_kn)[-1]
    return Task(STUDIED_TURN, top * KNOT, _standard(file), REPORT_RIG, zeroed)


def _meander(file: VesselFile, *zeroed: str) -> Task:
    """Return the meander at the start speed, with coefficients at zero."""
    return Task(STUDIED_MEANDER, file.run.start_speed_kn * KNOT, _standard(file), zeroed=zeroed)


def finding_tasks(file: VesselFile) -> Iterator[Task]:
    """Yield the flights that the findings look at."""
    critical = critical_speed(file, "stern")
    for ratio in CRITICAL_SPEED_RATIOS if critical else ():
        yield _offset(file, ratio * (critical or 0.0))
    yield _turn(file)
    for name in (*TURN_COEFFICIENTS, "K_vav"):
        yield _turn(file, name)
    yield _meander(file)
    yield _meander(file, *NONLINEAR_COEFFICIENTS)


def study_findings(
    file: VesselFile, flown: FlightTable, steps: tuple[StepRun, ...]
) -> tuple[GuideFinding, ...]:
    """Return all findings, judged."""
    return (
        reversal(file, flown),
        depth_in_turns(file, flown),
        roll_in_turns(file, flown),
        nonlinear_terms(file, flown),
        *stepping(file, steps),
    )


def reversal(file: VesselFile, flown: FlightTable) -> GuideFinding:
    """Return whether stern planes reverse at the critical speed of EC470."""
    title = "Stern planes reverse"
    claim = "below the critical speed of EC470, planes to dive make the boat rise"
    critical = critical_speed(file, "stern")
    if critical is None:
        return GuideFinding(title, claim, ClaimVerdict.NOT_SHOWN, "this hull has no critical speed")
    rates = {}
    for ratio in CRITICAL_SPEED_RATIOS:
        flight = flown[_offset(file, ratio * critical)]
        if not isinstance(flight, str) and not flight.lost:
            z, t = flight.column("z"), flight.t
            begin = int((1.0 - FLIGHT_TAIL_SHARE) * (t.size - 1))
            rates[ratio * critical] = float((z[-1] - z[begin]) / (t[-1] - t[begin]))
    rows = tuple(
        (f"{speed / KNOT:.2f}", f"{1000.0 * rate:+.1f}", "dives" if rate > 0.0 else "rises")
        for speed, rate in rates.items()
    )
    heads = ("speed [kn]", "depth rate [mm/s]", "planes to dive: the boat")
    speeds = [*rates]
    turns = [
        low - rates[low] * (high - low) / (rates[high] - rates[low])
        for low, high in pairwise(speeds)
        if rates[low] < 0.0 < rates[high]
    ]
    if len(turns) != 1:
        wanted = len(CRITICAL_SPEED_RATIOS)
        words = (
            f"of {wanted} speeds about the {critical / KNOT:.2f} kn of EC470 {len(rates)} can "
            f"be flown, and the depth rate turns {len(turns)} times between them"
        )
        verdict = ClaimVerdict.FAILS if len(rates) == wanted else ClaimVerdict.NOT_SHOWN
        return GuideFinding(title, claim, verdict, words, heads, rows)
    flies, says = turns[0] / KNOT, critical / KNOT
    verdict = _graded(holds=abs(flies - says) <= REVERSAL_TOLERANCE * says)
    words = f"EC470 gives {says:.2f} kn, in flight with 2 degrees it is {flies:.2f} kn"
    return GuideFinding(title, claim, verdict, words, heads, rows)


def depth_in_turns(file: VesselFile, flown: FlightTable) -> GuideFinding:
    """Return what six coefficients do for depth in a turn."""
    title = "Depth in turns"
    claim = (
        "without any of Z_rr, Z_vr, Z_vv, M_rr, M_vr, M_vv the autopilot of 1969 loses 12 to 33 ft "
        "in a turn that it holds within 4 ft with them"
    )
    whole = flown[_turn(file)]
    heads = ("without", "its value here", "largest depth change [m]", "times", "")
    if isinstance(whole, str) or whole.lost:
        words = whole if isinstance(whole, str) else whole.lost
        return GuideFinding(title, claim, ClaimVerdict.NOT_SHOWN, words)
    base = largest_value(whole.change("z"))
    rows = [("nothing", "", f"{base:+.2f}", "1.00", "")]
    by_effect: dict[str, list[str]] = {}
    for name in TURN_COEFFICIENTS:
        row = _without(file, name, flown[_turn(file, name)], base)
        by_effect.setdefault(row[-1], []).append(name)
        rows.append(row)
    lost = by_effect.get(LOST_DEPTH_EFFECT, [])
    verdict = _graded(holds=lost == list(TURN_COEFFICIENTS), in_part=bool(lost))
    if len(by_effect.get(ABSENT_EFFECT, [])) == len(TURN_COEFFICIENTS):
        verdict = ClaimVerdict.NOT_SHOWN
    effects = "; ".join(f"{effect}: {', '.join(names)}" for effect, names in by_effect.items())
    words = f"with all terms depth changes by {abs(base):.2f} m; without one of them, {effects}"
    return GuideFinding(title, claim, verdict, words, heads, tuple(rows))


def _without(
    file: VesselFile, name: str, flight: Flight | str, base: float
) -> tuple[str, str, str, str, str]:
    """Return the row of one coefficient at zero, its effect last; ``base`` [m] is with all."""
    value = file.coefficients[name]
    if not value:
        return name, "0", f"{base:+.2f}", "1.00", ABSENT_EFFECT
    if isinstance(flight, str) or flight.lost:
        return name, f"{value:.4g}", "-", "-", LOST_DEPTH_EFFECT
    deep = largest_value(flight.change("z"))
    ratio = abs(deep / base)
    effect = LESS_DEPTH_EFFECT if ratio <= 1.0 / RUINED_DEPTH_RATIO else LITTLE_EFFECT
    effect = LOST_DEPTH_EFFECT if ratio >= RUINED_DEPTH_RATIO else effect
    return name, f"{value:.4g}", f"{deep:+.2f}", f"{ratio:.2f}", effect


def roll_in_turns(file: VesselFile, flown: FlightTable) -> GuideFinding:
    """Return what K_vav does to roll in a turn."""
    title, claim = "Roll in turns", "without K_vav the roll of a turn changes by about 70 %"
    whole, without = flown[_turn(file)], flown[_turn(file, "K_vav")]
    if not file.coefficients["K_vav"]:
        return GuideFinding(title, claim, ClaimVerdict.NOT_SHOWN, "this hull's data have no K_vav")
    if isinstance(whole, str) or isinstance(without, str):
        return GuideFinding(title, claim, ClaimVerdict.NOT_SHOWN, "the turn cannot be flown")
    before, after = largest_value(whole.change("phi")), largest_value(without.change("phi"))
    percent = 100.0 * (after - before) / abs(before)
    verdict = _graded(holds=abs(percent) >= 50.0, in_part=abs(percent) > 5.0)
    share = file.coefficients["K_vav"] / (file.coefficients["K_v"] or float("nan"))
    words = (
        f"the largest roll changes by {percent:+.0f} %; K_vav is {share:.1f} times K_v here, and "
        "counts by the drift angle"
    )
    return GuideFinding(title, claim, verdict, words)


def nonlinear_terms(file: VesselFile, flown: FlightTable) -> GuideFinding:
    """Return what the nonlinear terms of the vertical plane do to a meander."""
    title = "Nonlinear vertical terms"
    claim = "without all of them pitch is off by 21 %, depth by 14 %"
    whole, without = flown[_meander(file)], flown[_meander(file, *NONLINEAR_COEFFICIENTS)]
    if isinstance(whole, str) or isinstance(without, str):
        return GuideFinding(title, claim, ClaimVerdict.NOT_SHOWN, "the meander cannot be flown")
    percent = {}
    for name in ("theta", "z"):
        before, after = largest_value(whole.change(name)), largest_value(without.change(name))
        percent[name] = 100.0 * (after - before) / before
    worst = max(abs(one) for one in percent.values())
    verdict = _graded(holds=worst >= 10.0, in_part=worst > 5.0)
    present_terms = [name for name in NONLINEAR_COEFFICIENTS if file.coefficients[name]]
    words = (
        f"the meander's pitch is off by {percent['theta']:+.1f} %, its depth by "
        f"{percent['z']:+.1f} %; of these terms this hull's data have "
        f"{', '.join(present_terms) or 'none'}"
    )
    return GuideFinding(title, claim, verdict, words)


def stepping(file: VesselFile, steps: tuple[StepRun, ...]) -> Iterator[GuideFinding]:
    """Yield the findings of 1969 on integrators and steps, in this boat's own steps."""
    own_step = file.run.step_s
    euler, adams = _worst(steps, "Euler", 2.0 * own_step), _worst(steps, "Adams 2", own_step)
    useless = euler.verdict in (StepVerdict.LOST, StepVerdict.USELESS)
    claim = "Euler cannot be used at twice the step that Adams is used at"
    yield GuideFinding("Euler at 1 s", claim, _graded(holds=useless), _error(euler))
    fine = adams.verdict is StepVerdict.FINE
    claim = "second-order Adams is fine at the boat's own step"
    yield GuideFinding("Adams at 0.5 s", claim, _graded(holds=fine), _error(adams))
    yield _lag_costs(steps, own_step)


def _worst(steps: tuple[StepRun, ...], scheme: str, step: float) -> StepRun:
    """Return the worst case of a scheme with lagged rates at a step."""
    lagged = [run for run in steps if run.scheme == scheme and run.rates == "lagged"]
    runs = [run for run in lagged if abs(run.step_s - step) < 1e-9]
    return max(runs, key=lambda run: float("inf") if run.percent is None else run.percent)


def _error(run: StepRun) -> str:
    """Return the error of a run in words."""
    if run.percent is None:
        return f"{run.scheme} at {run.step_s:.3g} s is lost in: {run.case}"
    return (
        f"{run.scheme} at {run.step_s:.3g} s is off by at most {run.percent:.3g} % of the change "
        f"({run.worst}; {run.case})"
    )


def _lag_costs(steps: tuple[StepRun, ...], own: float) -> GuideFinding:
    """Return whether lagged accelerations cost accuracy at the boat's own step."""
    pairs: dict[str, dict[str, float | None]] = {}
    for run in steps:
        if run.scheme == "Adams 2" and abs(run.step_s - own) < 1e-9:
            pairs.setdefault(run.case, {})[run.rates] = run.percent
    costs = [
        pair["lagged"] - pair["exact"]
        for pair in pairs.values()
        if pair["lagged"] is not None and pair["exact"] is not None
    ]
    whole = bool(costs) and len(costs) == len(pairs)
    verdict = _graded(holds=whole and max(costs) <= 1.0)
    words = "a case is lost" if not whole else f"they add at most {max(costs):.2g} % to the error"
    claim = "accelerations of the last cycle do no harm"
    return GuideFinding("Lagged accelerations", claim, verdict, words)
