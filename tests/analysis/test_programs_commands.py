"""The engineer's programs as commands: pages, JSON, plots and exit codes."""

import json
import math
from collections.abc import Mapping
from pathlib import Path

import click
import numpy as np
import pytest
from click.testing import CliRunner, Result
from helpers.lanes import sample_cases

from trainer.analysis.programs.neutral import panels, report_neutral
from trainer.cli.main import cli
from trainer.config.boat.vessel import load_vessel
from trainer.config.files import ConfigError
from trainer.report import plots

COMMANDS: Mapping[str, click.Command] = cli.commands["report-1969"].commands  # type: ignore[attr-defined]
ON_VESSELS = ["neutral", "thrust", "tanks", "modes"]
FORMS = {".png": b"\x89PNG", ".svg": b"<?xml", ".pdf": b"%PDF"}


def ask(*words: str) -> Result:
    return CliRunner().invoke(COMMANDS[words[0]], words[1:], catch_exceptions=True)


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """Return the paths of a run, of one within 5 % of it, and of one beyond."""
    folder = tmp_path_factory.mktemp("runs")
    t = np.arange(0.0, 150.5, 0.5)
    paths = {}
    for name, factor in {"full": 1.0, "near": 1.03, "far": 1.2}.items():
        theta = factor * 0.1 * np.exp(-0.03 * t) * np.sin(0.1 * t)
        rows = [
            f"{a!r},{b!r},{60.0 + factor * a!r}"
            for a, b in zip(t.tolist(), theta.tolist(), strict=True)
        ]
        path = folder / f"{name}.csv"
        path.write_text("\n".join(["t,theta,z", *rows]) + "\n")
        paths[name] = str(path)
    return paths


def words_of(name: str, runs: dict[str, str]) -> list[str]:
    """Return a command line of each program."""
    if name in ON_VESSELS:
        return [name, "bb2"]
    return [name, runs["full"], *([runs["near"]] if name == "compare" else ["--order", "2"])]


@pytest.mark.parametrize("name", COMMANDS)
def test_a_page_fits_a_terminal_beside_its_plot_and_its_help_has_an_example(
    name: str, runs: dict[str, str], tmp_path: Path
) -> None:
    path = tmp_path / "plot.svg"
    done = ask(*words_of(name, runs), "--plot", str(path))

    assert done.exit_code == 0, done.output
    lines = done.stdout.splitlines()
    assert len(lines) > 5
    assert max(map(len, lines)) <= 79
    assert done.stdout.isascii()
    assert path.read_bytes().startswith(FORMS[".svg"])
    assert f"Example:  trainer report-1969 {name} " in ask(name, "--help").stdout


@pytest.mark.parametrize("name", COMMANDS)
def test_json_is_json_with_numbers_only(name: str, runs: dict[str, str]) -> None:
    def refuse(text: str) -> None:
        raise AssertionError(text)

    done = ask(*words_of(name, runs), "--json")

    assert isinstance(json.loads(done.stdout, parse_constant=refuse), dict)


@pytest.mark.slow
@pytest.mark.parametrize("form", FORMS)
def test_a_plot_has_the_form_of_its_name_and_the_same_bytes_each_time(
    form: str, tmp_path: Path
) -> None:
    x = np.array([0.0, 1.0, math.nan, 3.0])
    curves = tuple(plots.Curve(f"curve {i}", x, i * x, points=i == 1) for i in range(3))
    panel = plots.Panel("title", "x [m]", "y [m]", curves, (("here", 1.0),), (2.0,))
    drawn = []
    for i in range(2):
        path = tmp_path / f"{i}{form}"
        plots.draw_plot((panel, panel), path)
        drawn.append(path.read_bytes())

    assert drawn[0].startswith(FORMS[form])
    assert drawn[0] == drawn[1]


def test_curves_differ_by_line_as_well_as_by_colour() -> None:
    pairs = list(zip(plots.CURVE_COLOURS * 5, plots.LINE_STYLES * 7, strict=True))

    assert len({str(pair) for pair in pairs}) == 35
    assert len({str(line) for _, line in pairs[:5]}) == 5


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["neutral", "bb3"], 'no vessel "bb3"; nearest is bb2'),
        (["neutral", "bb2", "--plot", "plot.gif"], r"plot.gif: must end in .png, .svg or .pdf"),
        (["compare", "full.csv", "near.csv"], "full.csv: cannot be read: No such file"),
    ],
)
def test_wrong_input_is_told_in_words(words: list[str], said: str) -> None:
    done = ask(*words)

    assert isinstance(done.exception, ConfigError)
    assert said in str(done.exception)
    assert not done.stdout


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["neutral", "bb2", "--speed", "0"], "not in the range 0.0<x"),
        (["neutral", "bb2", "--plot", "none/plot.png"], "there is no folder none"),
        (["modes", "bb2", "--speed", "nan"], "'nan' is not a number"),
        (["tanks", "bb2", "--fill", "auxiliary"], "such as auxiliary=0.5"),
        (["tanks", "bb2", *["--fill", "mid=1"] * 2], "--fill mid is given twice"),
        (["fit", "run.csv", "--vessel", "bb2"], "--vessel and --speed go together"),
    ],
)
def test_a_wrong_option_ends_with_code_2(words: list[str], said: str, runs: dict[str, str]) -> None:
    done = ask(*(runs["full"] if word == "run.csv" else word for word in words))

    assert done.exit_code == 2
    assert said in done.output


def test_compare_answers_with_its_exit_code(runs: dict[str, str]) -> None:
    near, far = (ask("compare", runs["full"], runs[name]) for name in ("near", "far"))

    assert (near.exit_code, far.exit_code) == (0, 1)
    assert "All of 2 within 5 %." in near.stdout
    assert "2 of 2 beyond 5 %." in far.stdout
    assert ask("compare", runs["full"], runs["far"], "--allow", "25").exit_code == 0


def test_fit_gives_the_roots_of_the_response_from_either_start(runs: dict[str, str]) -> None:
    by_itself = ask("fit", runs["full"], "--order", "2", "--json")
    by_boat = ask("fit", runs["full"], "--vessel", "bb2", "--speed", "10", "--json")

    (pair,) = json.loads(by_itself.stdout)["fit"]["terms"]
    assert (pair["real"], pair["imaginary"]) == pytest.approx((-0.03, 0.1), rel=1e-8)
    report = json.loads(by_boat.stdout)
    assert report["roots_from"] == "EC140, bb2 at 10 kn"
    found = [term for term in report["fit"]["terms"] if term["imaginary"] > 0.0]
    assert (found[0]["real"], found[0]["imaginary"]) == pytest.approx((-0.03, 0.1), rel=1e-5)


def test_speeds_asked_for_are_those_answered_for() -> None:
    report = json.loads(ask("neutral", "bb2", "--speed", "7", "--speed", "7", "--json").stdout)

    assert [flight["speed_kn"] for flight in report["flights"]] == pytest.approx([7.0, 7.0])
    assert [flight["plane"] for flight in report["flights"]] == ["stern", "bow"]


@pytest.mark.long
@pytest.mark.parametrize("name", sample_cases(["neutral", "modes"], "modes"))
def test_a_page_of_a_boat_near_the_surface_tells_its_force_and_fits_a_terminal(
    name: str, tmp_path: Path
) -> None:
    path = tmp_path / "plot.svg"

    done = ask(name, "bb2", "--depth", "12", "--plot", str(path))

    assert done.exit_code == 0, done.output
    assert "THE SURFACE AT 12 m (added to deep water)" in done.stdout
    assert "remark: the tables of the surface begin at 13.8724 m" in done.stdout
    assert max(map(len, done.stdout.splitlines())) <= 79
    assert path.read_bytes().startswith(FORMS[".svg"])


def test_means_of_all_motions_fit_a_terminal() -> None:
    means = [word for name in "vwpqr" for word in (f"--mean-{name}", "0.1234")]

    done = ask("modes", "bb2", *means)

    said = "mean |v| 0.1234 m/s, |w| 0.1234 m/s, |p| 0.1234 rad/s"
    assert said in " ".join(done.stdout.split())
    assert max(map(len, done.stdout.splitlines())) <= 79


def test_thrust_at_rest_is_that_of_the_command_speed_alone(tmp_path: Path) -> None:
    path = tmp_path / "plot.svg"

    done = ask("thrust", "bb2", "--speed", "0", "--command", "10", "--json", "--plot", str(path))

    (point,) = json.loads(done.stdout)["points"]
    assert point["u_kn"] == 0.0
    assert point["thrust_N"] == json.loads(done.stdout)["bollard_N"]["ahead"] > 0.0
    assert path.read_bytes().startswith(FORMS[".svg"])


def test_the_curve_of_neutral_flights_goes_through_the_table() -> None:
    file = load_vessel("bb2")
    report = report_neutral(file, [3.0, 5.0, 10.0])
    pitch = next(curve for curve in panels(file, report)[0].curves if "stern" in curve.label)

    for flight in (flight for flight in report.flights if flight.plane == "stern"):
        one = flight.solutions[0]
        gap = np.hypot(pitch.x - flight.speed_kn, pitch.y - one.pitch_deg)
        assert np.nanmin(gap) < 0.1
    assert math.isnan(pitch.y[-1])  # the branches are not joined
