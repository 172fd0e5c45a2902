"""Boats whose centres lie off the middle plane, or that have products of inertia."""

import shutil
import tomllib
from pathlib import Path

import numpy as np
import pytest
from bench.standard_hour import digest
from c_twin.compiler import SAME_BITS, build
from helpers.boats import start_boat, take_ticks
from helpers.lanes import sample_cases
from helpers.loops import in_a_loop

from trainer.boat.assemble import Method
from trainer.boat.boat import Boat
from trainer.config.boat.vessel import read_vessel
from trainer.core import compact as compact_set
from trainer.core.ballast.buoyancy import add_compression
from trainer.core.ballast.tanks import TANKS
from trainer.core.rates import rates
from trainer.core.state import MOTION
from trainer.core.surfaced import add_waterplane

pytestmark = pytest.mark.core

# Only what both sets have: no term of the full set that the compact set drops; it takes Iy = Iz in
# the roll equation, too.
SAME_IN_BOTH = """
[fluid]
rho = 1025.0
g = 9.81

[vessel]
length = 70.2
mass = 4418825.0
weight = 43348676.0
buoyancy = 43100000.0
cg = [0.3, 0.2, 0.1]
cb = [0.5, -0.15, -0.44]
Ix = 5.23e7
Iy = 1.37e9
Iz = 1.37e9
Ixy = 2.1e7
Iyz = -1.3e7
Ixz = 1.7e7

[[propulsion.sets]]
eta_min = 0.0
a = -0.001
b = -0.002
c = 0.003

[coefficients]
X_udot = -1.2e-3
Y_vdot = -3.0e-2
Y_pdot = -4.0e-4
Y_rdot = -5.0e-5
Z_wdot = -2.1e-2
Z_qdot = -4.5e-4
K_pdot = -4.1e-5
K_vdot = -4.4e-4
K_rdot = -3.6e-5
M_qdot = -1.2e-3
M_wdot = -4.6e-4
N_rdot = -1.4e-3
N_vdot = -5.3e-5
N_pdot = -3.5e-5
Y_v = -6.0e-2
Y_r = 1.6e-3
Z_w = -2.8e-2
K_v = -1.9e-3
K_p = -2.2e-4
M_w = 5.8e-3
M_q = -5.9e-3
N_v = -9.4e-3
N_r = -6.1e-3
N_dr = -7.2e-3
"""
SIX = {  # place in the file of each, and whether the boat's image has it negated
    "y_G": ("cg", 1, True),
    "x_B": ("cb", 0, False),
    "y_B": ("cb", 1, True),
    "I_xy": ("Ixy", None, True),
    "I_yz": ("Iyz", None, True),
    "I_xz": ("Ixz", None, False),
}
ALL = tuple(SIX)
MIRRORED = ("v", "p", "r", "phi", "psi", "y", "vdot", "pdot", "rdot", "delta_r")


def boat_with(kept: tuple[str, ...], equations: str, way: str, side: float = 1.0) -> Boat:
    """Return a boat with those of the six kept; side -1 is its image in the middle plane."""
    table = tomllib.loads(SAME_IN_BOTH)
    hull = table["vessel"]
    for name, (key, place, mirrored) in SIX.items():
        factor = (side if mirrored else 1.0) if name in kept else 0.0
        if place is None:
            hull[key] *= factor
        else:
            hull[key][place] *= factor
    method = Method(equations, way, "exact", "adams2", 0.5)
    return Boat(read_vessel(table, "", Path("boat.toml")), method)


def at(boat: Boat, side: float = 1.0) -> Boat:
    """Return the boat in a motion that no term is zero in, or in its image."""
    s = boat.state
    s.motion[:9] = [5.0, 0.6, -0.3, 0.02, 0.011, -0.017, 0.2, -0.15, 0.4]
    s.rates[:6] = [0.01, 0.02, -0.03, 0.004, -0.002, 0.003]
    s.u_c, s.delta_r, s.z = 6.0, 0.1, 200.0
    for name in MIRRORED:
        s[name] *= side
    return boat


def accelerations(boat: Boat) -> np.ndarray:
    """Return u' v' w' p' q' r' [m/s2, rad/s2]."""
    rates(*boat.records)
    return np.array(boat.state.rates[:6])


@pytest.mark.parametrize("way", ["exact", "lagged"])
@pytest.mark.parametrize("kept", [(), *((name,) for name in SIX), ALL], ids=" ".join)
def test_the_compact_set_has_each_of_the_six_as_the_full_set_has_it(
    way: str, kept: tuple[str, ...]
) -> None:
    full, compact = (accelerations(at(boat_with(kept, e, way))) for e in ("full", "modified"))

    assert compact == pytest.approx(full, rel=1e-12, abs=1e-16)


@pytest.mark.parametrize("equations", ["full", "modified"])
@pytest.mark.parametrize("name", SIX)
def test_each_of_the_six_acts(equations: str, name: str) -> None:
    without, having = (accelerations(at(boat_with(k, equations, "exact"))) for k in ((), (name,)))

    assert abs(having - without).max() > 1e-6


@pytest.mark.laws
@pytest.mark.parametrize("equations", ["full", "modified"])
@pytest.mark.parametrize("way", ["exact", "lagged"])
def test_the_image_of_a_boat_off_centre_moves_as_its_image(equations: str, way: str) -> None:
    ours, image = (
        accelerations(at(boat_with(ALL, equations, way, side), side)) for side in (1.0, -1.0)
    )

    mirror = np.array([1.0, -1.0, 1.0, -1.0, 1.0, -1.0])
    assert image == pytest.approx(mirror * ours, rel=1e-13)


def test_a_tank_beside_the_middle_plane_heels_the_compact_boat() -> None:
    boat = start_boat(5.0, equations="modified")
    assert not compact_set.off_centre(boat.records.compact, boat.records.state)
    tank = TANKS.index("auxiliary")
    boat.vessel.y[tank] = 3.0  # to starboard
    boat.state.water[tank] -= 5000.0

    take_ticks(boat, 40)

    assert boat.state.y_g < 0.0
    assert boat.state.phi < -0.001, "port side down"


def gained_buoyancy(kept: tuple[str, ...], z: float, side: float = 1.0) -> np.ndarray:
    """Return X Y Z [N] K M N [N m] of a squeezed hull at depth z [m]."""
    boat = boat_with(kept, "full", "exact", side)
    boat.vessel.compressibility = 2000.0
    boat.state.z, boat.state.phi, boat.state.theta = z, side * 0.1, 0.2
    force = np.zeros(6)
    add_compression(boat.records.vessel, boat.records.state, force)
    add_waterplane(boat.records.vessel, boat.records.scratch, boat.records.state, force)
    return force


def test_buoyancy_lost_in_the_deep_has_the_arm_of_the_centre_of_buoyancy() -> None:
    amidships, aside = (gained_buoyancy(kept, 300.0) for kept in ((), ("y_B",)))

    moment = np.cross([0.0, -0.15, 0.0], amidships[:3])
    assert aside[:3] == pytest.approx(amidships[:3])
    assert aside[3:] == pytest.approx(amidships[3:] + moment)


def test_the_image_of_a_hull_that_breaks_surface_is_lifted_as_its_image() -> None:
    ours, image = (gained_buoyancy(("y_B",), 5.0, side) for side in (1.0, -1.0))

    assert image == pytest.approx(ours * [1, -1, 1, -1, 1, -1], rel=1e-13)


@pytest.mark.process
@pytest.mark.skipif(
    not shutil.which("gcc") and not shutil.which("cc"), reason="there is no C compiler"
)
@pytest.mark.long
@pytest.mark.parametrize(
    "kept", sample_cases([("y_G",), ("x_B", "y_B", "I_xy"), ALL], ALL), ids=" ".join
)
def test_the_tick_in_plain_c_takes_a_boat_off_centre_to_the_same_bits(
    kept: tuple[str, ...],
) -> None:
    found = []
    for take in (in_a_loop, build(SAME_BITS[0])):
        boat = at(boat_with(kept, "modified", "lagged"))
        boat.state.z = 8.0  # near the surface
        boat.vessel.compressibility = 200.0
        assert take(boat.records, 300) == 0
        found.append(digest(boat))

    assert np.isfinite([boat.state[name] for name in MOTION]).all()
    assert found[0] == found[1]
