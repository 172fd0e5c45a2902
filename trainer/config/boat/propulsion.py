"""Thrust rows of a vessel file: those ahead, those astern, and whether they join.

``vessel`` reads them. Thrust is a quadratic in u and the command speed uc, with one row of a, b, c
for each range of uc/u (Report 2510). Where two rows meet they must give one thrust, or the boat
would jerk.
"""

from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import Final, NamedTuple

from trainer.config.boat.vessel_records import ThrustSet

ASTERN_BOLLARD: Final = -0.77  # [-] thrust turning astern over that ahead, B4-70 (docs/envelope.md)
DRAG_ASTERN: Final = 1.2  # [-] axial drag astern over that ahead, estimate
MIN_ETA: Final = -100.0  # [-] eta
MAX_JUMP: Final = 0.05  # [-] of the bollard thrust, between rows where they meet
MIN_TOLD_JUMP: Final = 1e-3  # [-] rows printed to three digits may differ by so much


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
        at_rest = next((row for row in ahead if row.eta_min <= 0.0), ahead[-1])
        drag = drag_astern * abs(at_rest.a)
        astern = [
            ThrustSet(eta_min=0.0, a=drag, b=0.0, c=ahead[-1].c, going="astern"),
            ThrustSet(eta_min=MIN_ETA, a=drag, b=0.0, c=ahead[0].c, going="astern"),
        ]
    return ThrustRows(tuple(ahead), (astern[0], astern[-1]))


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


class RowJoint(NamedTuple):
    """A place where two rows meet, and the force that each makes there."""

    where: str
    one: float  # [-] of rho/2 L^2 times that speed squared
    other: float


def _row_joints(thrust: ThrustRows) -> Iterator[RowJoint]:
    """Yield where neighbouring rows meet.

    Rows i and j with a break at eta = e are to have a_i + b_i e + c_i e^2 = a_j + b_j e + c_j e^2;
    with the boat at rest it is c that is to be the same.
    """
    for way, rows in zip(ThrustRows._fields, thrust, strict=True):
        for upper, lower in pairwise(rows):
            e = upper.eta_min
            at_most = max(1.0, e * e)  # u and u_c are both within the largest command speed
            one, other = ((row.a + row.b * e + row.c * e * e) / at_most for row in (upper, lower))
            yield RowJoint(f"eta = {e:g}, going {way}", one, other)
    ahead, (back, check) = thrust
    yield RowJoint("u = 0, turning astern", ahead[-1].c, back.c)
    yield RowJoint("u = 0, turning ahead", ahead[0].c, check.c)


def _row_jumps(thrust: ThrustRows, force: float) -> Iterator[tuple[float, str]]:
    """Yield each jump as a share of the bollard thrust [-], and in words with its kN.

    ``force`` [N] is rho/2 L^2 times the largest command speed squared.
    """
    bollard = thrust.ahead[0].c or max(abs(row.a) for row in thrust.ahead)
    for joint in _row_joints(thrust):
        jump = abs(joint.one - joint.other)
        share = jump / (abs(bollard) or jump) if jump else 0.0
        text = f"{force * jump / 1e3:.4g} kN, {share:.1%} of the bollard thrust"
        yield share, f"sets: the rows do not join at {joint.where}: the thrust jumps by {text}"


def joint_remarks(thrust: ThrustRows, force: float) -> list[str]:
    """Return the jumps between rows that are seen and allowed, as ``_row_jumps`` has them."""
    jumps = _row_jumps(thrust, force)
    return [text for share, text in jumps if MIN_TOLD_JUMP < share < MAX_JUMP]


def thrust_problems(thrust: ThrustRows, force: float) -> list[str]:
    """Return where rows do not join, and whether an astern bell drives the boat ahead.

    ``force`` [N] is as in ``_row_jumps``.
    """
    ahead, _ = thrust
    jumps = _row_jumps(thrust, force)
    problems = [
        f"{text}: must be below {MAX_JUMP:.0%}" for share, text in jumps if share >= MAX_JUMP
    ]
    bollard = ahead[-1].c
    if bollard > 0.0 or (bollard == 0.0 and ahead[0].c > 0.0):
        problems.append(
            f"sets: c = {bollard:g} in the row of eta below 0 drives the boat ahead on an astern "
            f"bell: must be below 0, such as {ASTERN_BOLLARD:g} of c ahead = "
            f"{ASTERN_BOLLARD * ahead[0].c:.6g}"
        )
    return problems
