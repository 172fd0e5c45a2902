"""``trainer boat sea``: a sea in numbers and pictures: height, period, energy by band, forces.

The plot has a series, in metres and in per cent of its largest as figure 8 of the report of 1969
has it, its spectrum against the target, and the mean suction by depth. The sea is
the one that the core makes in its ticks, not the formula, so that the plot checks it.
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from trainer.config.boat.vessel import VesselFile
from trainer.config.files import ConfigError
from trainer.config.world.sea import SeaFile, sea_settings, step_problem
from trainer.core.kernel import Numbers
from trainer.core.sea.cosine_sum import ANGLE_COS, ANGLE_SIN, BAND_COUNT, DIRECTION_WEIGHTS
from trainer.core.sea.filter_1969 import HIGH_DAMPING, LOW_DAMPING, corner
from trainer.core.sea.forces import MIN_KAPPA, suction
from trainer.core.sea.sea import (
    COSINES,
    DIRECTION,
    GAMMA,
    HEIGHT,
    OLD,
    OMEGA,
    order_sea,
    write_elevations,
)
from trainer.core.sea.wave_filter import STEEPEST_TURN
from trainer.core.state import new_scratch, new_state
from trainer.core.vessel import VESSEL
from trainer.report.plots import Curve, Panel
from trainer.report.text import INDENT, ascii_text, format_number, table, titled_table, wrap
from trainer.units import KNOT

BAND_EDGES: Final = np.arange(6, 20) / 10.0  # [-] where they begin, times the peak frequency
BAND_WIDTH: Final = 0.1  # [-] of a band
SERIES_COUNT: Final = 20  # series of the sea, each by its own seed
SERIES_HOURS: Final = 3.0  # of each
SHOWN_SERIES_S: Final = 400.0  # [s] of the first, as in the report of 1969
# [-] speed with the waves over the peak's, beyond which the filter is untrue
MAX_CHASE_RATIO: Final = 0.15
USUAL_DEPTHS_M: Final = (10.0, 15.0, 20.0, 25.0, 30.0, 40.0, 60.0, 100.0)  # [m]
MIN_DEPARTURE_RATE: Final = 1e-6  # [1/s2] a departure that doubles in ten minutes or more is none
MAX_WAVE_DEPTH: Final = 3.0  # [-] depth times the peak's number, beyond which little is left
HIGHEST_WAVE_RATIO: Final = 1.86  # [-] of the significant height: sqrt(ln 1000/2), Rayleigh's
FREQUENCIES: Final = np.linspace(0.25, 12.0, 20_001)  # [-] of integrals over frequency
# fmt: off
DEPTH_HEADS: Final = (
    "depth\n[m]", "swell\n[m/s]", "suction\n[N]", "water\n[kg]", "less by\n[N/m]", "doubles\n[s]",
)
# fmt: on


@dataclass(frozen=True)
class Seaway:
    """The height, period and direction of a sea, and how it is computed."""

    name: str
    height_m: float  # significant
    period_s: float  # of the peak
    omega_rad_s: float
    wavelength_m: float
    gamma: float  # [-] how much the peak is raised
    from_deg: float
    generator: str
    suction: bool
    longest_step_s: float | None  # None: any
    followed_kn: float | None  # with the waves, from where on the filter is untrue; None: never
    made_of: dict[str, float]  # weights of directions, or constants of the filter of 1969


@dataclass(frozen=True)
class DepthEffect:
    """The effect of the sea on a boat held at a depth of its origin."""

    depth_m: float
    water_m_s: float  # rms vertical speed of the water
    suction_N: float  # mean
    suction_kg: float  # water that holds the boat down against it
    slope_N_m: float  # how much less a metre deeper
    doubling_s: float | None  # in which a departure doubles; None: it does not


@dataclass(frozen=True)
class SpectrumBand:
    """The energy of many series in a band, over that of the spectrum."""

    begin: float  # [-] times the peak frequency
    ratio: float | None
    error: float | None  # standard error of the ratio, by how the series differ


@dataclass(frozen=True)
class SeaReport:
    """All that ``trainer boat sea`` says about a sea. A calm has no depths and no bands."""

    sea: Seaway
    vessel: str
    step_s: float
    depths: tuple[DepthEffect, ...]
    variance: float | None  # of the series, over the ordered one
    bands: tuple[SpectrumBand, ...]


def spectrum(x: Numbers, gamma: float) -> Numbers:
    """Return the density [-] at ``x`` times the peak frequency, of variance 1.

    Pierson-Moskowitz's and Bretschneider's, raised by ``gamma`` as JONSWAP has it.
    """

    def raised(x: Numbers) -> Numbers:
        off = (x - 1.0) / np.where(x <= 1.0, 0.07, 0.09)
        flat = 5.0 * x**-5.0 * np.exp(-1.25 * x**-4.0)
        return np.asarray(flat * gamma ** np.exp(-0.5 * off * off))

    whole = np.linspace(0.25, 60.0, 100_001)
    return np.asarray(raised(x) / np.trapezoid(raised(whole), whole))


def water_speed(settings: Numbers, g: float, depth: float) -> float:
    """Return the rms vertical speed of the water [m/s] at a depth [m]."""
    number = settings[OMEGA] ** 2 / g
    weights = FREQUENCIES**2 * np.exp(-2.0 * number * depth * FREQUENCIES**2)
    energy = float(np.trapezoid(weights * spectrum(FREQUENCIES, settings[GAMMA]), FREQUENCIES))
    return float(0.25 * settings[HEIGHT] * settings[OMEGA]) * math.sqrt(energy)


def made_of(settings: Numbers, g: float) -> dict[str, float]:
    """Return weights of a cosine sum's directions, or constants of the filter of 1969.

    The weights [-] add up to pi/2, as Table 14 of [ASSES] has them; the constants, [rad/s] and [-],
    are those of its Table 15. Empty for any other sea.
    """
    if settings[COSINES]:
        weights = 0.25 * math.pi * BAND_COUNT * np.square(DIRECTION_WEIGHTS)
        degrees = np.degrees(np.arctan2(ANGLE_SIN, ANGLE_COS))
        return {f"{at:.0f} deg": float(a) for at, a in zip(degrees, weights, strict=True)}
    if not settings[OLD]:
        return {}
    low, high = (float(corner(float(settings[OMEGA]), g, which)) for which in (0, 1))
    return {"w_nL": low, "d_L": LOW_DAMPING, "w_nH": high, "d_H": HIGH_DAMPING}


def describe_sea(file: SeaFile, settings: Numbers, g: float) -> Seaway:
    """Return the sea by its settings [SI]."""
    omega = float(settings[OMEGA])
    filtered = settings[COSINES] + settings[OLD] == 0.0
    return Seaway(
        name=file.name,
        height_m=float(settings[HEIGHT]),
        period_s=2.0 * math.pi / omega,
        omega_rad_s=omega,
        wavelength_m=2.0 * math.pi * g / omega**2,
        gamma=float(settings[GAMMA]),
        from_deg=math.degrees(settings[DIRECTION] + math.pi) % 360.0,
        generator=file.sea.generator,
        suction=file.sea.suction == "on",
        longest_step_s=STEEPEST_TURN / omega if filtered else None,
        followed_kn=MAX_CHASE_RATIO * g / omega / KNOT if filtered else None,
        made_of=made_of(settings, g),
    )


def at_depth(vessel: VesselFile, settings: Numbers, depth: float) -> DepthEffect:
    """Return the sea's effect on a boat at a depth [m]. The suction is Pierson-Moskowitz's."""
    added = 0.5 * vessel.fluid.rho * vessel.hull.length**3 * vessel.coefficients["Z_wdot"]
    g, mass = vessel.fluid.g, vessel.hull.buoyancy / vessel.fluid.g - added
    height, omega = float(settings[HEIGHT]), float(settings[OMEGA])
    lift, slope = suction(g, omega, height, depth)
    return DepthEffect(
        depth_m=depth,
        water_m_s=water_speed(settings, g, depth),
        suction_N=mass * lift,
        suction_kg=mass * lift / g,
        slope_N_m=mass * slope,
        doubling_s=math.log(2.0) / math.sqrt(slope) if slope > MIN_DEPARTURE_RATE else None,
    )


def make_series(settings: Numbers, g: float, step: float, count: int, hours: float) -> Numbers:
    """Return elevations [series, tick] over the ordered deviation, at a boat at rest."""
    vessel = np.zeros(1, VESSEL)
    vessel["g"] = g
    elevations = np.empty((count, round(3600.0 * hours / step)))
    for seed, row in enumerate(elevations, start=1):
        sea, state = new_scratch(), new_state()
        state["seed"] = seed
        order_sea(vessel, step, 0.0, settings, sea, state)
        write_elevations(vessel, step, sea, state, row)
    return np.asarray(elevations / (0.25 * settings[HEIGHT]))


def band_energy(found: Numbers, step: float, omega: float) -> tuple[Numbers, Numbers]:
    """Return frequency over the peak's [-], and the variance (series, frequency) [-]."""
    window = np.hanning(found.shape[1])
    power = abs(np.fft.rfft(found * window)) ** 2
    frequency = 2.0 * np.pi * np.fft.rfftfreq(found.shape[1], step) / omega
    variance = 2.0 * power / (found.shape[1] * np.sum(window * window))
    return np.asarray(frequency, float), np.asarray(variance, float)


def in_bands(x: Numbers, variance: Numbers, gamma: float, step: float) -> tuple[SpectrumBand, ...]:
    """Return the bands. A band above the frequencies that the step can show has no energy."""
    bands = []
    for begin in BAND_EDGES:
        inside = np.linspace(begin, begin + BAND_WIDTH, 201)
        target = float(np.trapezoid(spectrum(inside, gamma), inside))
        ratios = np.sum(variance[:, (x >= begin) & (x < begin + BAND_WIDTH)], axis=1) / target
        error = float(np.std(ratios, ddof=1)) / math.sqrt(len(ratios))
        shown = begin + BAND_WIDTH <= math.pi / step
        found = (float(np.mean(ratios)), error) if shown else (None, None)
        bands.append(SpectrumBand(float(begin), *found))
    return tuple(bands)


def survey(file: SeaFile, vessel: VesselFile, depths: Iterable[float], step: float) -> SeaReport:
    """Return the sea, its effect on a boat at ``depths`` [m], and its series."""
    settings = sea_settings(file, vessel.fluid.g)
    if refused := step_problem(settings, step):
        raise ConfigError(f"{file.path.name}: {refused.reason}")
    sea = describe_sea(file, settings, vessel.fluid.g)
    if sea.height_m == 0.0:
        return SeaReport(sea, vessel.name, step, (), None, ())
    elevations = make_series(settings, vessel.fluid.g, step, SERIES_COUNT, SERIES_HOURS)
    x, variance = band_energy(elevations, step, sea.omega_rad_s)
    return SeaReport(
        sea,
        vessel.name,
        step,
        tuple(at_depth(vessel, settings, depth) for depth in depths),
        float(np.mean(elevations * elevations)),
        in_bands(x, variance, sea.gamma, step * sea.omega_rad_s),
    )


def usual_depths(vessel: VesselFile) -> tuple[float, ...]:
    """Return depths [m] that the boat may be at, its periscope depth among them."""
    deepest = vessel.hull.max_depth_m or USUAL_DEPTHS_M[-1]
    periscope = vessel.run.periscope_depth_m
    own_depth = () if periscope is None else (periscope,)
    return tuple(sorted({*own_depth, *(depth for depth in USUAL_DEPTHS_M if depth <= deepest)}))


def render(report: SeaReport) -> str:
    """Return the report as text."""
    sea = report.sea
    if sea.height_m == 0.0:
        return ascii_text(f"{sea.name}: no waves")
    shape = "Pierson-Moskowitz" if sea.gamma == 1.0 else f"JONSWAP, peak raised {sea.gamma:g} times"
    highest = HIGHEST_WAVE_RATIO * sea.height_m
    facts = [
        f"height       {sea.height_m:.3g} m significant, one in 1000 {highest:.2g} m",
        f"peak         {sea.period_s:.1f} s, {sea.omega_rad_s:.3f} rad/s",
        f"wavelength   {sea.wavelength_m:.0f} m of the peak, from {sea.from_deg:03.0f}",
        f"spectrum     {shape}, by {sea.generator}; suction {'on' if sea.suction else 'off'}",
    ]
    if sea.longest_step_s is not None:
        facts.append(f"step         up to {sea.longest_step_s:.3g} s; here {report.step_s:g} s")
    if sea.followed_kn is not None:
        untrue = f"above {sea.followed_kn:.2g} kn with the waves it is untrue: take cosines"
        facts.append(f"following    {untrue}")
    lines = [ascii_text(sea.name), *(INDENT + fact for fact in facts)]
    if sea.made_of:
        told = ", ".join(f"{name} {number:.4f}" for name, number in sea.made_of.items())
        lines += wrap(f"made of: {told}")
    title = ascii_text(f"AT REST IN {report.vessel}")
    lines += titled_table(title, DEPTH_HEADS, map(_depth_row, report.depths))
    if not sea.suction:
        lines += wrap("suction is off in this sea: the boat does not feel it")
    title = f"ENERGY BY BAND, {SERIES_COUNT} series of {SERIES_HOURS:g} h over the spectrum's"
    lines += ["", title]
    half = (len(report.bands) + 1) // 2
    for bands in (report.bands[:half], report.bands[half:]):
        heads = ["from", *(f"{band.begin:.1f}" for band in bands)]
        rows = (("energy", [band.ratio for band in bands]), ("+-", [band.error for band in bands]))
        lines += table(
            heads, [[name, *(format_number(x, ".2f") for x in row)] for name, row in rows]
        )
    lines += wrap("+-: one standard error, by how the series differ among themselves")
    return "\n".join(lines)


def _depth_row(one: DepthEffect) -> tuple[str, ...]:
    """Return one depth as a line of the table."""
    forces = (f"{number:.0f}" for number in (one.suction_N, one.suction_kg, one.slope_N_m))
    doubling = format_number(one.doubling_s, ".0f")
    return (f"{one.depth_m:g}", f"{one.water_m_s:.3f}", *forces, doubling)


def panels(file: SeaFile, vessel: VesselFile, report: SeaReport) -> tuple[Panel, ...]:
    """Return a series twice, the spectrum, the suction by depth; ConfigError of a calm."""
    sea, x = report.sea, "time [s]"
    if sea.height_m == 0.0:
        raise ConfigError(f"--plot: {file.path.name} is a calm: there is nothing to draw")
    settings, step = sea_settings(file, vessel.fluid.g), report.step_s
    series = make_series(settings, vessel.fluid.g, step, 1, SHOWN_SERIES_S / 3600.0)[0]
    seconds = step * np.arange(1, series.size + 1)
    every = max(round(1.0 / step), 1)  # tick, for a point each second
    seen, half = series[every - 1 :: every], 0.5 * sea.height_m
    whole = Curve("elevation", seconds, 0.25 * sea.height_m * series)
    shares = Curve("elevation", seconds[every - 1 :: every], 100.0 * seen / abs(seen).max())
    title = f"{sea.name}: elevation above a boat at rest"
    then = "the same, as figure 8 of the report of 1969"
    return (
        Panel(title, x, "elevation [m]", (whole,), levels=(-half, half)),
        Panel(then, x, "share of the largest [%]", (shares,), levels=(0.0,)),
        _spectrum_panel(sea, report.bands),
        _suction_panel(vessel, settings, report),
    )


def _spectrum_panel(sea: Seaway, bands: Sequence[SpectrumBand]) -> Panel:
    """Return the target and the energy of series by band [m2 s/rad]."""
    scale = (0.25 * sea.height_m) ** 2 / sea.omega_rad_s
    x = np.linspace(0.4, 2.4, 401)
    middle, density = [], []
    for band in bands:
        inside = np.linspace(band.begin, band.begin + BAND_WIDTH, 51)
        target = float(np.trapezoid(spectrum(inside, sea.gamma), inside)) / BAND_WIDTH
        middle.append(band.begin + 0.5 * BAND_WIDTH)
        density.append(math.nan if band.ratio is None else target * band.ratio)
    frequency, energy = sea.omega_rad_s * np.array(middle), scale * np.array(density)
    curves = (
        Curve("spectrum", sea.omega_rad_s * x, scale * spectrum(x, sea.gamma)),
        Curve(f"{SERIES_COUNT} series", frequency, energy, points=True),
    )
    return Panel("energy by frequency", "frequency [rad/s]", "density [m2 s/rad]", curves)


def _suction_panel(vessel: VesselFile, settings: Numbers, report: SeaReport) -> Panel:
    """Return the mean suction by depth, where it is known."""
    number = settings[OMEGA] ** 2 / vessel.fluid.g
    deepest = min(max(one.depth_m for one in report.depths), MAX_WAVE_DEPTH / number)
    depths = np.linspace(min(MIN_KAPPA / number, 0.5 * deepest), deepest, 101)
    lifts = [1e-3 * at_depth(vessel, settings, float(depth)).suction_N for depth in depths]
    curve = Curve("mean", depths, np.array(lifts))
    periscope = vessel.run.periscope_depth_m
    marks = () if periscope is None else (("periscope depth", periscope),)
    title = "mean suction on the boat"
    return Panel(title, "depth [m]", "suction [kN]", (curve,), marks=marks, levels=(0.0,))
