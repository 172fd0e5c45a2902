"""One hour is the same everywhere, in every way of this machine.

However the tick is computed, compiled or interpreted, for whatever processor, alone or in a fleet,
the hour ends in the same bits; ``digest`` is their name. Orders are carried out by the
helm, between ticks, on the records themselves.
"""

import hashlib
from collections.abc import Callable
from pathlib import Path
from typing import Final

from trainer.boat.assemble import Method, Records
from trainer.boat.boat import Boat
from trainer.boat.helm import obey_order
from trainer.config.sea import load_sea
from trainer.config.vessel import load_vessel
from trainer.io.orders.grammar import Refused
from trainer.io.orders.schedule import BadSchedule, ScheduledOrder, parse_schedule
from trainer.units import KNOT

VESSEL_PATH: Final = Path(__file__).with_name("standard_boat.toml")
HOUR_METHOD: Final = Method("modified", "lagged", "exact", "adams2", 0.5)
START_SPEED_KN: Final = 10.0  # [kn]
START_DEPTH_M: Final = 60.0  # [m]
SEA_NAME: Final = "sea-state-5"
HOUR_SEED: Final = 1969  # of the sea; it stays, so that digests of old and new cores compare
HOUR_TICKS: Final = 7200  # [ticks] of half a second
HOUR_ORDERS: Final = """
60 depth 90
120 course 075
300 pump trim forward 4
400 speed 14
500 casualty rudder-slow 0.7 ramp 30
600 course left 120
800 clear rudder-slow
900 casualty stern-stuck
1000 clear stern-stuck
1100 sea state 3
1200 casualty leak-auxiliary ramp 20
1300 pump auxiliary 3
1400 clear leak-auxiliary
1500 rudder right 5
1530 course 030
1600 speed 2
1700 depth 40
1800 hover on
2000 flood depth-control 2
2100 hover off
2200 speed 8
2300 casualty gyro-biased
2400 periscope depth
2700 emergency blow
2800 blow stop
3000 compressor on
3100 dive
3200 depth 50
3400 planes manual
3450 planes auto
"""

TickRunner = Callable[[Records, int], int]  # so many ticks of a boat; the status of the last


def orders() -> list[ScheduledOrder]:
    """Return what is ordered in the hour, by time."""
    schedule = parse_schedule(HOUR_ORDERS, "the standard hour")
    if isinstance(schedule, BadSchedule):
        raise TypeError(str(schedule))
    return schedule


def standard_boat() -> Boat:
    """Return the boat at the start of the hour."""
    boat = Boat(load_vessel(str(VESSEL_PATH)), HOUR_METHOD)
    boat.start(START_SPEED_KN * KNOT, START_DEPTH_M, 0.0, HOUR_SEED)
    boat.put_to_sea(load_sea(SEA_NAME))
    return boat


def fly_standard_hour(take: TickRunner, last: int = HOUR_TICKS) -> Boat:
    """Return the boat after the hour, its ticks taken by ``take``. Up to tick ``last`` if sooner.

    RuntimeError if an order is refused or the boat loses its numbers.
    """
    boat = standard_boat()
    for entry in (*orders(), None):
        until = last if entry is None else min(round(entry.seconds / HOUR_METHOD.step), last)
        status = take(boat.records, until - int(boat.state.tick))
        if status:
            raise RuntimeError(boat.failure(status))
        if entry is not None and until < last:
            answer = obey_order(boat, entry.order)
            if isinstance(answer, Refused):
                raise RuntimeError(f"{entry.order.text}: {answer.reason}")
    return boat


def digest(boat: Boat) -> str:
    """Return the SHA-256 of the whole state."""
    return hashlib.sha256(boat.records.state.tobytes()).hexdigest()
