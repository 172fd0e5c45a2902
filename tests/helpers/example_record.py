"""The record of `trainer identify --example`, made by the trainer: configs/records/example.csv.

BB2 at periscope depth in sea state 3, a sequence of 1 degree; read by a log, a rate gyro and a
compass every 5 s, the rudder being its mean until the next reading.

From tests/: python -m helpers.example_record > ../configs/records/example.csv
"""

import math
import tempfile
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

from helpers.typed import type_command
from trainer.cli.main import cli
from trainer.identify.record.study import observe_record, plain_study
from trainer.units import KNOT

COMMANDS = (
    "prbs bb2 --amplitude 1 --interval 5 --depth 17.5 --sea sea-state-3 --write {0}/trial.toml",
    "run {0}/trial.toml --headless --speed max --record {0}/trial.trainer",
)
EVERY = 10


def rows(folder: Path) -> Iterator[str]:
    """Yield the lines of the record, flown in a folder."""
    for command in COMMANDS:
        type_command(cli, *command.format(folder).split())
    study = plain_study(folder / "trial.trainer")
    study = replace(study, heading=replace(study.heading, every=EVERY))
    record = observe_record(study)
    yield "time,helm,gyro,rate,sway,speed"
    yield "s,deg,deg,deg/s,kn,kn"
    degree = math.pi / 180.0
    for i, t in enumerate(record.t):
        heading = record.column("heading")[i] / degree % 360.0
        helm, rate = (record.column(name)[i] / degree for name in ("rudder", "yaw_rate"))
        sway, speed = (record.column(name)[i] / KNOT for name in ("sway", "speed"))
        yield f"{t:.1f},{helm:.2f},{heading:.2f},{rate:.4f},{sway:.3f},{speed:.2f}"


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as made:
        print("\n".join(rows(Path(made))))
