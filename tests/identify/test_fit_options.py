"""An option of a fit means the same in a study, on the command line and in Python."""

import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner

import trainer
from trainer import identify
from trainer.cli.workshop.identify import identify as command
from trainer.config.ship.fit_options import FIT_KINDS
from trainer.core.kernel import Numbers
from trainer.identify.record.study import load_study

STUDY = """schema = "identify/1"
name = "a"
data = "a.csv"
{heading}
[ship]
{ship}
[model]
kind = "nomoto1"
{model}
"""
# name: a value beyond the limits, the option, the table and key of a study
REFUSED: dict[str, tuple[Any, str, str, str]] = {
    "length": (700, "--length", "ship", "length_m"),
    "speed": (61, "--at", "ship", "speed_kn"),
    "noise": ("white", "--noise", "model", "noise"),
    "method": ("guess", "--method", "model", "method"),
    "between_readings": ("bent", "--between-readings", "heading", "between_readings"),
    "every": (1001, "--every", "heading", "every"),
    "begin": (2e9, "--from", "heading", "from_s"),
    "end": (-2e9, "--to", "heading", "to_s"),
}


def sailed() -> dict[str, Numbers]:
    """Return a ship of K -0.05 /s and T 30 s under a rudder to and fro, read with errors."""
    t = np.arange(0.0, 1200.0, 2.0)
    rudder = math.radians(5.0) * np.where(np.floor(t / 44.0) % 2 == 0.0, 1.0, -1.0)
    rate = np.zeros(len(t))
    for k in range(len(t) - 1):
        rate[k + 1] = rate[k] + 2.0 / 30.0 * (-0.05 * rudder[k] - rate[k])
    return {"t": t, "rudder": rudder, "yaw_rate": rate + 1e-4 * np.sin(7.0 * t)}


@pytest.mark.parametrize("name", REFUSED)
def test_what_a_study_refuses_the_command_and_a_keyword_refuse_with_the_same_limits(
    name: str, tmp_path: Path
) -> None:
    value, option, table, key = REFUSED[name]
    tables = {"heading": "", "ship": "length_m = 100\n", "model": 'outputs = ["yaw_rate"]\n'}
    tables["ship"] = "" if key == "length_m" else tables["ship"]
    tables[table] += f"{key} = " + (f'"{value}"' if isinstance(value, str) else f"{value}")
    study, record = tmp_path / "a.toml", tmp_path / "a.csv"
    study.write_text(STUDY.format(**tables), encoding="utf-8")
    frame = sailed()
    rows = (",".join(map(str, row)) for row in zip(*frame.values(), strict=True))
    record.write_text("\n".join(["t,delta_r,r", *rows]) + "\n", encoding="utf-8")
    limits = FIT_KINDS[name].form.range.split(" or ")[0].split(" to ")[-1]
    limits = re.escape(limits)

    with pytest.raises(trainer.TrainerError, match=f"{key}.*must be.*{limits}"):
        load_study(study)
    answer = CliRunner().invoke(command, [str(record), "--model", "nomoto1", option, str(value)])
    assert answer.exit_code == 2
    assert f"Invalid value for '{option}'" in answer.stderr
    with pytest.raises(trainer.TrainerError, match=f"fit: {name} = .*must be.*{limits}"):
        identify.fit(frame, "nomoto1", **{"length": 100, "speed": 10, name: value})


@pytest.mark.parametrize("way", ["straight", "step"])
def test_a_keyword_says_how_the_rudder_goes_between_readings(way: Any) -> None:
    found = identify.fit(sailed(), "nomoto1", length=100, speed=10, between_readings=way)
    words = {"straight": "straight from reading to reading", "step": "held until the next"}

    assert f"taken as {words[way]}" in found.summary()
