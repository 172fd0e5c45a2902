"""The push of the wave filter over the sum of the strips, in expectation.

The filter's waves push on a hull as one wave, of the length of what is left at the depth. So short
waves do not average out over the length as they should. Each strip could have a phase of its own.
The pair of outputs at x ahead of the origin is that at the origin, delayed by 2 t k_p x cos chi of
the peak wave's phase and turned by t^2 k_p x cos chi: the tangent of the wave number, k_p f^2, at a
frequency of t times the peak's.

Both are linear in the white noise, and so is the exact sum over long-crested waves of the spectrum.
So each has a spectrum, and no seeds are needed. Forces are of a boat held in place, below the sea.
"""

import math
from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fits.force_rows import mode_responses
from trainer.boat.assemble import fit_out
from trainer.core.kernel import Numbers
from trainer.core.sea.free_surface import cell
from trainer.core.sea.wave_filter import (
    FLAT,
    FORCE_DEPTHS,
    FORCE_ROWS,
    LENGTH_TABLE,
    PHASE_STEP,
    SLOWEST_CLOCK,
)
from trainer.session.past.options import RunOptions
from trainer.session.past.plan import plan_run
from trainer.units import KNOT

Spectrum = NDArray[np.complex128]

GRID: Final = np.linspace(0.02, 4.0, 4000)  # [-] frequency over the peak's
TANGENT: Final = 0.9  # [-] where the tangent touches: the least of the errors of those tried
HEIGHTS_M: Final = {4: 1.875, 5: 3.25, 6: 5.0}  # [m] significant, by sea state
HEADINGS: Final = {"head": math.pi, "beam": 0.5 * math.pi, "following": 0.0}  # [rad]
SPEEDS_KN: Final = (4.0, 7.0, 10.0)
DEPTH_M: Final = 18.0  # of the origin


class Push(NamedTuple):
    """Root mean squares [N, N m] and mean frequencies [rad/s] of heave force and pitch moment."""

    heave: float
    pitch: float
    heave_frequency: float
    pitch_frequency: float


@dataclass(frozen=True)
class Case:
    """A boat in a sea: significant height [m], where it goes off the waves [rad], speed [m/s]."""

    height: float
    chi: float
    speed: float

    @property
    def omega(self) -> float:
        """Return the peak's frequency [rad/s]."""
        return 0.877 * math.sqrt(0.2092 * BODY.g / self.height)

    @property
    def number(self) -> float:
        """Return the peak's wave number [1/m]."""
        return self.omega**2 / BODY.g

    @property
    def along(self) -> float:
        """Return the boat's speed with the waves over the peak wave's [-]."""
        return self.number * self.speed * math.cos(self.chi) / self.omega


class Hull(NamedTuple):
    """What waves push on [SI]: strips' places and masses in heave, and the lift's derivatives."""

    g: float
    places: Numbers
    masses: Numbers
    Z_w: float
    M_w: float


def hull_of(vessel: str) -> Hull:
    """Return the strips of a shipped boat."""
    plan = plan_run(RunOptions(vessel=vessel))
    c = fit_out(plan.file, plan.method).vessel[0]
    places, displaced, heave, _ = np.array(c.strips)
    masses = float(c.buoyancy / c.g) * displaced - float(c.Z_wdot) * heave
    return Hull(float(c.g), places * float(c.ell), masses, float(c.Z_w), float(c.M_w))


BODY: Final = hull_of("bb2")


def pushes(strips: Spectrum, swing: Spectrum, case: Case) -> tuple[Spectrum, Spectrum]:
    """Return heave force and pitch moment, by the acceleration at the strips and the flow."""
    heave = BODY.masses @ strips - BODY.Z_w * case.speed * swing
    pitch = -(BODY.masses * BODY.places) @ strips - BODY.M_w * case.speed * swing
    return heave, pitch


def told_push(forces: tuple[Spectrum, Spectrum], met: Numbers, density: float) -> Push:
    """Return what spectra amount to; ``met`` [rad/s] are the frequencies that the boat meets."""
    powers = [np.abs(each) ** 2 * density * (GRID[1] - GRID[0]) for each in forces]
    sizes = [math.sqrt(float(each.sum())) for each in powers]
    means = [float((each * np.abs(met)).sum() / each.sum()) for each in powers]
    return Push(*sizes, *means)


def exact_push(case: Case) -> Push:
    """Return the push of long-crested waves, each strip by each wave's own length."""
    k, x = case.number, GRID
    energy = 5.0 * x**-5 * np.exp(-1.25 * x**-4)
    fading = BODY.g * k * x * x * np.exp(-k * DEPTH_M * x * x)
    pull = 0.25 * case.height * np.sqrt(energy) * fading
    turn = np.exp(-1j * k * math.cos(case.chi) * BODY.places[:, None] * x * x)
    forces = pushes(turn * pull, np.asarray(-1j * pull / (case.omega * x)), case)
    return told_push(forces, case.omega * (x - case.along * x * x), 1.0)


def filter_push(case: Case, *, own_phase: bool) -> Push:
    """Return the push of the wave filter, by one wave or by each strip's own phase."""
    k = case.number
    row, inside = cell(FORCE_DEPTHS, FORCE_DEPTHS.size, k * DEPTH_M)
    rows, length = (
        table[FLAT, row] + inside * (table[FLAT, row + 1] - table[FLAT, row])
        for table in (FORCE_ROWS, LENGTH_TABLE)
    )
    size = 0.25 * case.height * BODY.g * k * math.exp(-k * DEPTH_M)
    rise, swing = size * (mode_responses(FLAT, GRID) @ rows).T
    way = k * math.cos(case.chi) * BODY.places[:, None]
    turn, delay = (-(TANGENT**2) * way, 2.0 * TANGENT * way) if own_phase else (length * way, 0.0)
    strips = np.exp(-1j * delay * GRID) * (np.cos(turn) * rise + np.sin(turn) * swing)
    clock = max(1.0 - 2.0 * case.along, SLOWEST_CLOCK)
    forces = pushes(strips, swing / (case.omega * math.sqrt(length)), case)
    return told_push(forces, case.omega * (clock * GRID + case.along), PHASE_STEP / math.pi)


def ratios(state: int, heading: str, knots: float, *, own_phase: bool) -> Push:
    """Return the filter's push over the exact one [-]."""
    case = Case(HEIGHTS_M[state], HEADINGS[heading], knots * KNOT)
    filtered, exact = filter_push(case, own_phase=own_phase), exact_push(case)
    return Push(*(one / other for one, other in zip(filtered, exact, strict=True)))


def strip_lines() -> list[str]:
    """Return all ratios, a line for each case: as it is, then by each strip's own phase."""
    return [
        f"sea state {state}, {heading}, {knots:g} kn: "
        + "; ".join(
            " ".join(f"{each:.2f}" for each in ratios(state, heading, knots, own_phase=own))
            for own in (False, True)
        )
        for state in HEIGHTS_M
        for heading in HEADINGS
        for knots in SPEEDS_KN
    ]
