"""Power: buses, their breakers and tie, overload, and the battery.

Port and starboard are fed by half of the battery each, or one by the other over the tie; the dc bus
is fed by the battery as a whole. A battery gives less the harder it is drained.
"""

from trainer.core.ballast.tanks import DEPTH_CONTROL_PUMP, DRAIN_PUMP, TRIM_PUMP
from trainer.core.kernel import Record, inline_kernel, kernel
from trainer.core.plant.parts import (
    CELLS,
    CONSUMER_COUNT,
    DC,
    DIP,
    FED_COMPRESSOR,
    FED_DEPTH_CONTROL,
    FED_DRAIN,
    FED_GYRO,
    FED_TRIM,
    FIRST_BUS,
    HYDRAULIC_END,
    PORT,
    RUNNING,
    STARBOARD,
)


@inline_kernel
def is_burnt(vessel: Record, item: int, state: Record) -> bool:
    """Return whether a fire has taken a consumer, or a bus after them, away."""
    c = vessel[0]
    place = int(c.burn_place[item])
    return place >= 0 and state[0].burnt[place] >= c.burn_dose[item]


@inline_kernel
def feeding_bus(vessel: Record, consumer: int, state: Record) -> int:
    """Return the bus that feeds a consumer, -1 for none."""
    s = state[0]
    feeders = int(vessel[0].feeders[consumer])
    for bus in range(3):
        if (feeders >> bus) & 1 == 1 and s.bus_dead[bus] == 0.0:
            return bus
    return -1


@inline_kernel
def is_running(consumer: int, state: Record) -> bool:
    """Return whether a consumer draws power where it has any. What is no pump always does."""
    s = state[0]
    if consumer < HYDRAULIC_END:
        return s.hydraulic_pump[consumer] == RUNNING
    if consumer == FED_TRIM:
        return s.to_move[TRIM_PUMP] != 0.0 or s.trim_forward != 0.0
    if consumer == FED_DRAIN:
        return s.to_move[DRAIN_PUMP] != 0.0 or s.drained > 0.0 or s.trim_flood != 0.0
    if consumer == FED_DEPTH_CONTROL:
        return s.to_move[DEPTH_CONTROL_PUMP] != 0.0 or s.hover != 0.0
    if consumer == FED_COMPRESSOR:
        return s.compressor > 0.0
    return True


@kernel
def bus_load(vessel: Record, bus: int, state: Record) -> float:
    """Return what a bus gives [W]."""
    c = vessel[0]
    s = state[0]
    load = (1.0 - s.bus_dead[bus]) * (c.hotel[bus] - s.loads_shed * c.hotel_shed[bus])
    for consumer in range(CONSUMER_COUNT):
        fed = feeding_bus(vessel, consumer, state) == bus
        if fed and is_running(consumer, state) and not is_burnt(vessel, consumer, state):
            load += c.power_drawn[consumer]
    return load


@inline_kernel
def is_sound_bus(vessel: Record, bus: int, state: Record) -> bool:
    """Return whether a bus could be fed from its own part of the battery."""
    s = state[0]
    dips = bus != DC and s.dip_time < s.plant_fault[DIP]
    broken = s.plant_fault[FIRST_BUS + bus] >= 1.0
    empty = s.battery_spent >= vessel[0].battery_full
    return not (empty or dips or broken or is_burnt(vessel, CONSUMER_COUNT + bus, state))


@inline_kernel
def feed_buses(vessel: Record, h: float, state: Record) -> None:
    """Write which buses are live, and open a breaker that carries too much."""
    s = state[0]
    port, starboard = s.breaker_open[PORT] == 0.0, s.breaker_open[STARBOARD] == 0.0
    port_feeds = port and is_sound_bus(vessel, PORT, state)
    starboard_feeds = starboard and is_sound_bus(vessel, STARBOARD, state)
    port_whole = not is_burnt(vessel, CONSUMER_COUNT + PORT, state)
    starboard_whole = not is_burnt(vessel, CONSUMER_COUNT + STARBOARD, state)
    tied = s.bus_tie > 0.0 and port and starboard
    port_live = port_feeds or (tied and starboard_feeds and port_whole)
    starboard_live = starboard_feeds or (tied and port_feeds and starboard_whole)
    s.bus_dead[PORT] = 0.0 if port_live else 1.0
    s.bus_dead[STARBOARD] = 0.0 if starboard_live else 1.0
    s.bus_dead[DC] = 0.0 if is_sound_bus(vessel, DC, state) else 1.0
    s.dip_time = s.dip_time + h if s.plant_fault[DIP] > 0.0 else 0.0
    watch_overload(vessel, h, tied and port_feeds != starboard_feeds, port_feeds, state)


@inline_kernel
def watch_overload(
    vessel: Record,
    h: float,
    single: bool,  # noqa: FBT001 a fact
    port_feeds: bool,  # noqa: FBT001
    state: Record,
) -> None:
    """Open the breaker of what has given too much for too long.

    ``single``: one source feeds both buses over the tie, which then opens too.
    """
    c = vessel[0]
    s = state[0]
    port, starboard = bus_load(vessel, PORT, state), bus_load(vessel, STARBOARD, state)
    worst = port + starboard if single else max(port, starboard)
    if worst <= c.bus_limit:
        s.overload = 0.0
        return
    s.overload += h
    if s.overload < c.overload_time:
        return
    source = port_feeds if single else port >= starboard
    s.breaker_open[PORT if source else STARBOARD] = 1.0
    if single:
        s.bus_tie = 0.0
    s.overload = 0.0


@inline_kernel
def cut_off_consumers(vessel: Record, h: float, state: Record) -> None:
    """Write which consumers are without power. The gyro has a small battery of its own."""
    s = state[0]
    unpowered = 0.0
    for consumer in range(CONSUMER_COUNT):
        dead = feeding_bus(vessel, consumer, state) < 0
        if consumer == FED_GYRO:
            s.gyro_unfed = s.gyro_unfed + h if dead else 0.0
            dead = s.gyro_unfed > vessel[0].gyro_time
        if dead or is_burnt(vessel, consumer, state):
            unpowered += float(1 << consumer)
    s.unpowered = unpowered


@inline_kernel
def lose_cells(vessel: Record, state: Record) -> None:
    """Take from the charge what the cells held that are lost since the last tick.

    It does not come back when they are bridged.
    """
    s, full = state[0], vessel[0].battery_full
    lost = min(max(s.plant_fault[CELLS], 0.0), 1.0)
    if lost > s.cells_gone:
        kept = (1.0 - lost) / (1.0 - s.cells_gone)
        s.battery_spent = full - (full - s.battery_spent) * kept
    s.cells_gone = lost


@kernel
def drain_battery(vessel: Record, h: float, state: Record) -> None:
    """Drain the battery for ``h`` [s] by propeller, loads and losses.

    The propeller's power goes as the cube of its command speed.
    """
    c = vessel[0]
    s = state[0]
    if c.battery_full == 0.0:
        return  # a boat without a plant
    speed = s.u_c / c.screw_speed
    load = bus_load(vessel, PORT, state) + bus_load(vessel, STARBOARD, state)
    power = c.screw_power * abs(speed * speed * speed) + load + bus_load(vessel, DC, state)
    spent = s.battery_spent + h * power * (1.0 + power / c.cell_power)
    s.battery_spent = min(spent, c.battery_full)
    if s.battery_spent == c.battery_full:
        s.plant_touched = 1.0
