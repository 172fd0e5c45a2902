"""Characteristic polynomials, roots, frequency and damping: programs EC140, EC200 and EC320.

``trainer report-1969 modes`` and the guide show them; [ASSES] is the report of 1969 on the
programs. Small motions E dx/dt = F x about straight flight at a frozen speed u0, theta0 = w0 = 0;
the polynomial is det(s E - F). [ASSES] VI with errata E1-E7. With dimensional coefficients, R = z_B
B - z_G W and lines of normal force and pitching moment, EC140's cubic has

    A3 = (Z_wdot - m)(M_qdot - Iy) - M_wdot Z_qdot
    A2 = u0 Z_w (M_qdot - Iy) + (Z_wdot - m) u0 M_q - M_wdot u0 (m + Z_q) - u0 M_w Z_qdot
    A1 = u0^2 Z_w M_q + (Z_wdot - m) R - u0^2 M_w (m + Z_q)
    A0 = u0 Z_w R

A term with |.| has no linear part; quasi-linear averages stand for it: a mean |w| adds Z_waw |w| to
u0 Z_w, a mean |p| adds K_pap |p| to u0 K_p, and so on.

Near a calm surface (Tables 12 and 13) Z_w and M_w are those of the depth, and Z_star and M_star
change with it, by the vessel's tables. The slopes of the latter, with z' = w - u0 theta, make the
cubic a quartic, and enter the depth loop.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, Final, NamedTuple

import numpy as np

from trainer.boat.assemble import body_values, thrust_rows
from trainer.boat.depths import (
    SurfaceForces,
    near_surface,
    require_covered,
    surface_at,
    surface_remarks,
)
from trainer.boat.linear import Matrix, Mode, modes
from trainer.config.boat.vessel import VesselFile
from trainer.core.autopilot.report_law import (
    REPORT_CLIMB,
    REPORT_DEPTH,
    REPORT_PITCH,
    REPORT_PITCH_RATE,
)
from trainer.core.vessel import vessel_record
from trainer.report.plots import Curve, Panel
from trainer.report.text import INDENT, format_number, root_text, table, titled_table, wrap
from trainer.units import KNOT

VERTICAL_STATES: Final = ("w", "q", "theta")
HORIZONTAL_STATES: Final = ("v", "p", "r", "phi")
DEPTH_LOOP_STATES: Final = ("w", "q", "theta", "z")
# quasi-linear coefficients of the vertical and of the horizontal plane
VERTICAL_COEFFICIENTS: Final = ("Z_w", "M_w", "M_q")
HORIZONTAL_COEFFICIENTS: Final = ("Y_v", "K_v", "N_v", "Y_p", "K_p", "N_r")
# fmt: off
SURFACE_HEADS: Final = (
    "speed\n[kn]", "Z_star\nx 1000", "M_star\nx 1000", "Z\n[kN]", "M\n[kN m]",
    "dZ_star/dz\n[1e-3/m]", "dM_star/dz\n[1e-3/m]",
)
# fmt: on
ROOT_HEADS: Final = ("", "root\n[1/s]", "|s|\n[rad/s]", "damping\nratio", "period\n[s]", "")


class MeanMotions(NamedTuple):
    """Averages of the motions for the quasi-linear coefficients, in consistent units."""

    v: float = 0.0  # |v|, speed
    w: float = 0.0  # |w|
    p: float = 0.0  # |p|, angular speed
    q: float = 0.0  # |q|
    r: float = 0.0  # |r|


STEADY_MOTIONS: Final = MeanMotions()


class PlaneLaw(NamedTuple):
    """Plane angle per depth error, pitch, climb rate and pitch rate."""

    depth: float = REPORT_DEPTH  # [rad/m]
    pitch: float = REPORT_PITCH  # [-]
    climb: float = REPORT_CLIMB  # [rad s/m]
    pitch_rate: float = REPORT_PITCH_RATE  # [s]


@dataclass(frozen=True)
class LinearSystem:
    """The system E dx/dt = F x, in the order of ``names``. It is in SI or the vessel's units."""

    names: tuple[str, ...]
    E: Matrix
    F: Matrix

    @property
    def nature(self) -> Matrix:
        """Return A of dx/dt = A x."""
        return np.asarray(np.linalg.solve(self.E, self.F))

    @property
    def polynomial(self) -> tuple[float, ...]:
        """Return the coefficients of det(s E - F), the highest power first."""
        polynomial = np.linalg.det(self.E) * np.poly(self.nature)
        return tuple(float(factor) for factor in np.real(polynomial))

    @property
    def eigenvalues(self) -> np.ndarray:
        """Return the eigenvalues [1/s]."""
        return np.asarray(np.linalg.eigvals(self.nature), complex)


def dimensional_constants(file: VesselFile) -> Any:
    """Return the constants of the full set, coefficients dimensional, in the vessel's units."""
    rows, eta = thrust_rows(file)
    return vessel_record(body_values(file), {**file.coefficients, **rows}, eta)[0]


def vertical_system(
    file: VesselFile, speed: float, means: MeanMotions = STEADY_MOTIONS
) -> LinearSystem:
    """Return EC140's motions w, q, theta at ``speed`` [m/s]; x_G is left out, as there."""
    c = dimensional_constants(file)
    Zw = speed * c.Z_w + c.Z_waw * means.w + c.Z_waq * means.q
    Mw = speed * c.M_w + c.M_waw * means.w
    Mq = speed * c.M_q + c.M_awq * means.w + c.M_qaq * means.q
    couple = c.z_b * c.buoyancy - c.z_g * c.weight
    E = [
        [c.mass - c.Z_wdot, -c.Z_qdot, 0.0],
        [-c.M_wdot, c.I_y - c.M_qdot, 0.0],
        [0.0, 0.0, 1.0],
    ]
    F = [
        [Zw, speed * (c.mass + c.Z_q), 0.0],
        [Mw, Mq, couple],
        [0.0, 1.0, 0.0],
    ]
    return LinearSystem(VERTICAL_STATES, np.array(E), np.array(F))


def horizontal_system(
    file: VesselFile, speed: float, means: MeanMotions = STEADY_MOTIONS
) -> LinearSystem:
    """Return EC200's motions v, p, r, phi at ``speed`` [m/s]."""
    c = dimensional_constants(file)
    u, m = speed, c.mass
    E = [
        [m - c.Y_vdot, -(c.Y_pdot + m * c.z_g), m * c.x_g - c.Y_rdot, 0.0],
        [-(c.K_vdot + m * c.z_g), c.I_x - c.K_pdot, -(c.I_xz + c.K_rdot), 0.0],
        [m * c.x_g - c.N_vdot, -(c.I_xz + c.N_pdot), c.I_z - c.N_rdot, 0.0],
        [0.0, 0.0, 0.0, 1.0],
    ]
    Yv = u * c.Y_v + c.Y_vav * means.v + c.Y_var * means.r
    Kv = u * c.K_v + c.K_vav * means.v
    Nv = u * c.N_v + c.N_vav * means.v
    Nr = u * c.N_r + c.N_avr * means.v + c.N_rar * means.r
    Yp = u * c.Y_p + c.Y_pap * means.p
    Kp = u * c.K_p + c.K_pap * means.p
    righting = c.z_g * c.weight - c.z_b * c.buoyancy
    F = [
        [Yv, Yp, u * (c.Y_r - m), c.weight - c.buoyancy],
        [Kv, Kp, u * (c.K_r + m * c.z_g), -righting],
        [Nv, u * c.N_p, Nr - u * m * c.x_g, c.x_g * c.weight - c.x_b * c.buoyancy],
        [0.0, 1.0, 0.0, 0.0],
    ]
    return LinearSystem(HORIZONTAL_STATES, np.array(E), np.array(F))


def with_depth(free: LinearSystem, speed: float) -> LinearSystem:
    """Return the system with depth as a fourth motion: z' = w - ``speed`` theta."""
    E, F = np.eye(4), np.zeros((4, 4))
    E[:3, :3], F[:3, :3] = free.E, free.F
    F[3] = [1.0, 0.0, -speed, 0.0]
    return LinearSystem(DEPTH_LOOP_STATES, E, F)


def under_surface(
    linear: LinearSystem, file: VesselFile, speed: float, depth: float
) -> LinearSystem:
    """Return motions w, q, theta, z at ``speed`` [m/s].

    They hold the surface's change with depth [m].
    """
    surface = surface_at(file, speed, depth)
    area = 0.5 * file.fluid.rho * file.hull.length**2 * speed**2
    F = linear.F.copy()
    F[0, 3] += area * surface.Z_star_slope
    F[1, 3] += area * file.hull.length * surface.M_star_slope
    return LinearSystem(linear.names, linear.E, F)


def depth_loop(
    file: VesselFile,
    speed: float,
    stern: float,
    bow: float,
    law: PlaneLaw = PlaneLaw(),  # noqa: B008
) -> LinearSystem:
    """Return w, q, theta, z under [ASSES]'s depth law. Each pair of planes has its own sign.

    DS = DB literally is 1 and 1; the bow planes that help are -1 where Z_db < 0 (errata G3).
    Speed is frozen, but not the surge that pitching causes with z_G: this surge lowers the inertia.
    """
    c = dimensional_constants(file)
    free = with_depth(vertical_system(file, speed), speed)
    E, F = free.E, free.F
    E[1, 1] -= (c.mass * c.z_g) ** 2 / (c.mass - c.X_udot)
    angle = [-law.climb, law.pitch_rate, law.pitch + law.climb * speed, -law.depth]
    F[0] += speed**2 * (stern * c.Z_ds + bow * c.Z_db) * np.array(angle)
    F[1] += speed**2 * (stern * c.M_ds + bow * c.M_db) * np.array(angle)
    return LinearSystem(DEPTH_LOOP_STATES, E, F)


def quasi_linear(file: VesselFile, speed: float, means: MeanMotions) -> dict[str, float]:
    """Return the quasi-linear coefficients [-] that stand for the linear ones at ``speed``."""
    c, length = file.coefficients, file.hull.length
    v, w = means.v / speed, means.w / speed
    p, q, r = (rate * length / speed for rate in (means.p, means.q, means.r))
    return {
        "Z_w": c["Z_w"] + c["Z_waw"] * w + c["Z_waq"] * q,
        "M_w": c["M_w"] + c["M_waw"] * w,
        "M_q": c["M_q"] + c["M_awq"] * w + c["M_qaq"] * q,
        "Y_p": c["Y_p"] + c["Y_pap"] * p,
        "K_p": c["K_p"] + c["K_pap"] * p,
        "Y_v": c["Y_v"] + c["Y_vav"] * v + c["Y_var"] * r,
        "K_v": c["K_v"] + c["K_vav"] * v,
        "N_v": c["N_v"] + c["N_vav"] * v,
        "N_r": c["N_r"] + c["N_avr"] * v + c["N_rar"] * r,
    }


@dataclass(frozen=True)
class Root:
    """One real root, or one pair, real +- i imaginary."""

    name: str
    real: float  # [1/s]
    imaginary: float  # [1/s] not negative
    frequency_rad_s: float  # |s|
    damping_ratio: float  # -Re s/|s|: 1 or -1 for a real root
    period_s: float | None  # None: it does not swing
    stable: bool


@dataclass(frozen=True)
class Motion:
    """The polynomial and roots of one plane of motion."""

    polynomial: tuple[float, ...]  # SI, highest power first
    roots: tuple[Root, ...]


@dataclass(frozen=True)
class SpeedModes:
    """All that EC140, EC200 and EC320 say about one speed."""

    speed_kn: float
    adjusted: dict[str, float]  # [-]
    vertical: Motion
    horizontal: Motion
    depth_loop: Motion  # with the planes by the 1969 autopilot


@dataclass(frozen=True)
class ModesReport:
    """All that ``trainer report-1969 modes`` says about a vessel; means SI."""

    vessel: str
    means: dict[str, float]
    bow_sign: float  # of the bow planes in the depth loop
    speeds: tuple[SpeedModes, ...]
    depth_m: float | None  # None: deep water
    surface: tuple[SurfaceForces, ...]  # by speed; none in deep water
    remarks: tuple[str, ...]


def motion_modes(linear: LinearSystem) -> Motion:
    """Return polynomial and roots, by motion and then fastest first.

    Where depth is one of the motions, pitch and depth share all roots: their name is ``depth``.
    """
    if "z" not in linear.names:
        mode_list = modes(linear.nature, linear.names)
    else:  # fastest first
        values = sorted(linear.eigenvalues, key=lambda value: -abs(value))
        mode_list = [Mode("depth", float(s.real), float(s.imag)) for s in values if s.imag >= 0.0]
    roots = []
    for mode in mode_list:
        size = abs(mode.eigenvalue)
        ratio = -mode.real / size if size > 0.0 else 0.0
        numbers = (mode.real, mode.imaginary, size, ratio, mode.period)
        roots.append(Root(mode.name, *numbers, mode.stable))
    return Motion(linear.polynomial, tuple(roots))


def report_modes(
    file: VesselFile, speeds: Iterable[float], means: MeanMotions, depth: float | None = None
) -> ModesReport:
    """Return polynomials and roots at ``speeds`` [kn], ``means`` [m/s, rad/s] averaged in.

    At a ``depth`` [m] near the surface the vertical plane has four roots. ConfigError if the
    vessel file cannot tell them.
    """
    require_covered(file, depth)
    speeds = tuple(speeds)
    lift = file.coefficients["Z_db"]  # 0: the bow planes have no lift, else its sign helps
    bow = math.copysign(1.0, lift) if lift else 0.0
    near = () if depth is None else tuple(surface_at(file, at * KNOT, depth) for at in speeds)
    return ModesReport(
        vessel=file.name,
        means=means._asdict(),
        bow_sign=bow,
        speeds=tuple(_at_speed(file, knots, means, bow, depth) for knots in speeds),
        depth_m=depth,
        surface=near,
        remarks=surface_remarks(file, depth),
    )


def _at_speed(
    file: VesselFile, knots: float, means: MeanMotions, bow: float, depth: float | None
) -> SpeedModes:
    speed = knots * KNOT
    file = near_surface(file, speed, depth)
    down, loop = vertical_system(file, speed, means), depth_loop(file, speed, 1.0, bow)
    if depth is not None:
        down = under_surface(with_depth(down, speed), file, speed, depth)
        loop = under_surface(loop, file, speed, depth)
    return SpeedModes(
        speed_kn=knots,
        adjusted=quasi_linear(file, speed, means),
        vertical=motion_modes(down),
        horizontal=motion_modes(horizontal_system(file, speed, means)),
        depth_loop=motion_modes(loop),
    )


def _motion_lines(title: str, motion: Motion) -> list[str]:
    """Return the polynomial and roots of one plane of motion."""
    factors = " ".join(f"{factor:.6g}" for factor in motion.polynomial)
    rows = [
        (
            root.name,
            root_text(root.real, root.imaginary),
            f"{root.frequency_rad_s:.5f}",
            f"{root.damping_ratio:+.3f}",
            format_number(root.period_s, ".1f"),
            "" if root.stable else "NOT STABLE",
        )
        for root in motion.roots
    ]
    return [f"{INDENT}{title}", f"{INDENT}  {factors}", *table(ROOT_HEADS, rows, 2 * INDENT)]


def _quasi_linear_or_none(report: ModesReport) -> list[str]:
    """Return the quasi-linear coefficients, if any motion is averaged in."""
    means = {name: value for name, value in report.means.items() if value != 0.0}
    if not means:
        return []
    units = {"v": "m/s", "w": "m/s", "p": "rad/s", "q": "rad/s", "r": "rad/s"}
    averages = ", ".join(f"|{name}| {value:.4g} {units[name]}" for name, value in means.items())
    lines = ["", *wrap(f"QUASI-LINEAR COEFFICIENTS x 1000 (EC320; mean {averages})", "")]
    for names in (VERTICAL_COEFFICIENTS, HORIZONTAL_COEFFICIENTS):
        rows = [
            (f"{speed.speed_kn:.4g}", *(f"{1e3 * speed.adjusted[name]:.4f}" for name in names))
            for speed in report.speeds
        ]
        lines += table(("speed\n[kn]", *names), rows)
    return lines


def surface_lines(depth: float | None, surface: Iterable[SurfaceForces]) -> list[str]:
    """Return the table of the calm surface's forces, no lines in deep water."""
    if depth is None:
        return []
    rows = [
        (
            f"{one.speed_kn:.4g}",
            *(f"{1e3 * x:+.5f}" for x in (one.Z_star, one.M_star)),
            *(f"{1e-3 * x:+.2f}" for x in (one.Z_N, one.M_N_m)),
            *(f"{1e3 * x:+.5f}" for x in (one.Z_star_slope, one.M_star_slope)),
        )
        for one in surface
    ]
    return titled_table(f"THE SURFACE AT {depth:g} m (added to deep water)", SURFACE_HEADS, rows)


def render(report: ModesReport) -> str:
    """Return the report as text."""
    bow = {
        1.0: "in the depth loop the bow planes move with the stern planes",
        -1.0: "in the depth loop the bow planes move against the stern planes",
        0.0: "no bow planes in the depth loop",
    }
    lines = [
        report.vessel,
        f"{INDENT}speed frozen; {bow[report.bow_sign]}",
        *(line for text in report.remarks for line in wrap("remark: " + text)),
        *surface_lines(report.depth_m, report.surface),
        *_quasi_linear_or_none(report),
    ]
    for speed in report.speeds:
        cubic = len(speed.vertical.polynomial) == 4
        down = "cubic in s" if cubic else "with depth, quartic in s"
        title = f"vertical plane, EC140: {down}, highest power first [SI]"
        lines += ["", f"{speed.speed_kn:.4g} kn", *_motion_lines(title, speed.vertical)]
        lines += _motion_lines("horizontal plane, EC200: quartic in s", speed.horizontal)
        title = "depth kept by the autopilot of 1969: quartic in s"
        lines += _motion_lines(title, speed.depth_loop)
    return "\n".join(lines)


def _locus(report: ModesReport, title: str, which: str) -> Panel:
    """Return the roots of one plane of motion at every speed."""
    curves = []
    for speed in report.speeds:
        roots: tuple[Root, ...] = getattr(speed, which).roots
        pairs = [(r.real, sign * r.imaginary) for r in roots for sign in (1.0, -1.0)]
        real, imaginary = np.array(sorted(set(pairs))).T
        curves.append(Curve(f"{speed.speed_kn:.4g} kn", real, imaginary, points=True))
    return Panel(title, "real [1/s]", "imaginary [1/s]", tuple(curves), (("", 0.0),))


def panels(report: ModesReport) -> tuple[Panel, ...]:
    """Return the roots of the three motions over speed."""
    where = "" if report.depth_m is None else f", {report.depth_m:g} m down"
    return (
        _locus(report, f"{report.vessel}: vertical plane{where}", "vertical"),
        _locus(report, "horizontal plane", "horizontal"),
        _locus(report, "depth kept by the autopilot of 1969", "depth_loop"),
    )
