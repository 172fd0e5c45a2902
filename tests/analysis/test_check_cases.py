"""Check cases: NASA's brick, twelve manoeuvres, and what a stranger's file may be."""

import json
import re
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from helpers.check_cases import outputs_text
from helpers.places import ROOT

from trainer.analysis.check_cases import CaseFlight, Comparison, cases_page, fly_cases
from trainer.cli.main import cli, run_command
from trainer.config.boat.vessel import load_vessel
from trainer.config.exercise.check_case import CASE_CHANNELS, case_paths, load_case
from trainer.config.files import ConfigError

CASES = ROOT / "configs" / "check-cases"
NASA = "nesc-02"
MECHANISMS = {
    *("deceleration", "plane-step", "turn", "dive", "roll-decay", "ballast-step"),
    *("blow", "sternway", "heave-decay", "current", "filter-sea", "casualty"),
}
RENEW = "if the core has changed: python -m helpers.check_cases, in tests/"


@pytest.fixture(scope="module")
def flights() -> dict[str, CaseFlight]:
    return {flight.case.name: flight for flight in fly_cases(case_paths(None))}


def worst(comparison: Comparison) -> float:
    return max(each.largest for each in comparison.differences)


@pytest.mark.core
def test_a_body_without_forces_tumbles_as_in_nasas_simulations(
    flights: dict[str, CaseFlight],
) -> None:
    found = {each.run: each for each in flights[NASA].comparisons}
    for name, beside, limit in (
        ("NASA 01", "rk4 at 0.01 s", 1e-10),
        ("NASA 04", "rk4 at 0.01 s", 1e-10),
        ("NASA 02", "adams2 at 0.01 s", 1e-7),
    ):
        assert found[name].beside == beside
        assert [each.channel for each in found[name].differences] == [
            "p_deg_s",
            "q_deg_s",
            "r_deg_s",
        ]
        assert worst(found[name]) < limit, name
    assert flights[NASA].case.times[-1] == 30.0


@pytest.mark.core
def test_a_longer_step_costs_what_the_order_of_its_method_says(
    flights: dict[str, CaseFlight],
) -> None:
    found = {each.run: worst(each) for each in flights[NASA].comparisons}
    ticks = {run.name: run.ticks for run in flights[NASA].runs}

    assert (ticks["rk4 at 0.01 s"], ticks["rk4 at 0.1 s"], ticks["rk4 at 0.5 s"]) == (3000, 300, 60)
    assert found["rk4 at 0.5 s"] / found["rk4 at 0.1 s"] == pytest.approx(5.0**4, rel=0.3)
    ratio = found["adams2 at 0.1 s"] / found["adams2 at 0.01 s"]
    assert ratio == pytest.approx(10.0**2, rel=0.1)
    assert found["adams2 at 0.5 s"] == pytest.approx(3.36, rel=0.1)


@pytest.mark.core
def test_every_case_is_flown_as_stored_and_within_its_spread(
    flights: dict[str, CaseFlight],
) -> None:
    faults = [
        f"{name}: {run.name}: {', '.join(run.changed)}"
        for name, flight in flights.items()
        for run in flight.runs
        if run.changed
    ]
    faults += [
        f"{name}: {each.run}: {', '.join(each.beyond)} beyond the spread"
        for name, flight in flights.items()
        for each in flight.comparisons
        if each.beyond
    ]
    assert not faults, RENEW
    assert set(flights) == {NASA, *MECHANISMS}
    assert {flight.case.boat.path.stem for flight in flights.values()} >= {
        *("bb2", "remus100", "sdv-mk9"),
    }


def test_a_case_of_our_own_is_flown_finely_and_at_the_boats_own_step() -> None:
    for name in MECHANISMS:
        case = load_case(CASES / f"{name}.toml")
        fine, own = case.runs
        assert (fine.integrator, fine.step_s) == ("rk4", 0.01), name
        assert own.step_s == load_vessel(case.heading.vessel).run.step_s, name
        assert fine.file, name
        assert own.file, name
        assert case.heading.mechanism, name


def moved(name: str) -> float:
    """Return by how much a channel moves in the stored outputs of a case."""
    case, channel = name.split(".")
    lines = (CASES / f"{case}.rk4.csv").read_text(encoding="utf-8").splitlines()
    place = lines[0].split(",").index(channel)
    return float(np.ptp([float(line.split(",")[place]) for line in lines[1:]]))


@pytest.mark.parametrize(
    ("name", "least"),
    [
        ("deceleration.u_m_s", 2.0),
        ("plane-step.theta_deg", 5.0),
        ("turn.psi_deg", 90.0),
        ("dive.z_m", 5.0),
        ("roll-decay.phi_deg", 15.0),
        ("ballast-step.weight_kN", 40.0),
        ("blow.weight_kN", 1000.0),
        ("sternway.psi_deg", 45.0),
        ("heave-decay.z_m", 0.2),
        ("current.y_m", 30.0),
        ("filter-sea.wave_m", 1.0),
        ("casualty.stern_deg", 14.0),
    ],
)
def test_a_case_has_the_mechanism_that_it_is_for(name: str, least: float) -> None:
    assert moved(name) > least


# What a stranger brings


@pytest.fixture
def stranger(flights: dict[str, CaseFlight], tmp_path: Path) -> Callable[[str, str], Path]:
    """Return what writes the turn's outputs as another program's, a text in it exchanged."""

    def write(old: str = "", new: str = "") -> Path:
        path = tmp_path / "turn.other.csv"
        text = outputs_text(flights["turn"].case, flights["turn"].runs[0])
        assert old in text
        path.write_text(text.replace(old, new, 1), encoding="utf-8")
        return path

    return write


@pytest.mark.core
def test_another_programs_outputs_are_laid_beside_ours_and_not_judged(
    stranger: Callable[..., Path],
) -> None:
    last = stranger().read_text(encoding="utf-8").splitlines()[-1]
    heading, values = last.split(","), []
    names = stranger().read_text(encoding="utf-8").splitlines()[0].split(",")
    for name, value in zip(names, heading, strict=True):
        shift = {"x_m": 3.0, "psi_deg": 360.5}.get(name, 0.0)
        values.append(f"{float(value) + shift!r}")

    (flight,) = fly_cases(case_paths(None), [stranger(last, ",".join(values))])

    (found,) = flight.others
    largest = {each.channel: each for each in found.differences}
    assert found.run == "turn.other.csv"
    assert largest["x_m"].largest == pytest.approx(3.0, abs=1e-6)
    assert largest["x_m"].at_s == 40.0
    assert largest["psi_deg"].largest == pytest.approx(0.5, abs=1e-4)  # a whole turn is none
    assert largest["y_m"].largest < 1e-6
    assert set(found.beyond) == {"x_m", "psi_deg"}
    assert flight.as_stated


@pytest.mark.core
def test_a_file_of_some_channels_and_of_more_times_will_do(stranger: Callable[..., Path]) -> None:
    path = stranger()
    rows = [line.split(",") for line in path.read_text(encoding="utf-8").splitlines()]
    place = rows[0].index("r_deg_s")
    lines = [f"{row[0]},{row[place]}" for row in rows]
    lines.insert(2, "0.25,99.0")
    path.write_text("\n".join(lines), encoding="utf-8")

    (flight,) = fly_cases(case_paths(None), [path])

    assert [(each.channel, each.largest < 1e-6) for each in flight.others[0].differences] == [
        ("r_deg_s", True)
    ]


@pytest.mark.core
@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("t_s", "time", 'line 1: no channel "time"'),
        ("p_deg_s", "p_degs", 'line 1: no channel "p_degs"; nearest is p_deg_s'),
        ("\n1,", "\n1.1,", "no output at t_s = 1; the nearest is row 4"),
        ("\n1,", "\n0.5,", "row 4: t_s = .*times must rise"),
        ("\n1,", "\n1,x", "row 4: u_m_s = .*must be a number"),
        ("\n1,", "\n1,,", "row 4: has .* fields, the heading"),
    ],
)
def test_a_strangers_file_that_is_wrong_is_named_with_its_line(
    stranger: Callable[..., Path], old: str, new: str, told: str
) -> None:
    path = stranger(old, new)

    with pytest.raises(ConfigError, match=told) as wrong:
        fly_cases(case_paths(None), [path])

    assert str(path) in str(wrong.value)


def test_a_file_of_no_case_and_a_folder_of_none_are_named(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="no case 'trun'; nearest is turn"):
        fly_cases(case_paths(None), [Path("trun.other.csv")])
    with pytest.raises(ConfigError, match="has no check case"):
        case_paths(tmp_path)
    with pytest.raises(ConfigError, match="there is no such folder"):
        case_paths(tmp_path / "none")


@pytest.mark.core
@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        (
            "u_m_s = 1.54\n",
            "u_m_s = 99.0\n",
            r"line \d+: \[start\] u_m_s = 99.0: must be -40 to 40",
        ),
        ("u_m_s = 1.54\n", "u_ms = 1.5\n", r"line \d+: \[start\] u_ms = 1.5: no such key; nearest"),
        ("stern_deg = -8", "stern_deg = -18", r"line \d+: \[start\] stern_deg = .*limit, 13.6 deg"),
        ("x_m = ", "x_km = ", r"line \d+: \[spread\] x_km = .*no such key; nearest is x_m"),
        ("step_s = 0.01", "step_s = 0.03", r"line \d+: \[runs\[0\]\] step_s = 0.03: sample_s"),
        ("duration_s = 40.0", "duration_s = 40.2", r"line \d+: duration_s = 40.2: must be a mult"),
        ("rudder right 5", "ruder right 5", r"line \d+: \[orders\[0\]\] order = "),
        ("rudder right 5", "rudder right 25", r"line \d+: \[orders\[0\]\] .*refused: the limit"),
        ("rudder right 5", "hover 20", r"line \d+: \[orders\[0\]\] .*refused: .* no tanks"),
        ('integrator = "rk4"\n', "", r"line \d+: \[runs\[0\]\] the first run is flown"),
        ('integrator = "rk4"', 'integrator = "rk5"', "--integrator 'rk5'"),
        ("turn.rk4.csv", "turn.none.csv", "turn.none.csv: cannot be read"),
        ('vessel = "remus100"', 'vessel = "remus"', "no vessel"),
        ('equations = "full"', 'equations = "ful"', r"line \d+: equations = "),
    ],
)
def test_a_case_that_is_wrong_is_named_with_its_line(
    tmp_path: Path, old: str, new: str, told: str
) -> None:
    text = (CASES / "turn.toml").read_text(encoding="utf-8")
    assert old in text
    (tmp_path / "turn.toml").write_text(text.replace(old, new, 1), encoding="utf-8")
    for path in CASES.glob("turn.*.csv"):
        (tmp_path / path.name).write_bytes(path.read_bytes())

    with pytest.raises(ConfigError, match=told):
        fly_cases(case_paths(tmp_path))


@pytest.mark.core
def test_outputs_that_are_not_those_stored_end_in_exit_code_1(tmp_path: Path) -> None:
    for path in CASES.glob("turn.*"):
        (tmp_path / path.name).write_bytes(path.read_bytes())
    stored = tmp_path / "turn.rk4.csv"
    lines = stored.read_text(encoding="utf-8").splitlines()
    cells = lines[5].split(",")
    cells[1] = f"{float(cells[1]) * (1.0 + 1e-6):.8g}"
    stored.write_text("\n".join([*lines[:5], ",".join(cells), *lines[6:]]), encoding="utf-8")

    result = CliRunner().invoke(cli, ["check-cases", str(tmp_path)])

    assert result.exit_code == 1
    assert "CHANGED: u_m_s" in result.stdout
    assert "1 of 1 case NOT as stated: turn." in result.stdout


def test_wrong_input_ends_in_exit_code_2(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys, "argv", ["trainer", "check-cases", "--with", "trun.csv"])
    with pytest.raises(SystemExit) as ended:
        run_command(cli, "trainer")

    assert ended.value.code == 2
    assert "nearest is turn" in capsys.readouterr().err


@pytest.mark.core
def test_the_page_plots_all_runs_of_a_case(
    flights: dict[str, CaseFlight], stranger: Callable[..., Path]
) -> None:
    (turn,) = fly_cases(case_paths(None), [stranger()])
    page = cases_page([flights[NASA], turn])

    sections = re.findall(r'<section id="([\w-]+)">(.*?)</section>', page, re.DOTALL)
    assert [name for name, _ in sections] == [NASA, "turn"]
    for (_, section), flight in zip(sections, (flights[NASA], turn), strict=True):
        runs = [run.name for run in flight.runs]
        assert re.findall(r"</svg>([^<]+)</span>", section) == runs
        charts = re.findall(r'<svg viewBox="0 0 460.*?</svg>', section, re.DOTALL)
        assert len(charts) == len(flight.case.spread)
        assert all(len(re.findall(r'<path class="c\d"', each)) == len(runs) for each in charts)
    data = re.findall(r'<script type="application/json" id="check-cases">(.*?)</script>', page)
    assert json.loads(data[0])["turn"]["comparisons"][-1]["run"] == "turn.other.csv"


def test_the_document_has_every_channel() -> None:
    text = (ROOT / "docs" / "check-cases.md").read_text(encoding="utf-8")

    assert all(f"`{name}`" in text for name in CASE_CHANNELS)
