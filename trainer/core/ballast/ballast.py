"""One tick of tanks and air, and the weight and balance that follow.

Program EC430 [ASSES] with erratum F6: x_G = (W0 x0 + sum Wi xi)/W, likewise y_G, z_G, and W = W0 +
sum Wi, where W0 is the boat with all of these tanks empty. Here the sum is taken over departures
from the vessel's own weight and balance, which hold at the start fillings: the same sum, and exact
to the bit there. Water counts at the centre of its tank, and air counts nothing. The inertias stay
as they are, as in the report.
"""

from trainer.core.ballast.air import at_work, compress, fill_with_air, work_blown_tank
from trainer.core.ballast.pumps import work_pumps
from trainer.core.ballast.tanks import (
    ATMOSPHERIC_PRESSURE,
    DEPTH_CONTROL,
    DISCHARGE_COEFFICIENT,
    FIRST_DRY,
    NEGATIVE_TANK,
    TANKS_END,
    TRIM_FORWARD,
    admit,
    sea_pressure,
    through_hole,
)
from trainer.core.elementary import cosine_and_sine
from trainer.core.kernel import Record, inline_kernel, kernel


@inline_kernel
def balance(vessel: Record, state: Record) -> None:
    """Write weight [N] and centre of gravity [m] from the water aboard."""
    c = vessel[0]
    s = state[0]
    weight, x, y, z = 0.0, 0.0, 0.0, 0.0
    for i in range(TANKS_END):
        more = (s.water[i] - c.start[i]) * c.g
        if more == 0.0:
            continue
        weight += more
        x += more * (c.x[i] - c.x_g)
        y += more * (c.y[i] - c.y_g)
        z += more * (c.z[i] - c.z_g)
    s.weight = c.weight + weight
    s.x_g = c.x_g + x / s.weight
    s.y_g = c.y_g + y / s.weight
    s.z_g = c.z_g + z / s.weight


@inline_kernel
def flood_breach(vessel: Record, tank: int, depth: float, h: float, state: Record) -> None:
    """Flood a tank or compartment through its hole.

    The hole is at ``depth`` [m] and open for ``h`` [s]. The flow is that of an orifice. A pumped
    tank is vented inboard and fills up. A compartment is sealed: the sea enters until the air in it
    has the pressure of the sea.
    """
    c = vessel[0]
    s = state[0]
    outside = sea_pressure(c.rho * c.g, depth)
    limit, inside = c.capacity[tank], ATMOSPHERIC_PRESSURE
    if tank >= FIRST_DRY:
        limit *= 1.0 - ATMOSPHERIC_PRESSURE / outside
        inside = ATMOSPHERIC_PRESSURE / (1.0 - min(s.water[tank], limit) / c.capacity[tank])
    area = DISCHARGE_COEFFICIENT * s.breach[tank - TRIM_FORWARD]
    amount = min(through_hole(c.rho, area, outside - inside) * h, limit - s.water[tank])
    if amount > 0.0:
        admit(vessel, tank, amount, state)


@inline_kernel
def is_quiet(vessel: Record, state: Record) -> bool:
    """Return whether no tank has a hole, and no blown tank has anything to do.

    The tick then passes the tanks by, which saves their trigonometry.
    """
    s = state[0]
    busy = False
    for i in range(s.breach.size):
        busy |= s.breach[i] > 0.0
    for i in range(NEGATIVE_TANK + 1):
        busy |= at_work(vessel, i, state)
    return not busy


@inline_kernel
def flow_through_holes(vessel: Record, h: float, state: Record) -> None:
    """Advance the tanks that are open to the sea by ``h`` [s]."""
    c = vessel[0]
    s = state[0]
    cos_th, sin_th = cosine_and_sine(s.theta)
    cos_phi, sin_phi = cosine_and_sine(s.phi)
    down_x, down_y, down_z = -sin_th, cos_th * sin_phi, cos_th * cos_phi
    for i in range(TRIM_FORWARD, TANKS_END):
        if s.breach[i - TRIM_FORWARD] > 0.0 and c.capacity[i] > 0.0:
            depth = s.z + down_x * c.x[i] + down_y * c.y[i] + down_z * c.z[i]
            flood_breach(vessel, i, depth, h, state)
    for i in range(NEGATIVE_TANK + 1):
        if at_work(vessel, i, state):
            depth = s.z + down_x * c.x[i] + down_y * c.y[i] + down_z * c.z[i]
            work_blown_tank(vessel, i, depth, h, state)


@inline_kernel
def advance_ballast(vessel: Record, h: float, state: Record) -> None:
    """Advance pumps, leaks, air and water by ``h`` [s] as ordered; then weight and balance.

    Orders and faults are read from the state; depth and attitude are the present ones.
    """
    c = vessel[0]
    s = state[0]
    if c.fitted == 0.0:
        return
    work_pumps(vessel, h, state)
    if not is_quiet(vessel, state):
        flow_through_holes(vessel, h, state)
    if s.compressor > 0.0:
        compress(vessel, h, state)
    balance(vessel, state)


@kernel
def start_ballast(vessel: Record, state: Record) -> None:
    """Write the start fillings, full banks, and weight and balance.

    The boat is taken as level at its depth.
    """
    c = vessel[0]
    s = state[0]
    if c.fitted == 0.0:
        return
    for i in range(TANKS_END):
        s.water[i] = c.start[i]
    for i in range(NEGATIVE_TANK + 1):
        fill_with_air(vessel, i, s.z + c.z[i], state)
    for i in range(c.bank_full.size):
        s.bank[i] = c.bank_full[i]
    s.hover_integral = s.water[DEPTH_CONTROL]
    balance(vessel, state)
