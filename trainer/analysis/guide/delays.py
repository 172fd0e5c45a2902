"""The sheet of transport delays: from order to control, to motion, to a screen.

Orders are given anywhere within a tick and act on the next one, so ticks are counted, and no clock
is needed: delays in seconds follow from the step. A screen adds its time from picture to picture;
``trainer dev bench --latency`` and ``--web`` measure on a machine.
"""

from dataclasses import dataclass
from typing import Final

from trainer.analysis.guide.programme import own_method
from trainer.analysis.manoeuvres.submarine import BOAT_COLUMNS, Submarine
from trainer.analysis.manoeuvres.vehicle import LostError
from trainer.boat.assemble import Method
from trainer.config.files import ConfigError
from trainer.config.vessel import VesselFile
from trainer.units import KNOT

SHEET_STEPS_S: Final = (0.5, 1.0)
SCREEN_PERIODS_S: Final = {"terminal": 0.1, "browser": 0.05}  # from picture to picture, at most
WATCHED_CONTROLS: Final = {  # the control's own column, and that of the motion
    "rudder": ("delta_r", "r"),
    "planes": ("delta_s", "q"),
    "engine": ("u_c", "u"),
}
MAX_TICKS: Final = 60
MOVED: Final = 1e-9  # [SI] a number that was still has moved


@dataclass(frozen=True)
class DelaySheet:
    """The ticks from one order until something moves; None: not in MAX_TICKS."""

    control: str
    step_s: float
    control_ticks: int | None
    motion_ticks: int | None
    problem: str  # why it could not be flown

    def mean_s(self, ticks: int | None, screen: str = "") -> float | None:
        """Return the mean delay [s] until it moves, or is seen to on a screen.

        An order waits half a tick in the mean, a screen half its time from picture to picture.
        """
        if ticks is None:
            return None
        return (ticks - 0.5) * self.step_s + 0.5 * SCREEN_PERIODS_S.get(screen, 0.0)

    def most_s(self, ticks: int | None, screen: str) -> float | None:
        """Return the longest delay [s] until it is seen on a screen."""
        return None if ticks is None else ticks * self.step_s + SCREEN_PERIODS_S[screen]


def measure_delays(file: VesselFile) -> tuple[DelaySheet, ...]:
    """Return the delays of a boat's controls by its own set, at each step."""
    return tuple(
        _measure(file, name, step)
        for step in dict.fromkeys((*SHEET_STEPS_S, file.run.step_s))
        for name in WATCHED_CONTROLS
    )


def _measure(file: VesselFile, control: str, step: float) -> DelaySheet:
    """Return the ticks from one order to its effects, beside a boat without the order."""
    own = own_method(file, file.own_equations)
    method = Method(own.equations, own.rates, own.trig, own.integrator, step)
    boats = [Submarine(file, method) for _ in range(2)]
    indices = [BOAT_COLUMNS.index(name) for name in WATCHED_CONTROLS[control]]
    ticks, problem = dict[int, int](), ""
    try:
        for boat in boats:
            boat.start(file.run.start_speed_kn * KNOT)
        boats[1].order(control, boats[1].controls[control].low)
        for tick in range(1, MAX_TICKS + 1):
            for boat in boats:
                boat.advance()
            still, moved = (boat.observe() for boat in boats)
            for index in indices:
                if abs(moved[index] - still[index]) > MOVED:
                    ticks.setdefault(index, tick)
            if len(ticks) == len(indices):
                break
    except (ConfigError, LostError) as error:
        problem = str(error)
    return DelaySheet(control, step, ticks.get(indices[0]), ticks.get(indices[1]), problem)
