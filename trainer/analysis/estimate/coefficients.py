"""The coefficients of Report 2510 from the shape of a hull, part by part.

[WF] Whicker and Fehlner, DTMB 933 (1958): lift slopes of low aspect ratio. [PNK] Pitts, Nielsen
and Kaattari, NACA 1307 (1957): interference of wing and body. [DATCOM] section 4.2.1.1. [K] the
ideal-fluid set of Kirchhoff. [HOERNER] Fluid-Dynamic Drag. A formula marked "own" joins known parts
in a new way; its factors are fitted to captive and free-running models: ``constants.toml``.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np

from trainer.analysis.estimate.geometry import Panel, Shape, integral, panels_of_surface, shape_of
from trainer.config.boat.hull import BOW_CONTROL, RUDDER_CONTROL, STERN_CONTROL, X_CONTROL, HullFile
from trainer.config.files import MIN_NONZERO_SIZE
from trainer.core.kernel import Numbers
from trainer.core.terms import COEFFICIENTS
from trainer.units import KNOT

CoefficientValues = dict[str, float]
FittedConstants = Mapping[str, float]

# [DNV] DNV-RP-C205: added mass of a rectangle over that of the ellipse's circle, by the ratio of
# its sides, that across the flow first
RECTANGLE_RATIO: Final = np.log((0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0))
RECTANGLE_DRAG: Final = (2.23, 1.98, 1.70, 1.51, 1.36, 1.21, 1.14)

SECTION_LIFT_SLOPE: Final = 0.9 * 2.0 * math.pi  # [1/rad] of [WF]
VISCOUS_STATION: Final = (0.378, 0.527)  # [DATCOM]: of the length, and of the tail's centroid
DRIFT_DRAG_RATIO: Final = 0.35  # X_vv over Y_v: BB2 0.32, SDV 0.53; own estimate
ROLL_DAMPING: Final = 0.5  # own estimate
# drag of a panel across the flow: its slope already carries part; own estimate
PLATE_DRAG: Final = 0.6
SMALL_SWINGS: Final = 5.0  # that of plates at a low Keulegan number, from BB2's roll decay
# of the strips' remainder: BB2 0.48, the tables of Iowa 0.85; own estimate
MIXED_SHARE: Final = 0.6
PIVOT_POINTS: Final = np.linspace(0.1, 0.6, 11)  # [lengths] ahead of the CG, of a boat that turns
CROSS_FLOW_DRAG: Final = (0.55, 1.1)  # drag above and below that Reynolds number
CRITICAL_REYNOLDS: Final = 4e5
DRIFT_RATIO: Final = 0.15  # [-] of the speed, which goes across
ASTERN_THRUST_RATIO: Final = -0.7  # thrust astern over that ahead; own estimate
UNFITTED_FACTORS: Final = {  # those not fitted, which a draw varies as well
    "cross_flow": 1.0,
    "surface_drag": 1.0,
    "mixed": 1.0,
    "out_of_plane": 1.0,
    "roll_damping": 1.0,
    "roll_drag": 1.0,
    "resistance": 1.0,
}


@dataclass(frozen=True)
class Hull:
    """The numbers of a hull that do not depend on the constants of the method."""

    file: HullFile
    shape: Shape
    panels: tuple[Panel, ...]

    @property
    def ell(self) -> float:
        """Return the reference length [m]."""
        return self.shape.ell

    @property
    def speed(self) -> float:
        """Return the design speed [m/s]."""
        return self.file.speed.design_kn * KNOT


def hull_of(file: HullFile) -> Hull:
    """Return the numbers of a hull from which ``coefficients`` estimates."""
    shape = shape_of(file)
    panels = (panel for each in file.surfaces for panel in panels_of_surface(each, shape))
    return Hull(file, shape, tuple(panels))


def lift_slope(panel: Panel) -> float:
    """Return the lift slope [1/rad] of a panel and its image, [WF]."""
    A, cosine = panel.aspect, math.cos(panel.sweep)
    return SECTION_LIFT_SLOPE * A / (cosine * math.sqrt(A * A / cosine**4 + 4.0) + 1.8)


def on_both(ratio: float) -> float:
    """Return the lift of panel and hull over the panel's alone [-], slender body, [PNK]."""
    return (1.0 + ratio) ** 2


def on_panel(t: float) -> float:
    """Return the lift of the panel beside a hull over the panel's alone [-], [PNK]."""
    if t < 1e-6:
        return 1.0
    first = (1.0 + t**4) * (0.5 * math.atan(0.5 * (1.0 / t - t)) + 0.25 * math.pi)
    second = t * t * (1.0 / t - t + 2.0 * math.atan(t))
    return 2.0 / math.pi * (first - second) / (1.0 - t) ** 2


def strip_masses(shape: Shape) -> tuple[Numbers, Numbers]:
    """Return the added masses of the sections in sway and heave over rho [m2]."""
    b, h = shape.breadth, shape.height
    across, down = math.pi * h * h / 4.0, math.pi * b * b / 4.0
    if not shape.boxy:
        return across, down
    sides = np.log(np.maximum(h, 1e-9) / np.maximum(b, 1e-9))
    across = across * np.interp(sides, RECTANGLE_RATIO, RECTANGLE_DRAG)
    return across, down * np.interp(-sides, RECTANGLE_RATIO, RECTANGLE_DRAG)


def plate_mass(panel: Panel) -> float:
    """Return the added mass of one panel over rho [m3], a flat plate."""
    A = panel.aspect
    return 0.25 * math.pi * panel.chord**2 * panel.span * A / math.sqrt(A * A + 1.0)


def bare_masses(hull: Hull, factor: float) -> CoefficientValues:
    """Return the added masses of the bare hull."""
    s = hull.shape
    across, down = strip_masses(s)
    m3, m4, m5 = (2.0 / s.ell**n for n in (3, 4, 5))
    k1, k2, k3 = s.spheroid.k1, factor * s.spheroid.k2, factor * s.spheroid.k3
    sway = -k2 * integral(across * s.X, s.x) * m4
    heave = k2 * integral(down * s.X, s.x) * m4
    roll = math.pi / 128.0 * integral((s.height**2 - s.breadth**2) ** 2, s.x)
    return {
        "X_udot": -k1 * s.volume * m3,
        "Y_vdot": -k2 * integral(across, s.x) * m3,
        "Z_wdot": -k2 * integral(down, s.x) * m3,
        "N_rdot": -k3 * integral(across * s.X**2, s.x) * m5,
        "M_qdot": -k3 * integral(down * s.X**2, s.x) * m5,
        "Y_rdot": sway,
        "N_vdot": sway,
        "Z_qdot": heave,
        "M_wdot": heave,
        "K_pdot": -roll * m5,
    }


def panel_masses(hull: Hull) -> CoefficientValues:
    """Return the added masses of the panels."""
    masses = dict.fromkeys(("Y_vdot", "Z_wdot", "N_rdot", "M_qdot", "Y_rdot", "Z_qdot"), 0.0)
    masses |= dict.fromkeys(("K_pdot", "K_vdot", "K_rdot"), 0.0)
    L = hull.ell
    for panel in hull.panels:
        ny, nz = panel.normal
        x, r = panel.ahead(0.5) / L, panel.arm / L
        panel_mass = 2.0 / L**3 * plate_mass(panel)
        both = panel_mass * on_both(panel.radius_ratio)
        alone = panel_mass * on_panel(panel.radius_ratio)
        masses["Y_vdot"] -= both * ny * ny
        masses["Y_rdot"] -= both * ny * ny * x
        masses["N_rdot"] -= both * ny * ny * x * x
        masses["Z_wdot"] -= both * nz * nz
        masses["Z_qdot"] += both * nz * nz * x
        masses["M_qdot"] -= both * nz * nz * x * x
        masses["K_pdot"] -= alone * r * r
        masses["K_vdot"] -= alone * r * ny
        masses["K_rdot"] -= alone * r * ny * x
    twins = {"N_vdot": "Y_rdot", "M_wdot": "Z_qdot", "Y_pdot": "K_vdot", "N_pdot": "K_rdot"}
    return masses | {twin: masses[name] for twin, name in twins.items()}


def products(c: Mapping[str, float]) -> CoefficientValues:
    """Return the products of velocities that the added masses entail, [K]."""
    return {
        "X_qq": c["Z_qdot"],
        "X_rr": -c["Y_rdot"],
        "X_rp": -c["Y_pdot"],
        "X_vr": -c["Y_vdot"],
        "X_wq": c["Z_wdot"],
        "Y_pq": -c["Z_qdot"],
        "Y_wp": -c["Z_wdot"],
        "Z_pp": c["Y_pdot"],
        "Z_rp": c["Y_rdot"],
        "Z_vp": c["Y_vdot"],
        "K_vw": c["Z_wdot"] - c["Y_vdot"],
        "K_vq": c["Z_qdot"] + c["Y_rdot"],
        "K_wp": -c["Y_pdot"],
        "K_wr": -(c["Y_rdot"] + c["Z_qdot"]),
        "K_pq": c["K_rdot"],
        "K_qr": c["N_rdot"] - c["M_qdot"],
        "M_pp": -c["K_rdot"],
        "M_rp": c["K_pdot"] - c["N_rdot"],
        "M_vp": -c["Y_rdot"],
        "N_pq": c["M_qdot"] - c["K_pdot"],
        "N_qr": -c["K_rdot"],
        "N_wp": c["Z_qdot"],
        "N_vq": -c["Y_pdot"],
    }


def bare_lift(
    hull: Hull, bare: Mapping[str, float], constants: FittedConstants, drag: float
) -> CoefficientValues:
    """Return the linear coefficients of the bare hull.

    Own: Munk's moment of the ideal fluid, and one viscous force near the stern.
    """
    s = hull.shape
    L = s.ell
    station = VISCOUS_STATION[0] * s.length + VISCOUS_STATION[1] * s.tail_centroid
    k1, k2 = s.spheroid.k1, s.spheroid.k2
    lift = constants["hull_lift"] * 2.0 * (k2 - k1) * s.at(s.area, station) / L**2
    tall = math.sqrt(integral(s.height, s.x) / integral(s.breadth, s.x))
    side, down = lift * tall, lift / tall
    at = -constants["lift_arm"] * (s.length - s.x_G) / L
    surge = bare["X_udot"]
    munk = constants["munk"]
    return {
        "Y_v": -side - drag,
        "N_v": -munk * (surge - bare["Y_vdot"]) - at * side,
        "Y_r": surge - at * side,
        "N_r": bare["Y_rdot"] - at * at * side,
        "Z_w": -down - drag,
        "M_w": munk * (surge - bare["Z_wdot"]) + at * down,
        "Z_q": -surge + at * down,
        "M_q": -bare["Z_qdot"] - at * at * down,
    }


def efficiency(panel: Panel, constants: FittedConstants) -> float:
    """Return the share [-] of its lift slope that a panel keeps on the hull."""
    if panel.sail:
        return constants["sail_lift"]
    return constants["tail_lift"] if panel.aft else 1.0


def panel_lift(hull: Hull, constants: FittedConstants) -> CoefficientValues:
    """Return the linear coefficients of the panels."""
    names = ("Y_v", "N_v", "Y_r", "N_r", "Z_w", "M_w", "Z_q", "M_q")
    terms = dict.fromkeys((*names, "K_v", "K_p", "K_r", "Y_p", "N_p"), 0.0)
    L = hull.ell
    for panel in hull.panels:
        ny, nz = panel.normal
        panel_slope = efficiency(panel, constants) * lift_slope(panel) * panel.area / L**2
        both = panel_slope * on_both(panel.radius_ratio)
        alone = panel_slope * on_panel(panel.radius_ratio)
        x, r = panel.ahead(0.25) / L, panel.arm / L
        # the hull's share beside a sail acts aft of it: its wake on the afterbody
        behind = x - constants["sail_aft"] if panel.sail else x
        first = alone * x + (both - alone) * behind
        second = first * x
        terms["Y_v"] -= both * ny * ny
        terms["N_v"] -= first * ny * ny
        terms["Y_r"] -= first * ny * ny
        terms["N_r"] -= second * ny * ny
        terms["Z_w"] -= both * nz * nz
        terms["M_w"] += both * nz * nz * x
        terms["Z_q"] += both * nz * nz * x
        terms["M_q"] -= both * nz * nz * x * x
        # only the panel's own share makes roll: that of the hull passes through its axis
        roll = constants["roll_arm"] if panel.sail else 1.0
        damping = ROLL_DAMPING * constants["roll_damping"]
        terms["K_v"] -= roll * alone * r * ny
        terms["K_r"] -= roll * alone * r * ny * x
        terms["K_p"] -= damping * alone * r * r
        terms["Y_p"] -= damping * alone * r * ny
        terms["N_p"] -= damping * alone * r * ny * x
    return terms


def control_lift(hull: Hull, constants: FittedConstants) -> CoefficientValues:
    """Return the coefficients of rudder and planes."""
    names = ("Y_dr", "N_dr", "K_dr", "Z_ds", "M_ds", "Z_db", "M_db")
    terms = dict.fromkeys((*names, "X_drdr", "X_dsds", "X_dbdb"), 0.0)
    L = hull.ell
    for panel in hull.panels:
        ny, nz = panel.normal
        C, x = lift_slope(panel), panel.ahead(0.25) / L
        control_slope = panel.share * C * panel.area / L**2 * on_panel(panel.radius_ratio)
        force = control_slope * (constants["tail_control"] if panel.aft else 1.0)
        keeps, half_slope = efficiency(panel, constants), SECTION_LIFT_SLOPE / 2.0
        drag = control_slope * keeps * C / (half_slope * panel.aspect)
        if panel.control in (RUDDER_CONTROL, X_CONTROL):
            terms["Y_dr"] += force * abs(ny)
            terms["N_dr"] += force * abs(ny) * x
            terms["K_dr"] += force * ny * panel.arm / L if panel.control == RUDDER_CONTROL else 0.0
            terms["X_drdr"] -= drag
        if panel.control in (STERN_CONTROL, X_CONTROL):
            terms["Z_ds"] -= force * abs(nz)
            terms["M_ds"] += force * abs(nz) * x
            terms["X_dsds"] -= drag
        if panel.control == BOW_CONTROL:
            terms["Z_db"] -= force * abs(nz)
            terms["M_db"] += force * abs(nz) * x
            terms["X_dbdb"] -= drag
    return terms


def sail_vortex(hull: Hull, constants: FittedConstants) -> CoefficientValues:
    """Return the forces of a sail's vortex on the hull behind it; own, after Mackay."""
    terms = dict.fromkeys(("Z_vv", "Z_vr", "Z_rr", "M_vv", "M_vr", "M_rr"), 0.0)
    s = hull.shape
    for panel in hull.panels:
        if not panel.sail:
            continue
        strength = constants["out_of_plane"] * panel.chord / s.ell * lift_slope(panel)
        behind = s.x >= panel.station(0.25)
        x = s.X[behind] / s.ell
        along = s.x[behind] / s.ell
        i0, i1, i2 = (integral(x**n, along) for n in (0, 1, 2))
        at = panel.ahead(0.25) / s.ell
        terms["Z_vv"] += strength * i0
        terms["Z_vr"] += strength * (i1 + at * i0)
        terms["Z_rr"] += strength * at * i1
        terms["M_vv"] -= strength * i1
        terms["M_vr"] -= strength * (i2 + at * i1)
        terms["M_rr"] -= strength * at * i2
    return terms


def cross_flow_drag(hull: Hull) -> float:
    """Return the drag of the hull's sections across the flow [-]."""
    given_drag = hull.file.speed.cross_flow_drag
    if given_drag is not None:
        return given_drag
    reynolds = DRIFT_RATIO * hull.speed * hull.shape.diameter / hull.file.water.nu
    return CROSS_FLOW_DRAG[0] if reynolds > CRITICAL_REYNOLDS else CROSS_FLOW_DRAG[1]


def cross_flow(hull: Hull, constants: FittedConstants) -> CoefficientValues:
    """Return the coefficients of the drag across the flow, strip by strip."""
    s, L = hull.shape, hull.ell
    C = constants["cross_flow"] * cross_flow_drag(hull)
    X = s.X / L
    plates = [
        (PLATE_DRAG * constants["surface_drag"] * panel.area / L**2, panel) for panel in hull.panels
    ]
    side = [(a * abs(p.normal[0]), p.ahead(0.5) / L) for a, p in plates]
    down = [(a * abs(p.normal[1]), p.ahead(0.5) / L) for a, p in plates]
    along = s.x / L
    terms: CoefficientValues = {}
    for names, width, fins in (
        (("Y_vav", "N_vav", "Y_var", "N_rar", "N_avr"), s.height / L, side),
        (("Z_waw", "M_waw", "Z_waq", "M_qaq", "M_awq"), s.breadth / L, down),
    ):
        drag = Strips(C, X, width, along, fins)
        terms |= dict(zip(names, drag.fitted(MIXED_SHARE * constants["mixed"]), strict=True))
    terms["M_waw"] = -terms["M_waw"]  # M is -X Z; where q takes part it turns the other way too
    terms["K_vav"] = -C * integral(s.height * s.centre, s.x) / L**3
    terms["K_pap"] = 0.0
    for area, panel in plates:
        ny, r = panel.normal[0], panel.arm / L
        terms["K_vav"] -= area * abs(ny) * ny * r
        whole = SMALL_SWINGS * constants["roll_drag"] * panel.area / L**2
        terms["K_pap"] -= whole * abs(r) ** 3
    return terms


@dataclass(frozen=True)
class Strips:
    """The drag of strips and panels in one plane, all in lengths."""

    C: float
    X: Numbers
    width: Numbers
    along: Numbers
    fins: list[tuple[float, float]]  # area times drag, and place

    def pushed(self, v: float, r: float) -> tuple[float, float]:
        """Return force and moment [-] of drag at a speed across and a turn rate."""
        across = v + self.X * r
        load = -self.C * self.width * across * np.abs(across)
        force, moment = integral(load, self.along), integral(load * self.X, self.along)
        for area, x in self.fins:
            at = v + x * r
            force -= area * at * abs(at)
            moment -= area * at * abs(at) * x
        return force, moment

    def fitted(self, mixed: float) -> tuple[float, float, float, float, float]:
        """Return force and moment of drift, the mixed force, moment of turn, mixed moment.

        The mixed ones by least squares over the pivots of a turning boat.
        """
        bare = Strips(self.C, self.X, self.width, self.along, [])
        drift, drift_moment = self.pushed(1.0, 0.0)[0], bare.pushed(1.0, 0.0)[1]
        turn = self.pushed(0.0, 1.0)[1]
        v = -PIVOT_POINTS
        pushed = np.array([self.pushed(each, 1.0) for each in v])
        force = pushed[:, 0] - drift * v * np.abs(v)
        moment = pushed[:, 1] - drift_moment * v * np.abs(v) - turn
        of_force = float(np.sum(force * v) / np.sum(v * v))
        of_moment = float(np.sum(moment * np.abs(v)) / np.sum(v * v))
        return drift, drift_moment, mixed * of_force, turn, mixed * of_moment


def resistance(hull: Hull) -> float:
    """Return the drag ahead [-] on L^2. ITTC 1957 with the form factor of [HOERNER]."""
    s, speed = hull.shape, hull.file.speed
    reynolds = hull.speed * s.length / hull.file.water.nu
    friction = 0.075 / (math.log10(reynolds) - 2.0) ** 2 + speed.roughness
    slim = s.diameter / s.length
    bare = s.wetted * friction * (1.0 + 1.5 * slim**1.5 + 7.0 * slim**3)
    surfaces = sum(
        2.0 * p.area * friction * (1.0 + 2.0 * p.thickness + 60.0 * p.thickness**4) * 1.3
        for p in hull.panels
    )
    drag: float = (bare + surfaces + speed.extra_drag_area) / s.ell**2
    return drag


def revolutions(hull: Hull, drag: float) -> float | None:
    """Return turns a second per m/s [1/m] at which thrust is drag; None without."""
    p = hull.file.propeller
    if p is None:
        return None
    second, first, rest = _thrust_terms(hull)
    root = first * first - 4.0 * second * (rest - drag)
    if second <= 0.0 or root < 0.0:
        return None
    g = (math.sqrt(root) - first) / (2.0 * second)
    return g if g > 0.0 else None


def _thrust_terms(hull: Hull) -> tuple[float, float, float]:
    """Return the factors of g^2, g and 1 in the thrust [m2, m, -] on L^2."""
    p = hull.file.propeller
    if p is None:
        return 0.0, 0.0, 0.0
    D, L2 = p.diameter, hull.ell**2
    thrust_share, slow = 1.0 - p.thrust_deduction, 1.0 - p.wake
    k0, k1, k2 = p.KT
    whole = 2.0 * thrust_share / L2
    return whole * D**4 * k0, whole * D**3 * k1 * slow, whole * D**2 * k2 * slow * slow


def propulsion(hull: Hull, drag: float) -> CoefficientValues:
    """Return the thrust rows and the torque's effect on roll."""
    terms = dict.fromkeys(("K_star", "K_star_eta"), 0.0)
    a, b, c = -drag, 0.0, drag
    p, g = hull.file.propeller, revolutions(hull, drag)
    astern = -c
    if p is not None and g is not None:
        second, first, rest = _thrust_terms(hull)
        a, b, c = rest - drag, first * g, second * g * g
        astern = ASTERN_THRUST_RATIO * c
        J = (1.0 - p.wake) / (g * p.diameter)
        KQ = p.KQ[0] + p.KQ[1] * J + p.KQ[2] * J * J
        hand = 1.0 if p.clockwise_from_astern else -1.0
        torque = 2.0 * g * g * p.diameter**5 * KQ * (1.0 - p.swirl_recovered) / hull.ell**3
        terms = {"K_star": -hand * torque, "K_star_eta": -hand * torque}
    for row in "12":
        terms |= {f"a{row}": a, f"b{row}": b, f"c{row}": c}
    return terms | {"a3": a, "b3": 0.0, "c3": astern}


def coefficients(hull: Hull, constants: FittedConstants) -> CoefficientValues:
    """Return all 131 coefficients of a hull; one without a formula is zero."""
    factors = UNFITTED_FACTORS | dict(constants)
    drag = factors["resistance"] * resistance(hull)
    bare = bare_masses(hull, factors["added_mass"])
    terms = dict.fromkeys((term.key for term in COEFFICIENTS), 0.0)
    masses = add_coefficients(bare, panel_masses(hull))
    terms |= masses | products(masses)
    terms |= add_coefficients(bare_lift(hull, bare, factors, drag), panel_lift(hull, factors))
    terms |= control_lift(hull, factors) | cross_flow(hull, factors)
    terms |= sail_vortex(hull, factors)
    terms["M_vr"] += masses["Y_pdot"]
    terms["M_rr"] += masses["K_rdot"]
    terms["X_vv"] = DRIFT_DRAG_RATIO * abs(terms["Y_v"])
    terms["X_ww"] = DRIFT_DRAG_RATIO * abs(terms["Z_w"])
    terms |= propulsion(hull, drag)
    return {key: value if abs(value) >= MIN_NONZERO_SIZE else 0.0 for key, value in terms.items()}


def add_coefficients(*parts: Mapping[str, float]) -> CoefficientValues:
    """Return the sums of coefficients by name."""
    sums: CoefficientValues = {}
    for part in parts:
        for key, value in part.items():
            sums[key] = sums.get(key, 0.0) + value
    return sums
