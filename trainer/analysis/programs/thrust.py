"""Thrust less drag over speed and command speed: program ZC300.

``cli/workshop/programs`` and the guide show it. [ASSES], the report of 1969, ZC300 with errata F5
and A28-A31: T = rho/2 L^2 (a u^2 + b u uc + c uc^2), the row of a, b and c by eta = uc/u; the
acceleration as printed, T/m, and as flown, T/(m - rho/2 L^3 X_udot).
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

import numpy as np

from trainer.config.boat.vessel import VesselFile
from trainer.report.plots import Curve, Panel
from trainer.report.text import INDENT, titled_table
from trainer.units import KNOT

# fmt: off
THRUST_HEADS: Final = (
    "u\n[kn]", "u_c\n[kn]", "row", "thrust\n[kN]", "T/m\n[m/s2]", "as flown\n[m/s2]",
)
# fmt: on
CURVE_POINTS: Final = 201  # of a curve


@dataclass(frozen=True)
class Thrust:
    """Thrust at one speed and command speed."""

    u_kn: float
    u_c_kn: float
    row: int  # of the vessel's thrust sets, 1 the first
    thrust_N: float  # less drag
    acceleration_m_s2: float  # T/m, as ZC300 prints it
    as_flown_m_s2: float  # T over mass and added mass


@dataclass(frozen=True)
class Break:
    """Where one row of coefficients gives way to the next."""

    eta: float
    jump: float  # [-] of T/(rho/2 L^2 u^2), from the lower row to the upper


@dataclass(frozen=True)
class ThrustReport:
    """All that ``trainer report-1969 thrust`` says about a vessel."""

    vessel: str
    breaks: tuple[Break, ...]
    bollard_N: dict[str, float]  # at rest, at the largest command speed ahead and astern
    points: tuple[Thrust, ...]


def row_at(file: VesselFile, u: float, u_c: float) -> int:
    """Return which thrust set holds, 1 the first, without dividing (erratum A29).

    At rest and going astern the sign of ``u_c`` decides; the two sets astern come last.
    """
    sets = file.thrust.ahead
    if u < 0.0:
        return len(sets) + (1 if u_c < 0.0 else 2)
    if u == 0.0:
        return 1 if u_c >= 0.0 else len(sets)
    upper = (i for i, row in enumerate(sets[:-1], start=1) if u_c >= row.eta_min * u)
    return next(upper, len(sets))


def thrust(file: VesselFile, u: float, u_c: float) -> float:
    """Return thrust less drag [N] at ``u`` and ``u_c`` [m/s]; drag opposes motion astern too."""
    row = (*file.thrust.ahead, *file.thrust.astern)[row_at(file, u, u_c) - 1]
    area = 0.5 * file.fluid.rho * file.hull.length**2
    return area * (row.a * u * u + row.b * u * u_c + row.c * u_c * u_c)


def table_entry(file: VesselFile, u: float, u_c: float) -> Thrust:
    """Return one entry of the table at ``u`` and ``u_c`` [m/s]."""
    force, mass = thrust(file, u, u_c), file.hull.mass
    added = 0.5 * file.fluid.rho * file.hull.length**3 * file.coefficients["X_udot"]
    row = row_at(file, u, u_c)
    return Thrust(u / KNOT, u_c / KNOT, row, force, force / mass, force / (mass - added))


def breaks(file: VesselFile) -> tuple[Break, ...]:
    """Return the limits between the rows and the jump of thrust at each."""
    limits = []
    for upper, lower in pairwise(file.thrust.ahead):
        eta = upper.eta_min
        step = (upper.a - lower.a) + (upper.b - lower.b) * eta + (upper.c - lower.c) * eta * eta
        limits.append(Break(eta, step))
    return tuple(limits)


def command_speeds(file: VesselFile) -> tuple[float, ...]:
    """Return the command speeds [kn] of the bells, zero and the largest among them."""
    bells = file.propulsion.bells_kn.values()
    return tuple(sorted({0.0, *bells, file.propulsion.max_ordered_speed_kn}))


def survey_thrust(
    file: VesselFile, speeds: Iterable[float], commands: Sequence[float]
) -> ThrustReport:
    """Return thrust at ``speeds`` [kn] and every command speed [kn]."""
    furthest = {"ahead": max(commands), "astern": min(commands)}
    return ThrustReport(
        vessel=file.name,
        breaks=breaks(file),
        bollard_N={
            name: thrust(file, 0.0, knots * KNOT)
            for name, knots in furthest.items()
            if (knots > 0.0) == (name == "ahead")
        },
        points=tuple(table_entry(file, u * KNOT, u_c * KNOT) for u in speeds for u_c in commands),
    )


def render(report: ThrustReport) -> str:
    """Return the report as text."""
    rows, last = [], None
    for one in report.points:
        first = "" if one.u_kn == last else f"{one.u_kn:.4g}"
        last = one.u_kn
        accelerations = (one.acceleration_m_s2, one.as_flown_m_s2)
        numbers = (f"{one.u_c_kn:+.4g}", str(one.row), f"{1e-3 * one.thrust_N:+.4g}")
        rows.append((first, *numbers, *(f"{x:+.5f}" for x in accelerations)))
    facts = [
        f"row {i} holds from eta = u_c/u = {one.eta:g} up; there thrust jumps by "
        f"{one.jump:+.3g} rho/2 L^2 u^2"
        for i, one in enumerate(report.breaks, start=1)
    ] or ["one row of coefficients for every eta = u_c/u"]
    for name, force in report.bollard_N.items():
        facts.append(f"at rest, full {name}: {1e-3 * force:+.4g} kN")
    title = "THRUST LESS DRAG (ZC300; as flown: with the added mass)"
    table = titled_table(title, THRUST_HEADS, rows)
    return "\n".join([report.vessel, *(INDENT + fact for fact in facts), *table])


def panels(file: VesselFile, report: ThrustReport) -> tuple[Panel, ...]:
    """Return thrust over speed, a curve for each command speed. Of rest alone over the range."""
    most = max(one.u_kn for one in report.points) or file.run.speed_range_kn[1]
    speeds = np.linspace(0.0, most, CURVE_POINTS)
    curves = []
    for command in dict.fromkeys(one.u_c_kn for one in report.points):
        forces = [1e-3 * thrust(file, u * KNOT, command * KNOT) for u in speeds]
        curves.append(Curve(f"u_c {command:+.3g} kn", speeds, np.array(forces)))
    title = f"{report.vessel}: thrust less drag"
    return (Panel(title, "speed [kn]", "thrust [kN]", tuple(curves), levels=(0.0,)),)
