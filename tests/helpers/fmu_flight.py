"""The flight of ten minutes by orders that units and the trainer make."""

from dataclasses import replace
from typing import Final

from helpers.orders import obey_all
from trainer.cli.export import boat_at_start
from trainer.session.past.options import RunOptions

OPTIONS: Final = RunOptions(vessel="bb2")
# a run of ten minutes: after which tick, as the trainer's crew says it, as a simulator sets it
ORDERS: Final[list[tuple[int, str, dict[str, float]]]] = [
    (0, "course 100", {"ordered_psi": 100.0}),
    (30, "casualty rudder-slow 0.5", {"casualty_rudder_slow": 0.5}),
    (60, "depth 90", {"ordered_depth": 90.0}),
    (80, "clear rudder-slow", {"casualty_rudder_slow": 0.0}),
    (85, "casualty rudder-slow 0.5", {"casualty_rudder_slow": 0.5}),  # not clear yet
    (130, "clear rudder-slow", {"casualty_rudder_slow": 0.0}),
    (200, "rudder left 22.5", {"rudder_by_hand": 1, "ordered_r": -22.5}),
    (440, "rudder auto", {"rudder_by_hand": 0}),
    (470, "course 350", {"ordered_psi": 350.0}),
    (500, "casualty stern-hard-over -0.4", {"casualty_stern_hard_over": -0.4}),
    (560, "casualty rudder-stuck", {"casualty_rudder_stuck": 1}),
    (600, "clear stern-hard-over", {"casualty_stern_hard_over": 0.0}),
    (640, "clear rudder-stuck", {"casualty_rudder_stuck": 0}),
    (650, "flood auxiliary 3", {"move_auxiliary": 3.0}),
    (660, "pump trim aft 2", {"move_trim": -2.0}),
    (700, "turns -4", {"speed_by_hand": 1, "ordered_u_c": -4.0}),
    (740, "speed 8", {"speed_by_hand": 0, "ordered_speed": 8.0}),
    (800, "emergency blow", {"blow_forward": 2, "blow_mid": 2, "blow_aft": 2}),
    (1000, "casualty gyro-biased", {"casualty_gyro_biased": 1.0}),
    (1050, "depth 4", {"ordered_depth": 4.0}),
    (1060, "rudder right 5", {"rudder_by_hand": 1, "ordered_r": 5.0}),
    (1150, "rudder auto", {"rudder_by_hand": 0}),
]
TICKS: Final = 1200


def state_of_trainer() -> bytes:
    """Return the boat's record after the run by orders, as the trainer flies it."""
    boat = boat_at_start(replace(OPTIONS, sea="sea-state-4", seed=7))
    for tick in range(TICKS):
        for at, text, _ in ORDERS:
            if at == tick:
                obey_all(boat, text)
        boat.tick()
    return bytes(boat.records.state.tobytes())
