"""Trials of ships that are not linear: what is expected of them, and what comes of them."""

import json
import math
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner
from helpers.places import ROOT

from trainer.analysis.manoeuvres.flight import LEAD_TIME_S, fly_manoeuvre
from trainer.analysis.manoeuvres.zigzag import ZigZag
from trainer.cli.main import cli
from trainer.config.files import ConfigError
from trainer.config.ship.sensors import Sensors
from trainer.config.ship.ship import ShipFile, parse_ship
from trainer.core.kernel import Numbers
from trainer.identify.experiment import prbs
from trainer.identify.fitting.estimate import by_scoring
from trainer.identify.record.sources import USUAL_SENSORS
from trainer.identify.ships.fit import USUAL_SEARCH, problem_of
from trainer.identify.ships.records import READING_CHANNELS
from trainer.identify.ships.trials import (
    BinaryHelm,
    TrialDesign,
    TrialOptions,
    TrialShip,
    design_trials,
    flown_trial,
    sensors_of,
)
from trainer.units import KNOT

PAGE = (ROOT / "docs" / "ship-trials.md").read_text(encoding="utf-8")
SHIPS_PAGE = (ROOT / "docs" / "nonlinear-ships.md").read_text(encoding="utf-8")
KNOWN_TEXT = re.findall(r"```toml\n(.*?)```", SHIPS_PAGE, re.DOTALL)[1]
SENSORS = Sensors(sway_kn=0.04, yaw_rate_deg_s=0.006, heading_deg=0.03)
OPTIONS = TrialOptions(
    zigzag=(20.0, 20.0),
    seconds=800.0,
    interval=5.0,
    unrest=0.01,
    prior_strength=4.0,
    sensors=SENSORS,
)
WEAK = ((15.0, 15.0), (15.0, 8.0))  # the second with the revolutions of 8 kn


@pytest.fixture(scope="module")
def known() -> ShipFile:
    """Return the known tanker of the page."""
    return parse_ship(KNOWN_TEXT, Path("known.toml"))


@pytest.fixture(scope="module")
def pair(known: ShipFile) -> TrialDesign:
    """Return a zig-zag, one with fewer revolutions, and both in the same time."""
    return design_trials(known, replace(OPTIONS, speeds=WEAK))


def deviations(found: TrialDesign, name: str) -> list[float]:
    """Return the expected standard deviation of a coefficient, by plan."""
    return [
        one.deviation
        for plan in found.report.plans
        for one in plan.coefficients
        if one.name == name
    ]


@pytest.mark.parametrize("name", ["kappa", "N_F", "c_w"])
def test_two_speeds_of_propeller_tell_the_slipstream_from_the_rudder(
    pair: TrialDesign, name: str
) -> None:
    alone, slow, both = deviations(pair, name)
    plans = pair.report.plans

    assert both < 0.9 * alone
    assert both < 0.9 * slow
    assert plans[2].seconds == pytest.approx(0.5 * plans[0].seconds, abs=2.0)
    assert plans[2].samples <= plans[0].samples + 2


def test_two_speeds_with_revolutions_of_their_own_do_not(known: ShipFile) -> None:
    # the propeller advances alike at both: the slower is the same trial, read worse
    plain = design_trials(known, replace(OPTIONS, speeds=((15.0, 15.0), (8.0, 8.0))))
    alone, slow, both = deviations(plain, "kappa")

    assert alone < both < slow


def test_better_instruments_and_a_longer_trial_tell_more(
    known: ShipFile, pair: TrialDesign
) -> None:
    first = replace(OPTIONS, speeds=WEAK[:1])
    half = {name: 0.5 * value for name, value in vars(SENSORS).items() if value}
    sharp = design_trials(known, replace(first, sensors=Sensors(**half), unrest=0.005))
    longer = design_trials(known, replace(first, seconds=1600.0))
    blind = design_trials(known, replace(first, outputs=("sway", "heading")))
    assert deviations(blind, "N_r")[0] > 1.02 * deviations(pair, "N_r")[0]
    for name in ("N_F", "Y_v", "kappa"):
        usual = deviations(pair, name)[0]
        assert 0.4 * usual < deviations(sharp, name)[0] < 0.7 * usual
        assert 0.5 * usual < deviations(longer, name)[0] < 0.9 * usual


def test_the_book_s_share_falls_where_the_book_is_weak(known: ShipFile, pair: TrialDesign) -> None:
    firm = design_trials(known, replace(OPTIONS, speeds=WEAK, prior_strength=0.5)).report.plans[2]
    none = design_trials(known, replace(OPTIONS, speeds=WEAK[:1], prior_strength=0.0)).report.plans[
        0
    ]
    weak = pair.report.plans[2]

    assert "l" in firm.from_book
    # what the record does not tell is its own, whatever the book says
    assert firm.untold[0].eigenvalue == pytest.approx(weak.untold[0].eigenvalue, rel=1e-3)
    assert all(
        one.prior_share < 1.0 and one.prior_share <= other.prior_share
        for one, other in zip(weak.coefficients, firm.coefficients, strict=True)
    )
    assert all(one.prior_share == 0.0 for one in none.coefficients)
    assert any({"N_vrr", "N_vvr"} <= set(one.parts) for one in none.untold)


class ShakenShip(TrialShip):
    """A ship that begins as in a trial, in the sea that was expected."""

    def __init__(self, ship: ShipFile, held: float, sea: Numbers, seed: int) -> None:
        super().__init__(ship, held)
        self._sea, self._stream = sea, np.random.default_rng(seed)

    def advance(self) -> None:
        super().advance()
        shaken = math.sqrt(self.step) * self._sea * self._stream.standard_normal(3)
        u, v, r, *others = self.now.state
        moved = (np.array([u, v, r]) + shaken).tolist()
        self.now = self.now._replace(state=(*moved, *others))


def scatter(known: ShipFile, found: TrialDesign, count: int) -> Numbers:
    """Return the errors of made records over what was expected (count, coefficients).

    They are fitted with a prior drawn about the truth, so that it is one more honest reading.
    """
    expected = found.expected[-1]
    problem, p = expected.problem, len(expected.problem.model.free)
    noise = problem.noise(expected.a)
    away = []
    for seed in range(count):
        stream = np.random.default_rng(1000 + seed)
        trials = []
        for i, (speed, held) in enumerate(WEAK):
            ship = ShakenShip(known, held * KNOT, noise[:3], 10 * seed + i)
            flight = fly_manoeuvre(ship, ZigZag(duration_s=400.0), speed * KNOT)
            every = round(found.report.interval_s / flight.step)
            trial = flown_trial(flight, every, found.report.outputs)
            errors = (noise[3:] * stream.standard_normal((len(trial.t), 4))).T
            read = zip(READING_CHANNELS, errors, strict=True)
            noisy = {name: trial.column(name) + error for name, error in read}
            trials.append(replace(trial, **noisy))
        prior = {
            name: (value + width * stream.standard_normal(), width)
            for name, value, width in zip(
                problem.model.free, expected.a, problem.width, strict=False
            )
            if math.isfinite(width)
        }
        posed = problem_of(problem.model, problem.constants, trials, prior, 1.0)
        end = by_scoring(posed, expected.a, USUAL_SEARCH)
        assert end.converged
        away.append((end.theta[:p] - expected.a[:p]) / expected.deviations[:p])
    return np.array(away)


@pytest.mark.slow
def test_many_made_records_scatter_as_was_expected(known: ShipFile, pair: TrialDesign) -> None:
    away = scatter(known, pair, 60)
    size = np.sqrt(np.mean(away**2, axis=0))  # a size of 60 has itself a deviation of 0.09

    assert np.sqrt(np.mean(away**2)) == pytest.approx(1.0, abs=0.15)
    assert size.min() > 0.7
    assert size.max() < 1.5


@pytest.fixture
def file(tmp_path: Path) -> str:
    """Return the path of the known tanker."""
    path = tmp_path / "known.toml"
    path.write_text(KNOWN_TEXT, encoding="utf-8")
    return str(path)


def asked(*words: str) -> Any:
    return CliRunner().invoke(cli, ("prbs", *words))


def test_the_page_s_command_sets_plans_side_by_side(file: str, monkeypatch: Any) -> None:
    monkeypatch.chdir(Path(file).parent)
    line = re.findall(r"\$ trainer ship prbs (known.toml .*)", PAGE)[0]

    page, told = asked(*line.split()), asked(*line.split(), "--json")

    assert page.exit_code == 0, page.output
    report = json.loads(told.stdout)
    assert [plan["name"] for plan in report["plans"]] == ["A", "B", "C"]
    assert report["outputs"] == ["speed", "sway", "yaw_rate", "heading"]
    assert "C  zig-zag from 15 kn; zig-zag from 15 kn, revolutions of 8 kn: 400" in page.output
    assert any(re.match("C tells .*kappa.* better than", text) for text in report["remarks"])
    # the page's table is what the command says
    for name in ("N_F", "kappa"):
        said = re.search(rf"\| {name} \| ([\d.]+) \| ([\d.]+) \| ([\d.]+) \|", PAGE)
        assert said
        own = [
            one["deviation"]
            for plan in report["plans"]
            for one in plan["coefficients"]
            if one["name"] == name
        ]
        assert [float(x) for x in said.groups()] == pytest.approx(own, rel=0.02)


def test_a_binary_sequence_beside_a_zig_zag_is_as_the_page_says(
    file: str, monkeypatch: Any
) -> None:
    monkeypatch.chdir(Path(file).parent)
    line = re.findall(r"\$ trainer ship prbs (known.toml .*)", PAGE)[1]

    report = json.loads(asked(*line.split(), "--json").stdout)

    assert [plan["name"] for plan in report["plans"]] == ["A", "B", "C"]
    for name in ("N_r", "X_F", "N_F", "kappa"):
        said = re.findall(rf"\| {name} \| ([\d.]+) \| ([\d.]+) \| ([\d.]+) \|", PAGE)[-1]
        own = [
            one["deviation"]
            for plan in report["plans"]
            for one in plan["coefficients"]
            if one["name"] == name
        ]
        assert list(map(float, said)) == pytest.approx(own, rel=0.02), name
        if name == "N_r":
            assert own[1] < 0.7 * own[0]


def test_the_rudder_follows_the_register_again_and_again_from_where_it_held(
    known: ShipFile,
) -> None:
    helm = BinaryHelm(angle_deg=10.0, hold_s=30.0, bits=3, duration_s=400.0)
    flight = fly_manoeuvre(TrialShip(known, 15.0 * KNOT), helm, 15.0 * KNOT)

    rudder = np.degrees(flight.change("delta_r"))
    ends = LEAD_TIME_S + 30.0 * np.arange(1, 14) - 1.0  # by then it has swung over
    seen = np.interp(ends, flight.t, rudder)

    assert flight.t[-1] == pytest.approx(400.0, abs=1.0)
    assert seen == pytest.approx(10.0 * np.resize(prbs(3), 13), abs=1e-6)
    assert len(flight.marks) == 1 + np.count_nonzero(np.diff(np.resize(prbs(3), 14)))


def test_bits_and_register_fit_the_ship_and_the_time(known: ShipFile) -> None:
    alone = replace(OPTIONS, zigzag=None, amplitude=15.0, seconds=900.0)
    (helm,) = design_trials(known, alone).report.helms

    assert helm.hold_s == pytest.approx(320.0 / (15.5 * KNOT))
    assert helm.bits == 5  # 22 bits of it, of a period of 31
    assert "sequence of 15 deg, bits of 40.1 s, register of 5" in str(helm)


@pytest.mark.parametrize(
    ("words", "told"),
    [
        ((), "say its --zigzag"),
        (("--zigzag", "20/20", "--periods", "3"), "--periods: not with a ship"),
        (("--zigzag", "20/20", "--bits", "3"), "--bits: of a sequence: say its --amplitude"),
        (("--amplitude", "40"), "--amplitude: the rudder goes to 35 deg, not 40"),
        (("--amplitude", "20", "--bits", "3", "--seed", "8"), "takes 1 to 7"),
        (("--zigzag", "40/20"), "the rudder goes to 35 deg, not 40"),
        (("--zigzag", "20/20", "--speed", "15/fast"), "'fast' is not a valid float"),
        (("--zigzag", "20/20", "--speed", "61"), "61"),
        (("--zigzag", "20/20", *("--speed", "9") * 5), "a page has room for 4"),
        (("--zigzag", "20/20", "--output", "heading"), "told by sway with yaw_rate or heading"),
        (("--zigzag", "20/20", "--seconds", "40"), "samples of a trial; needs 30 or more"),
    ],
)
def test_what_cannot_be_tried_is_refused(file: str, words: tuple[str, ...], told: str) -> None:
    answer = asked(file, *words)

    assert answer.exit_code != 0
    assert told in answer.output + str(answer.exception)


@pytest.mark.parametrize("words", [("--speed", "9/5"), ("--speed", "9", "--speed", "5")])
def test_a_boat_takes_one_speed(words: tuple[str, ...]) -> None:
    assert "is a boat: give one speed" in asked("bb2", *words).output
    assert "no book is asked" in asked("bb2", "--prior-strength", "1").output


def test_what_is_no_boat_is_told_before_its_speeds() -> None:
    answer = asked("nix.toml", "--speed", "9", "--speed", "5")
    assert "nix.toml: there is no such file" in str(answer.exception)


def test_a_ship_without_a_fit_cannot_be_tried(known: ShipFile) -> None:
    with pytest.raises(ConfigError, match=r"known.toml: lacks \[result\]"):
        design_trials(replace(known, result=None), OPTIONS)


def test_instruments_are_those_asked_for_then_the_file_s_then_usual_ones(known: ShipFile) -> None:
    asked = Sensors(sway_kn=0.05, yaw_rate_deg_s=0.3, heading_deg=0.1)
    file = replace(known, sensors=Sensors(sway_kn=0.01, yaw_rate_deg_s=0.01))

    found = sensors_of(file, asked, {"yaw_rate"})

    assert (found.sway_kn, found.yaw_rate_deg_s, found.heading_deg) == (0.01, 0.3, 0.1)
    assert sensors_of(replace(known, sensors=None), USUAL_SENSORS, ()) == USUAL_SENSORS
