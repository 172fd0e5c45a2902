"""A study file is checked before anything is flown, and its result is told in plain tables."""

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner, Result
from helpers.places import ROOT

from trainer.analysis.sweep.job import job_of, open_job
from trainer.analysis.sweep.report import (
    SweepReport,
    effects_of,
    panels,
    render,
    report_of,
    spread_of,
)
from trainer.analysis.sweep.study import load_study, parse_study
from trainer.api.subjects import subject_of
from trainer.cli.main import cli
from trainer.config.files import ConfigError, shipped_names
from trainer.report.plots import Panel

pytestmark = pytest.mark.process  # fits are compiled, and studies flown in processes

HEAD = """schema = "sweep/1"
name = "test"
[manoeuvre]
name = "turn"
duration_s = 60.0
"""
SAMPLE = """[sample]
plan = "monte-carlo"
members = 10
seed = 1
"""
GRID = '[sample]\nplan = "grid"\nseed = 1\n'
VARY = """[[vary]]
name = "N_v"
key = "vessel.coefficients.N_v"
distribution = "normal"
mean = 1.0
std = 0.1
relative = true
"""


def opened(text: str) -> Any:
    """Return the members of a study."""
    return subject_of(parse_study(text, Path("test.toml"))).outputs


WHOLE = HEAD + SAMPLE + VARY
KEY = "vessel.coefficients.N_v"


@pytest.mark.parametrize(
    ("there", "instead", "said"),
    [
        (KEY, "vessel.coefficients.N_vv", "relative: vessel.coefficients.N_vv is null"),
        (KEY, "vessle.coefficients.N_v", "there is no table 'vessle'; nearest is vessel"),
        (KEY, "vessel.coeffcients.N_v", "nearest is coefficients"),
        (KEY, "vessel.vessel.cg[3]", "of 3, counted from 0"),
        (KEY, "vessel..N_v", "'' is no word of a key"),
        (KEY, "vessel.coefficients.Y_pap", "is 0.0: no factor"),
        ("std =", "high =", "normal lacks std and has high besides"),
        ("relative = true", "values = [1.0]", "give one of values, distribution"),
        ("relative = true\n", "relative = true\n" + VARY, 'vary[1]] name = "N_v": is given twice'),
        (VARY, VARY.replace("normal", "uniform"), "uniform lacks low, high and has mean, std"),
        ('"normal"\nmean = 1.0\nstd', '"uniform"\nhigh = 0.1\nlow', "low, high must rise"),
        (SAMPLE, GRID, "a grid wants values"),
        (SAMPLE + VARY, GRID, "lacks [[vary]]"),
        (SAMPLE + VARY, GRID + "members = 3\n", "members = 3: a grid has all its points"),
        ("members = 10\n", "", "[sample] lacks members"),
        ("= 10", "= 10.5", "must be a whole number"),
        ("monte-carlo", "sobool", "must be grid or latin-hypercube or monte-carlo or sobol"),
        ("monte-carlo", "sobol", "of 1 variables has 3 times a power of two: 24 or 48"),
        ('"turn"', '"trun"', "no manoeuvre 'trun'; nearest is turn"),
        ("duration_s", "angle_deg = 40\nduration_s", "[manoeuvre] angle 40: the rudder"),
        ("duration_s", "angel_deg = 40\nduration_s", "no such key; nearest is angle_deg"),
        ('"turn"', '"zigzag-20"\ndepth_kept = false', "has no such choice"),
        ("[man", 'vessel = "bb3"\n[man', 'no vessel "bb3"; nearest is bb2'),
        ("[man", 'measures = ["advanse"]\n[man', "nearest is advance"),
        ("[man", 'measures = ["largest phy"]\n[man', "lowest, highest, largest of t, u, v"),
        ("[man", '[identification]\nmodel = "1"\n[man', "manoeuvre and identification: give one"),
        ("[man", "[[parameters]]\n[man", "goes with [identification]"),
        ("[man", "membres = 3\n[man", "membres = 3: no such key"),
    ],
)
def test_what_is_wrong_with_a_study_is_told_with_the_next_step(
    there: str, instead: str, said: str
) -> None:
    text = WHOLE.replace(there, instead, 1)
    assert text != WHOLE
    with pytest.raises(ConfigError) as wrong:
        opened(text)
    assert said in str(wrong.value)


OUT = """schema = "sweep/1"
name = "test"
measures = ["last z"]
[exercise]
duration_s = 5
[[exercise.orders]]
at_s = 1
order = "depth 70"
"""


@pytest.mark.parametrize(
    ("there", "instead", "said"),
    [
        ("duration_s = 5\n", "", "[exercise] lacks duration_s"),
        ('measures = ["last z"]\n', "", "lacks measures: such as 'last z'"),
        ("duration_s", 'file = "steering-jm"\nduration_s', "nearest is steering-jam"),
        ("depth 70", "snapshot a", "it is about time"),
        ("depth 70", "speed 30", "refused: this boat's greatest speed is 20 kn"),
        ("depth 70", "dpeth 70", "orders[0]] order"),
    ],
)
def test_what_is_wrong_with_its_exercise_is_told_too(there: str, instead: str, said: str) -> None:
    text = (OUT + SAMPLE).replace(there, instead, 1)
    with pytest.raises(ConfigError) as wrong:
        opened(text)
    assert said in str(wrong.value)


def test_a_parameter_that_the_model_has_not_is_told() -> None:
    text = load_study("coverage").path.read_text()

    with pytest.raises(ConfigError, match="model 1 has no such parameter; nearest is Y_delta"):
        opened(text.replace('"Y_delta"', '"Y_delat"'))
    with pytest.raises(ConfigError, match="has none that is free"):
        opened(text.replace("truth =", "free = false\ntruth =").replace("free = false\n\n", "\n"))


@pytest.mark.parametrize("name", shipped_names("studies"))
def test_a_shipped_study_can_be_opened_and_has_a_member(name: str) -> None:
    subject = subject_of(load_study(name))

    batch = subject.batch(0, 1)
    assert batch.troubles == (None,)
    assert np.isfinite(batch.outputs).all()


def ask(folder: Path, *words: str) -> Result:
    """Run the program on a small grid of turns, in a folder of its own."""
    (folder / "grid.toml").write_text(
        HEAD + GRID + '[[vary]]\nname = "rudder"\nkey = "manoeuvre.angle_deg"\n'
        "values = [5.0, 10.0, 15.0, 20.0]\n"
        '[[vary]]\nname = "speed"\nkey = "manoeuvre.speed_kn"\nvalues = [8.0, 12.0]\n'
    )
    out = str(folder / "grid.parquet")
    return CliRunner().invoke(cli, ["sweep", str(folder / "grid.toml"), "--out", out, *words])


def test_the_page_tells_spread_and_what_moves_a_measure_most(tmp_path: Path) -> None:
    page = ask(tmp_path, "--jobs", "1")

    assert page.exit_code == 0, page.output
    assert "grid, 8 members, seed 1" in page.stdout
    lines = page.stdout.splitlines()
    advance = next(line for line in lines if line.startswith("  advance")).split()
    assert advance[-1] in "012345678"
    assert [line.split()[0] for line in lines if line.startswith(("  rudder", "  speed"))]


def test_the_page_as_json_has_every_measure_and_a_member_its_row(tmp_path: Path) -> None:
    report = json.loads(ask(tmp_path, "--json").stdout)
    member = json.loads(ask(tmp_path, "--member", "5", "--json").stdout)

    import pyarrow.parquet as pq  # noqa: PLC0415

    assert pq.read_table(tmp_path / "grid.parquet").to_pylist()[5] == member
    assert (member["rudder"], member["speed"]) == (15.0, 12.0)
    names = [spread["name"] for spread in report["spreads"]]
    assert {"advance", "tactical diameter", "steady speed"} <= set(names)
    assert set(report["effects"]) == set(names)


def test_a_member_beyond_the_last_is_told(tmp_path: Path) -> None:
    done = ask(tmp_path, "--member", "8")

    assert isinstance(done.exception, ConfigError)
    assert str(done.exception) == "--member 8: members are 0 to 7"


def test_what_came_to_nothing_is_counted_as_people_count() -> None:
    troubles = {"it broke": 1, "it sank": 3}
    page = render(SweepReport("a study", "a.parquet", "grid", 1, 9, 4, troubles, (), {}, {}))

    assert "4 of 9 came to nothing:\n    once: it broke\n    3 times: it sank" in page


def test_a_spread_is_of_the_members_that_came_to_it() -> None:
    spread = spread_of("x", "m", np.array([1.0, np.nan, 2.0, 3.0]))

    assert (spread.count, spread.mean, spread.deviation) == (3, 2.0, 1.0)
    assert spread.percentiles["50"] == 2.0


def test_effects_are_means_at_either_end_the_widest_first() -> None:
    a, b = np.arange(100.0), np.tile(np.arange(10.0), 10)
    words = np.array(["calm", "rough"])[np.arange(100) % 2]
    found = effects_of({"a": a, "b": b, "sea": words}, 2.0 * b + 100.0 * (words == "rough"))

    assert [effect.variable for effect in found] == ["b", "sea", "a"]
    assert (found[0].at_low, found[0].at_high) == (0.0, 118.0)
    assert (found[1].low, found[1].high) == ("calm", "rough")
    assert (found[2].low, found[2].high) == (4.5, 94.5)


def test_the_example_of_the_documents_is_a_study_that_flies(tmp_path: Path) -> None:
    page = (ROOT / "docs" / "sweeps.md").read_text(encoding="utf-8")
    (text,) = re.findall(r"```toml\n(.*?)```", page, re.DOTALL)
    path, out = tmp_path / "example.toml", tmp_path / "out.parquet"
    path.write_text(text, encoding="utf-8")

    words = ["sweep", str(path), "--members", "3", "--jobs", "1", "--out", str(out)]
    done = CliRunner().invoke(cli, words)
    assert done.exit_code == 0, done.output
    assert "monte-carlo, 3 members, seed 7" in done.stdout
    assert "came to nothing" not in done.stdout


def test_a_grid_is_drawn_over_each_variable(tmp_path: Path) -> None:
    plot = ("--plot", str(tmp_path / "grid.svg"))
    done = ask(tmp_path, "--jobs", "1", *plot, "--measure", "steady speed")
    assert done.exit_code == 0, done.output
    assert (tmp_path / "grid.svg").read_bytes().startswith(b"<?xml")
    wrong = ask(tmp_path, *plot, "--measure", "stedy speed")
    assert "nearest is steady speed" in str(wrong.exception)
    import pyarrow.parquet as pq  # noqa: PLC0415

    result = pq.read_table(tmp_path / "grid.parquet")
    job = job_of(str(tmp_path / "grid.toml"), None, subject_of)
    report = report_of(open_job(job), result, "grid.parquet")

    over = {panel.x: panel for panel in panels(report, result, "largest roll")[2:]}

    assert list(over) == ["rudder", "speed"]
    rudder = over["rudder"]
    assert isinstance(rudder, Panel)
    assert [curve.label for curve in rudder.curves] == ["speed 8", "speed 12"]
    told = {(row["rudder"], row["speed"]): row["largest roll"] for row in result.to_pylist()}
    for curve, speed in zip(rudder.curves, (8.0, 12.0), strict=True):
        assert curve.x.tolist() == [5.0, 10.0, 15.0, 20.0]
        expected = [np.degrees(told[angle, speed]) for angle in curve.x.tolist()]
        assert curve.y.tolist() == pytest.approx(expected, rel=1e-12)


def change_of_peak(speed: float, name: str, low: float, high: float) -> tuple[float, float]:
    """Return the change [%] of a meander's first peak by ``name`` at either of two numbers."""
    study = load_study("centre-of-gravity")
    batch = subject_of(study).batch(0, study.draws.members)
    names = ("speed [kn]", "x_G [m]", "z_G [m]")
    settings = list(zip(*(batch.drawn[one].tolist() for one in names), strict=True))
    peaks = dict(zip(settings, batch.outputs[:, 0].tolist(), strict=True))
    found = []
    for value in (low, high):
        moved = {"x_G [m]": 0.0, "z_G [m]": 0.0} | {name: value}
        peak = peaks[speed, moved["x_G [m]"], moved["z_G [m]"]]
        found.append(100.0 * (peak / peaks[speed, 0.0, 0.0] - 1.0))
    return found[0], found[1]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "size", "slow", "fast"),
    [
        ("x_G [m]", 0.0066, (6.7, -8.7), (0.2, -0.2)),
        ("z_G [m]", 0.022, (1.1, -1.1), (1.4, -1.3)),
        ("z_G [m]", 0.066, (3.2, -2.5), (4.5, -3.8)),
    ],
)
def test_the_centre_of_gravity_is_known_well_enough_by_the_rules_of_1969(
    name: str, size: float, slow: tuple[float, float], fast: tuple[float, float]
) -> None:
    assert change_of_peak(6.0, name, -size, size) == pytest.approx(slow, abs=0.06)
    assert change_of_peak(20.0, name, -size, size) == pytest.approx(fast, abs=0.06)
