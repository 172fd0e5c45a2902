"""Casualties: the table of their kinds, slots of the state, ramps, triggers, instruments.

Eight slots of the state hold the casualties in force, those in use first. A slot has the kind, the
amount [SI] now and in the end, and the ticks left. The ticks are positive while the casualty comes
on, zero while it stands, and negative while it is being cleared. The core knows amounts only; files
that are read say what a severity means. Surfaces, propulsion, autopilot and instruments look their
kinds up. Tanks, air and the plant read faults from the state, which are written here.

Armed triggers are constants of the scheme; the state remembers which of them are spent. Only
stations see casualties of instruments: the autopilot steers by the truth, and the instructor is
shown it.
"""

from typing import Final, NamedTuple

import numpy as np

from trainer.core.ballast.tanks import (
    BANKS,
    COMPARTMENTS,
    FIRST_DRY,
    PUMPED_TANKS,
    PUMPS,
    TRIM_FORWARD,
)
from trainer.core.kernel import Record, inline_kernel, kernel
from trainer.core.noise import GAUGE_NOISE, SOUNDER_NOISE, gaussian
from trainer.core.plant.parts import BUS_NAMES, FED_GYRO, OIL_SYSTEMS, PLACE_NAMES, is_dead
from trainer.core.state import GROUND_DEPTH, SOUNDING_COUNT, VALVES, offset_of
from trainer.core.surfaces import SURFACES

# Of two faults on one surface or gauge only the one that is later in these lists acts.
SURFACE_FAULTS: Final = ("slow", "follow-up-lost", "free", "hard-over", "stuck")
SURFACE_SLOW, FOLLOW_UP_LOST, SURFACE_FREE, HARD_OVER, SURFACE_STUCK = 0, 1, 2, 3, 4
GAUGES: Final = ("depth-gauge", "gyro", "log", "sounder")
DEPTH_GAUGE, GYRO, LOG, SOUNDER = 0, 1, 2, 3
GAUGE_FAULTS: Final = ("noisy", "biased", "stuck")
GAUGE_NOISY, GAUGE_BIASED, GAUGE_STUCK = 0, 1, 2
FREE_SLOT: Final = 0  # kind in a slot that holds none
FIRST_SLOT, NO_SLOT = 0, -1  # of a casualty; those in use come first
SERVO_STUCK: Final = "servo-stuck"  # fault of a surface that its own valve drives
PLANT_SIZE: Final = "oil_full"  # block of the vessel that is 0 in a boat without a plant
SOUNDER_RANGE: Final = 600.0  # [m] to the ground from which it hears an echo


class CasualtyKind(NamedTuple):
    """A kind of casualty: its name, what breaks and how, and where that stands.

    ``equipment`` is a surface, a gauge, or what a part of is broken, such as "pump"; a boat has it
    if the number ``part`` of the vessel's block ``size`` is not 0.
    """

    name: str
    equipment: str
    fault: str
    surface: int = -1  # [-] of SURFACES
    gauge: int = -1  # [-] of GAUGES
    rank: int = -1  # [-] of SURFACE_FAULTS or GAUGE_FAULTS
    offset: int = -1  # in the state: the fault that tanks, air or the plant read
    sense: int = 1  # [-] sign of the amount there
    holds: bool = False  # it holds what it finds, whatever amount it is given
    size: str = ""
    part: int = 0
    plant: bool = False  # it touches the plant, which is computed from then on

    @property
    def turned(self) -> bool:
        """Return whether its amount is an angle of a surface."""
        return self.surface >= 0 and (self.rank >= HARD_OVER or self.fault == SERVO_STUCK)


def _part_kinds(
    wording: str, equipment: str, fault: str, size: str, parts: tuple[str, ...], first: int = 0
) -> tuple[CasualtyKind, ...]:
    """Return a kind for each part, of which ``first`` is the place of the first in the block."""
    return tuple(
        CasualtyKind(
            wording.format(name.removeprefix("compartment_").replace("_", "-")),
            equipment,
            fault,
            size=size,
            part=place,
        )
        for place, name in enumerate(parts, first)
    )


PART_FAULTS: Final = (  # in the order of the faults in the state, which begin at its "breach"
    *_part_kinds("leak-{}", "leak", "hole", "capacity", PUMPED_TANKS, TRIM_FORWARD),
    *_part_kinds("flooding-{}", "flooding", "hole", "capacity", COMPARTMENTS, FIRST_DRY),
    *_part_kinds("pump-{}-failed", "pump", "failed", "pump_rate", PUMPS),
    *_part_kinds("bank-{}-failed", "bank", "failed", "bank_volume", BANKS),
    *_part_kinds("blow-{}-shut", "blow", "shut", "capacity", VALVES),
    *_part_kinds("vent-{}-shut", "vent", "shut", "capacity", VALVES),
)
PLANT_FAULTS: Final = (  # likewise, from its "plant_fault"
    *_part_kinds("hydraulic-{}-failed", "hydraulic", "failed", PLANT_SIZE, OIL_SYSTEMS),
    *_part_kinds("oil-leak-{}", "oil", "leak", PLANT_SIZE, ("header",)),
    *_part_kinds("oil-leak-{}", "oil", "leak", "oil_angle", tuple(SURFACES)),
    *(CasualtyKind(f"bus-{bus}-lost", "bus", "lost", size=PLANT_SIZE) for bus in BUS_NAMES),
    CasualtyKind("cells-lost", "cells", "lost", size=PLANT_SIZE),
    CasualtyKind("power-dip", "power", "dip", size=PLANT_SIZE),
    *(CasualtyKind(f"fire-{place}", "fire", "burning", size=PLANT_SIZE) for place in PLACE_NAMES),
)
CASUALTY_TABLE: Final = (
    *(
        CasualtyKind(
            f"{surface}-{fault}",
            surface,
            fault,
            surface=number,
            rank=rank,
            holds=rank == SURFACE_STUCK,
        )
        for number, surface in enumerate(SURFACES)
        for rank, fault in enumerate(SURFACE_FAULTS)
    ),
    CasualtyKind("propulsion-lost", "propulsion", "lost"),
    CasualtyKind("propulsion-stuck", "propulsion", "stuck", holds=True),
    CasualtyKind("autopilot-failed", "autopilot", "failed"),
    *(kind._replace(offset=offset) for offset, kind in enumerate(PART_FAULTS, offset_of("breach"))),
    *(  # a vent stuck open is a vent shut with the sign turned: one number has both faults
        kind._replace(offset=offset, sense=-1)
        for offset, kind in enumerate(
            _part_kinds("vent-{}-open", "vent", "open", "capacity", VALVES), offset_of("vent_fault")
        )
    ),
    *(
        CasualtyKind(
            f"{name}-{fault}", name, fault, gauge=gauge, rank=rank, holds=rank == GAUGE_STUCK
        )
        for gauge, name in enumerate(GAUGES)
        for rank, fault in enumerate(GAUGE_FAULTS)
    ),
    *(
        kind._replace(offset=offset, plant=True)
        for offset, kind in enumerate(PLANT_FAULTS, offset_of("plant_fault"))
    ),
    *(
        CasualtyKind(
            f"{surface}-{SERVO_STUCK}",
            surface,
            SERVO_STUCK,
            surface=number,
            size="oil_angle",
            part=number,
            plant=True,
        )
        for number, surface in enumerate(SURFACES)
    ),
)
KINDS: Final = tuple(kind.name for kind in CASUALTY_TABLE)
CODES: Final = {name: code for code, name in enumerate(KINDS, start=1)}  # 0: no casualty

# The columns of the table, by code.
_CODED_KINDS: Final = (CasualtyKind("", "", ""), *CASUALTY_TABLE)
KIND_SURFACES: Final = np.array([kind.surface for kind in _CODED_KINDS])
KIND_GAUGES: Final = np.array([kind.gauge for kind in _CODED_KINDS])
KIND_FAULTS: Final = np.array([kind.rank for kind in _CODED_KINDS])
KIND_OFFSETS: Final = np.array([kind.offset for kind in _CODED_KINDS])
KIND_SENSES: Final = np.array([float(kind.sense) for kind in _CODED_KINDS])
KIND_HOLDS: Final = np.array([kind.holds for kind in _CODED_KINDS])
KIND_TURNS: Final = np.array([kind.turned for kind in _CODED_KINDS])
KIND_IN_PLANT: Final = np.array([kind.plant for kind in _CODED_KINDS])
SERVO_CODE: Final = np.array([CODES[f"{surface}-{SERVO_STUCK}"] for surface in SURFACES])
GAUGE_CODE: Final = np.array(
    [[CODES[f"{gauge}-{fault}"] for fault in GAUGE_FAULTS] for gauge in GAUGES]
)
PROPULSION_LOST: Final = CODES["propulsion-lost"]
PROPULSION_STUCK: Final = CODES["propulsion-stuck"]
AUTOPILOT_FAILED: Final = CODES["autopilot-failed"]


@inline_kernel
def slot_of(kind: int, state: Record) -> int:
    """Return the slot [-] that holds ``kind``, NO_SLOT if none does.

    For FREE_SLOT it is the first free slot.
    """
    s = state[0]
    for i in range(s.casualty.size):
        if s.casualty[i] == kind:
            return i
        if s.casualty[i] == FREE_SLOT:
            return NO_SLOT
    return NO_SLOT


@inline_kernel
def fault_of(surface: int, state: Record) -> int:
    """Return the slot [-] of the casualty that acts on a surface, whatever feeds it.

    It is NO_SLOT if the surface is sound.
    """
    s = state[0]
    slot, latest = NO_SLOT, -1
    for i in range(s.casualty.size):
        kind = int(s.casualty[i])
        if kind == FREE_SLOT:
            return slot
        if KIND_SURFACES[kind] == surface and KIND_FAULTS[kind] > latest:
            slot, latest = i, KIND_FAULTS[kind]
    return slot


@kernel
def write_fault(kind: int, amount: float, state: Record) -> None:
    """Write the amount of a fault of tanks, air or the plant to the state.

    Kinds of other equipment have none, because that equipment looks its casualties up.
    """
    if KIND_OFFSETS[kind] >= 0:
        state[0].whole[KIND_OFFSETS[kind]] = KIND_SENSES[kind] * amount


@kernel
def leave(slot: int, state: Record) -> None:
    """Take a casualty out of its slot, and close the gap."""
    s = state[0]
    last = s.casualty.size - 1
    write_fault(int(s.casualty[slot]), 0.0, state)
    for i in range(slot, last):
        s.casualty[i] = s.casualty[i + 1]
        s.casualty_amount[i] = s.casualty_amount[i + 1]
        s.casualty_target[i] = s.casualty_target[i + 1]
        s.casualty_ticks[i] = s.casualty_ticks[i + 1]
    s.casualty[last] = FREE_SLOT
    s.casualty_amount[last] = s.casualty_target[last] = s.casualty_ticks[last] = 0.0


@kernel
def ramp(slot: int, state: Record) -> None:
    """Move the amount of a casualty by one tick towards its target, or towards zero.

    The casualty stays in its slot; ``leave`` takes it out.
    """
    s = state[0]
    ticks = s.casualty_ticks[slot]
    if ticks == 1.0:
        s.casualty_amount[slot] = s.casualty_target[slot]
    elif ticks > 1.0:
        s.casualty_amount[slot] += (s.casualty_target[slot] - s.casualty_amount[slot]) / ticks
    elif ticks < -1.0:
        # the ticks are negative while it is cleared: this takes its share off
        s.casualty_amount[slot] += s.casualty_amount[slot] / ticks
    if ticks > 0.0:
        s.casualty_ticks[slot] = ticks - 1.0
    elif ticks < 0.0:
        s.casualty_ticks[slot] = ticks + 1.0


@inline_kernel
def advance_casualties(state: Record) -> None:
    """Advance all ramps by one tick, then write the faults of tanks, air and plant."""
    s = state[0]
    if s.casualty[FIRST_SLOT] == FREE_SLOT:
        return
    for i in range(s.casualty.size - 1, -1, -1):  # last first: leaving moves the later ones up
        if s.casualty_ticks[i] == -1.0:
            leave(i, state)
        elif s.casualty_ticks[i] != 0.0:
            ramp(i, state)
    for i in range(s.casualty.size):
        if s.casualty[i] != FREE_SLOT:
            write_fault(int(s.casualty[i]), s.casualty_amount[i], state)


@inline_kernel
def sounding(state: Record) -> float:
    """Return how far [m] the ground is below the origin, 0 without an echo."""
    s = state[0]
    # the sounder is amidships; a first depth of 0 means that the exercise has no ground
    height = s.bottom[GROUND_DEPTH, SOUNDING_COUNT // 2] - s.z
    return height if s.bottom[GROUND_DEPTH, 0] != 0.0 and 0.0 < height <= SOUNDER_RANGE else 0.0


@kernel
def gauge_reading(gauge: int, state: Record) -> float:
    """Return depth [m], heading [rad], speed [m/s] or sounding [m], with the gauge's bias."""
    s = state[0]
    value = s.z
    if gauge == GYRO:
        value = s.psi
    elif gauge == LOG:
        value = s.u  # through the water, as a log measures
    elif gauge == SOUNDER:
        value = sounding(state)
        if value == 0.0:
            return value
    slot = slot_of(GAUGE_CODE[gauge, GAUGE_BIASED], state)
    return value + s.casualty_amount[slot] if slot >= 0 else value


@kernel
def reading(gauge: int, state: Record) -> float:
    """Return what a gauge reads [m, rad or m/s]: stuck, or biased and noisy.

    Gyro, log and sounder stand still without power; the depth gauge needs none. A sounder without
    an echo reads 0, and never less.
    """
    s = state[0]
    slot = slot_of(GAUGE_CODE[gauge, GAUGE_STUCK], state)
    if slot >= 0:
        return s.casualty_amount[slot]
    if gauge != DEPTH_GAUGE and is_dead(FED_GYRO + gauge - GYRO, state):
        return s.gauge_held[gauge - GYRO]
    value = gauge_reading(gauge, state)
    slot = slot_of(GAUGE_CODE[gauge, GAUGE_NOISY], state)
    if slot >= 0:
        if gauge == SOUNDER and value == 0.0:
            return value
        stream = SOUNDER_NOISE if gauge == SOUNDER else GAUGE_NOISE + gauge
        # by seed and tick alone, so that a replay reads the same
        value += s.casualty_amount[slot] * gaussian(int(s.seed), stream, int(s.tick))
    return max(value, 0.0) if gauge == SOUNDER else value


@kernel
def instruments(state: Record, scratch: Record) -> None:
    """Write what depth gauge [m], gyro [rad], log [m/s] and sounder [m] read."""
    for gauge in range(4):
        scratch[0].reading[gauge] = reading(gauge, state)


@kernel
def onset(kind: int, state: Record) -> float:
    """Return the amount [SI] from which a casualty starts.

    What holds or drives something starts from the present value of that, every other kind from 0.
    With a ramp, hard-over then goes from where the surface stands. A stuck gauge keeps its bias.
    """
    s = state[0]
    if KIND_TURNS[kind]:
        return s.surface[KIND_SURFACES[kind]]
    if kind == PROPULSION_STUCK:
        return s.u_c
    if KIND_GAUGES[kind] >= 0 and KIND_HOLDS[kind]:
        return gauge_reading(KIND_GAUGES[kind], state)
    return 0.0


@kernel
def begin(kind: int, amount: float, ticks: float, state: Record) -> int:
    """Begin a casualty that reaches ``amount`` [SI] within ``ticks``.

    Return 1, or 0 if no slot is free. A casualty that is there already goes on from where it is;
    what is stuck stays as it stuck.
    """
    s = state[0]
    slot = slot_of(kind, state)
    if slot < 0:
        slot = slot_of(FREE_SLOT, state)
        if slot < 0:
            return 0
        if KIND_IN_PLANT[kind]:
            s.plant_touched = 1.0
        s.casualty[slot] = kind
        s.casualty_amount[slot] = onset(kind, state)
    s.casualty_ticks[slot] = ticks
    s.casualty_target[slot] = amount
    if KIND_HOLDS[kind]:
        s.casualty_ticks[slot] = 0.0
        s.casualty_target[slot] = s.casualty_amount[slot]
    elif ticks == 0.0:
        s.casualty_amount[slot] = amount
    return 1


@kernel
def end(kind: int, ticks: float, state: Record) -> int:
    """Bring a casualty back to zero within ``ticks``.

    Return 1, or 0 if there is none of this kind.
    """
    s = state[0]
    slot = slot_of(kind, state)
    if slot < 0:
        return 0
    # what holds has no part of an amount to clear, so that it lets go in one tick
    s.casualty_ticks[slot] = -1.0 if KIND_HOLDS[kind] else -max(ticks, 1.0)
    return 1


@inline_kernel
def holds(scheme: Record, trigger: int, state: Record) -> bool:
    """Return whether the state meets the condition of a trigger."""
    m = scheme[0]
    value = state[0].whole[int(m.trigger_place[trigger])]
    excess = m.trigger_sense[trigger] * (value - m.trigger_threshold[trigger])
    return excess > 0.0 or (excess == 0.0 and m.trigger_strict[trigger] == 0.0)


@inline_kernel
def fire_triggers(scheme: Record, state: Record) -> None:
    """Begin the casualties whose conditions the last state meets.

    A trigger that has fired is spent. One that may fire again is renewed when its condition becomes
    false. One that finds no free slot waits for it.
    """
    m = scheme[0]
    s = state[0]
    for i in range(m.trigger_kind.size):
        if m.trigger_kind[i] == 0.0:
            return  # the armed triggers come first
        bit = 1 << i
        spent = int(s.triggers_spent) & bit
        met = holds(scheme, i, state)
        if met and spent == 0:
            kind = int(m.trigger_kind[i])
            s.triggers_spent += bit * begin(kind, m.trigger_amount[i], m.trigger_ticks[i], state)
        elif spent != 0 and not met and m.trigger_again[i] != 0.0:
            s.triggers_spent -= bit
