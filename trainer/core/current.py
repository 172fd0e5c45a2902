"""Water that moves over ground carries the boat along; shear changes the speed through it.

Speeds u, v, w are through the water, so all forces stay as they are, and a uniform current enters
the rates of x and y alone (Fossen, Handbook of Marine Craft Hydrodynamics and Motion Control). In a
horizontal current that changes with depth, a boat that dives takes its speed over ground along:
what the water gains below, the speed through it loses. The water's own acceleration is zero there
(Auton, Hunt and Prud'homme, J. Fluid Mech. 197 (1988) 241), so its inertia pushes nothing. Left
out: the change over the hull itself, and the lift of the water's rotation.
"""

from trainer.core.elementary import cosine_and_sine
from trainer.core.kernel import Record, inline_kernel, kernel


@inline_kernel
def is_moving(state: Record) -> bool:
    """Return whether there is any current."""
    s = state[0]
    return bool(
        s.water_north != 0.0 or s.water_east != 0.0 or s.shear_north != 0.0 or s.shear_east != 0.0
    )


@inline_kernel
def carry_along(state: Record) -> None:
    """Add the current to the rates of x and y, its shear to the accelerations."""
    s = state[0]
    s.xdot += s.water_north + s.shear_north * s.z
    s.ydot += s.water_east + s.shear_east * s.z
    if s.shear_north == 0.0 and s.shear_east == 0.0:
        return
    cos_phi, sin_phi = cosine_and_sine(s.phi)
    cos_th, sin_th = cosine_and_sine(s.theta)
    cos_psi, sin_psi = cosine_and_sine(s.psi)
    north, east = -s.shear_north * s.zdot, -s.shear_east * s.zdot
    ahead = north * cos_psi + east * sin_psi
    right = east * cos_psi - north * sin_psi
    s.udot += ahead * cos_th
    s.vdot += right * cos_phi + ahead * sin_th * sin_phi
    s.wdot += ahead * sin_th * cos_phi - right * sin_phi


@kernel
def north_and_east(towards: float) -> tuple[float, float]:
    """Return how far north and east a step [-] towards an angle [rad] leads.

    Code outside the core writes currents to the state by it, because the bits of a library's sine
    may differ in the last place.
    """
    return cosine_and_sine(towards)
