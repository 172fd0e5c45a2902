"""Made trials of boats: what a fit is given, of a truth that is known."""

from pathlib import Path

import numpy as np

from trainer.analysis.estimate.boat_file import open_hull, write_boat
from trainer.analysis.estimate.uncertainty import deviates
from trainer.core.kernel import Numbers
from trainer.identify.boat.filter import CHANNEL_NAMES, RecordNumbers, sail_controls
from trainer.identify.boat.motion import CONTROL_PLACES, STATE, STATE_COUNT
from trainer.identify.boat.noise import usual_noise
from trainer.identify.boat.trial import Trial
from trainer.identify.boat.vessel import FittedVessel
from trainer.units import DEGREE

STEPS = 2  # of Runge and Kutta between readings
READ_STATES = {  # by channel, with the error of a reading
    "speed": (STATE.U, 0.05),
    "heading": (STATE.PSI, 0.2 * DEGREE),
    "pitch": (STATE.THETA, 0.1 * DEGREE),
    "roll": (STATE.PHI, 0.2 * DEGREE),
    "depth": (STATE.Z, 0.1),
}


def estimated_boat(folder: Path, hull: str = "small-boat") -> Path:
    """Return the file of a boat that was estimated from a shipped hull."""
    path = folder / "own.toml"
    path.write_text(write_boat(open_hull(hull), path).text, encoding="utf-8")
    return path


def swing_controls(count: int, speed: float, pace: float) -> Numbers:
    """Return inputs (n, 4) that swing rudder, planes and revolutions, each at its own pace."""
    k, inputs = pace * np.arange(count), np.zeros((count, 4))
    inputs[:, CONTROL_PLACES.RUDDER] = 0.25 * np.sin(0.11 * k) + 0.1 * np.sin(0.031 * k)
    inputs[:, CONTROL_PLACES.STERN] = 0.06 * np.sin(0.17 * k) + 0.05 * np.sin(0.07 * k)
    inputs[:, CONTROL_PLACES.BOW] = 0.06 * np.cos(0.13 * k)
    inputs[:, CONTROL_PLACES.UC] = speed * (1.0 + 0.15 * np.sin(0.023 * k))
    return inputs


def made_trial(
    vessel: FittedVessel, values: Numbers, count: int = 300, interval: float = 0.5, seed: int = 1
) -> Trial:
    """Return readings of a boat of those parameters, with errors of its instruments."""
    inputs = swing_controls(count, vessel.speed, interval * vessel.pace)
    state = np.zeros(STATE_COUNT)
    state[STATE.U], state[STATE.Z] = vessel.speed, 120.0
    states = _sail_disturbed(vessel, values, inputs, interval, state, seed)
    readings = np.full((count, len(CHANNEL_NAMES)), np.nan)
    errors = deviates(seed, count * len(READ_STATES)).reshape(count, -1)
    for i, (channel, (at, error)) in enumerate(READ_STATES.items()):
        readings[:, CHANNEL_NAMES.index(channel)] = states[:, at] + error * errors[:, i]
    return Trial(f"made-{seed}.csv", "", interval, STEPS, readings, inputs, (), ())


def _sail_disturbed(
    vessel: FittedVessel,
    values: Numbers,
    inputs: Numbers,
    interval: float,
    state: Numbers,
    seed: int,
) -> Numbers:
    """Return the states of a boat whose velocities are pushed at each reading."""
    boat, count, states = vessel.numbers(values), len(inputs), [state]
    push = 0.5 * np.sqrt(interval) * usual_noise(vessel).disturbance
    pushes = push * deviates(1000 + seed, count * len(push)).reshape(count, -1)
    for k in range(count - 1):
        record = RecordNumbers(
            np.zeros((0, len(CHANNEL_NAMES))), inputs[k : k + 2], interval, STEPS
        )
        state = sail_controls(boat, record, state)[1]
        state[: len(push)] += pushes[k]
        states.append(state)
    return np.array(states)


def write_csv(path: Path, trial: Trial, turns: float) -> Path:
    """Write a trial as a stranger's file: degrees, knots and rpm; ``turns`` a second per m/s."""
    heads = (
        "time [s],rudder [deg],stern planes [deg],bow planes [deg],rpm,log [kn],heading [deg],"
        "pitch [deg],roll [deg],depth [m]"
    )
    rows = [heads]
    for k, (reading, given) in enumerate(zip(trial.readings, trial.inputs, strict=True)):
        angles = [
            given[i] / DEGREE
            for i in (CONTROL_PLACES.RUDDER, CONTROL_PLACES.STERN, CONTROL_PLACES.BOW)
        ]
        log, heading, pitch, roll, depth = reading[:5]
        cells = [
            k * trial.interval,
            *angles,
            60.0 * turns * given[CONTROL_PLACES.UC],
            log * 3600 / 1852,
        ]
        cells += [(heading / DEGREE) % 360.0, pitch / DEGREE, roll / DEGREE, depth]
        rows.append(",".join(f"{cell:.5f}" for cell in cells))
    path.write_text("\n".join(rows) + "\n", encoding="utf-8")
    return path
