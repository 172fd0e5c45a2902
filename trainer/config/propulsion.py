"""Thrust rows of a vessel file: those ahead, those astern, and whether they join."""

import math
from collections.abc import Sequence
from typing import Final, NamedTuple

from trainer.config.vessel_records import ThrustSet

ASTERN_BOLLARD: Final = -0.77  # [-] thrust turning astern over that ahead, B4-70 (docs/envelope.md)
DRAG_ASTERN: Final = 1.2  # [-] axial drag astern over that ahead, estimate
MIN_ETA: Final = -100.0  # [-] eta
JOINT_TOLERANCE: Final = 1e-9  # [-] relative; numbers as typed are to be the same


class ThrustRows(NamedTuple):
    """The rows in use: ahead by falling eta_min, and astern turning astern, then ahead."""

    ahead: tuple[ThrustSet, ...]
    astern: tuple[ThrustSet, ThrustSet]


def thrust_of(rows: Sequence[ThrustSet], drag_astern: float) -> ThrustRows:
    """Return the rows going ahead and astern; estimates fill those that the file leaves out."""
    ahead = sorted((row for row in rows if row.going != "astern"), key=lambda row: -row.eta_min)
    astern = sorted((row for row in rows if row.going == "astern"), key=lambda row: -row.eta_min)
    # A row with eta below 0: the boat goes ahead while the propeller turns astern.
    if ahead[-1].eta_min >= 0.0 and len(ahead) < 3:
        bollard = ASTERN_BOLLARD * ahead[0].c
        ahead.append(ThrustSet(eta_min=MIN_ETA, a=ahead[-1].a, b=0.0, c=bollard))
    if not astern:
        # c is that of the row ahead with the same turning, so that the rows join at u = 0.
        drag = drag_astern * abs(_row_at_rest(ahead).a)
        astern = [
            ThrustSet(eta_min=0.0, a=drag, b=0.0, c=ahead[-1].c, going="astern"),
            ThrustSet(eta_min=MIN_ETA, a=drag, b=0.0, c=ahead[0].c, going="astern"),
        ]
    return ThrustRows(tuple(ahead), (astern[0], astern[-1]))


def _row_at_rest(ahead: Sequence[ThrustSet]) -> ThrustSet:
    """Return the row in force with the propeller stopped, going ahead."""
    return next((row for row in ahead if row.eta_min <= 0.0), ahead[-1])


def row_problems(rows: Sequence[ThrustSet]) -> list[str]:
    """Return what is wrong with the number of rows, or with where they begin."""
    problems = []
    for way in ("ahead", "astern"):
        starts = [row.eta_min for row in rows if (row.going or "ahead") == way]
        problems += [
            f"sets: eta_min = {eta:g} is given twice going {way}"
            for eta in dict.fromkeys(starts)
            if starts.count(eta) > 1
        ]
    ahead = [row for row in rows if row.going != "astern"]
    astern = [row for row in rows if row.going == "astern"]
    if not 1 <= len(ahead) <= 3:
        problems.append(f"sets: {len(ahead)} rows going ahead, must be 1 to 3")
    if astern and (len(astern) != 2 or max(row.eta_min for row in astern) != 0.0):
        problems.append(
            'sets: going = "astern" takes two rows, or none: with eta_min = 0 for the propeller '
            f"turning astern, and below for ahead; these begin at {[r.eta_min for r in astern]}"
        )
    return problems


def thrust_problems(thrust: ThrustRows) -> list[str]:
    """Return where rows do not join, and whether an astern bell drives the boat ahead."""
    ahead, (back, check) = thrust
    stopped = _row_at_rest(ahead)
    joints = (
        ("a", "u_c = 0, going ahead", stopped, ahead[-1]),
        ("a", "u_c = 0, going astern", back, check),
        ("c", "u = 0, turning astern", ahead[-1], back),
        ("c", "u = 0, turning ahead", ahead[0], check),
    )
    problems = [
        f"sets: {key} = {getattr(one, key):g} and {getattr(other, key):g} do not join at {where}: "
        "must be the same"
        for key, where, one, other in joints
        if not math.isclose(
            getattr(one, key), getattr(other, key), rel_tol=JOINT_TOLERANCE, abs_tol=1e-15
        )
    ]
    bollard = ahead[-1].c
    if bollard > 0.0 or (bollard == 0.0 and ahead[0].c > 0.0):
        problems.append(
            f"sets: c = {bollard:g} in the row of eta below 0 drives the boat ahead on an astern "
            f"bell: must be below 0, such as {ASTERN_BOLLARD:g} of c ahead = "
            f"{ASTERN_BOLLARD * ahead[0].c:.6g}"
        )
    return problems
