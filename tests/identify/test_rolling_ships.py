"""Ships of small GM: roll as a further equation of the ships that are not linear."""

import json
import math
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result
from helpers.differences import fourth_order
from helpers.places import ROOT
from helpers.ships import (
    COEFFICIENTS,
    HEELED,
    ROLL_NOISE,
    ROLLING,
    SHIP,
    made_record,
    published,
    rolled_zigzag,
    trainer_columns,
    write_columns,
)

from trainer.analysis.manoeuvres.flight import fly_manoeuvre
from trainer.analysis.manoeuvres.turns import Turn
from trainer.boat.ship.models import MODELS, model_for, model_of, with_roll
from trainer.cli.main import cli
from trainer.config.files import ConfigError
from trainer.config.ship.ship import FitResult as Fitted
from trainer.config.ship.ship import ShipColumn, ShipFile, load_ship, parse_ship, ship_text
from trainer.core.kernel import Numbers
from trainer.identify.fitting.estimate import by_scoring
from trainer.identify.record.measurements import Record
from trainer.identify.ships import vehicle
from trainer.identify.ships.fit import USUAL_SEARCH, ShipFit, fit_ship, pose_problem
from trainer.identify.ships.likelihood import ShipProblem, prior_of
from trainer.identify.ships.records import load_trial, readings_of
from trainer.identify.ships.results import predict_record
from trainer.identify.ships.vehicle import IdentifiedShip
from trainer.units import KNOT

PLAIN = replace(ROLLING, dimensions=replace(ROLLING.dimensions, beam_m=None))
STEP = 0.5


def rolling_problem(name: str) -> tuple[ShipProblem, Numbers]:
    """Return the record of section 11 with a roll that was read, and where it is looked at."""
    plain, a, _ = made_record(name)
    model = with_roll(plain.model)
    values = published(name) | {"K_0": 0.1, "K_v": 12.0, "K_r": -5.0, "K_F": 4.0, "K_d": 3.0}
    values |= {"K_w": 0.01, "K_phi": -1.1, "K_p": -0.2, "Y_phi": 0.3, "N_phi": -0.4}
    trial = plain.trials[0]
    k = np.arange(len(trial.t))
    rate, roll = 2e-3 * np.cos(0.3 * k), 0.02 * np.sin(0.3 * k) + 0.01
    rate[30:40], roll[70:73] = math.nan, math.nan
    trial = replace(trial, roll_rate=rate, roll=roll)
    count = len(model.free) + len(model.noises)
    nothing = np.zeros(count), np.full(count, math.inf), np.zeros(6)
    problem = ShipProblem(model, np.array(ROLLING.constants), (trial,), *nothing)
    first = [*a[-4:], 1e-3, 0.02]
    noise = ROLL_NOISE * [1, 1, 1, 3, 1, 1, 1, 1, 5, 5]
    return problem, np.array([*(values[each] for each in model.free), *np.log(noise), *first])


@pytest.mark.slow
@pytest.mark.parametrize("name", MODELS)
def test_gradient_and_information_are_those_of_differences(name: str) -> None:
    problem, a = rolling_problem(name)
    (_, g), H = problem.slope(a), problem.information(a)
    known = np.sqrt(np.diag(H))
    found, e_by = fourth_order(problem.value, a, 1e-3 / known), []
    for e in np.diag(1e-3 / known):
        two = [problem.innovations(a + n * e, 0) for n in (-1, 1)]
        e_by.append((two[1] - two[0])[np.isfinite(two[0])] / 2.0 / e.sum())

    assert problem.model.states == 6
    assert np.isfinite(problem.value(a))
    assert known.min() > 0.0
    assert np.max(np.abs((found - g) / known)) < 1e-6
    # where only the error moves, its square is the information
    moved = np.array([e_by[problem.names.index(each)] for each in ("K_0", "K_v", "Y_phi")])
    places = [problem.names.index(each) for each in ("K_0", "K_v", "Y_phi")]
    assert np.diag(moved @ moved.T) == pytest.approx(np.diag(H)[places], rel=0.05)


@pytest.mark.long
def test_without_coupling_roll_changes_nothing_of_the_rest() -> None:
    problem, a = rolling_problem("mmg")
    for name in ("Y_phi", "N_phi"):
        a[problem.names.index(name)] = 0.0
    plain, own, states = made_record("mmg")
    at = {**dict(zip(problem.names, a, strict=False)), "gamma_a": own[plain.names.index("gamma_a")]}
    own[: len(plain.model.free)] = [at[name] for name in plain.model.free]

    sailed = problem.sail(a, problem.trials[0])

    assert np.ptp(sailed[:, 5]) > 0.02
    assert sailed[:, :4] == pytest.approx(plain.sail(own, plain.trials[0]), abs=1e-9)
    assert np.isfinite(states).all()


@pytest.fixture(scope="module")
def found() -> ShipFit:
    """Return the fit to a zig-zag of a known ship whose roll angle was read, and no rate."""
    trial, _ = rolled_zigzag(20.0, seed=1)
    trial = replace(trial, roll_rate=None)
    model = with_roll(model_of("mmg", wind=False))
    problem, begin = pose_problem(
        model, np.array(PLAIN.constants), [trial], prior_of(model, PLAIN)[0], 0.5
    )
    return fit_ship(problem, begin)


@pytest.mark.long
def test_a_fit_finds_the_ship_and_her_roll(found: ShipFit) -> None:
    free = found.problem.model.free
    truth = np.array([HEELED[name] for name in free])
    away = (found.a[: len(free)] - truth) / found.deviations[: len(free)]
    share = dict(zip(found.problem.names, found.prior_share, strict=True))
    of_roll = [name[:2] == "K_" for name in free]

    assert found.found.converged
    assert np.max(np.abs(away)) < 4.0
    assert np.mean(away**2) < 2.0
    assert np.mean(away[of_roll] ** 2) < 3.0
    assert found.deviations[free.index("K_phi")] < 0.05
    assert max(share[name] for name in ("K_0", "K_v", "K_r", "K_F", "K_phi", "K_p")) < 0.2
    assert share["Y_phi"] > 0.5  # a roll that follows the turning tells little of its own


@pytest.mark.long
def test_a_fit_predicts_the_roll_of_runs_that_it_has_not_seen(found: ShipFit) -> None:
    for angle in (-10.0, -20.0):
        other, _ = rolled_zigzag(angle, seed=7)
        told = predict_record(found.problem, found.found.theta, other, "held back").explained
        assert told[5] is not None
        assert told[5] > 90.0, angle
        assert (told[2] or 0.0) > 97.0, angle


def rolled_columns(trial: Record) -> dict[str, Numbers]:
    """Return a record's columns as the trainer writes them."""
    p, phi = readings_of(trial).T[-2:]
    return {**trainer_columns(trial), "p": p, "phi": phi}


@pytest.fixture(scope="module")
def columns() -> dict[str, Numbers]:
    return rolled_columns(rolled_zigzag(20.0, seed=1)[0])


def test_roll_is_read_where_the_ship_has_a_gm_and_only_there(
    columns: dict[str, Numbers], tmp_path: Path
) -> None:
    part = columns | {"phi": np.where(np.arange(300) == 7, math.nan, columns["phi"])}
    path = write_columns(part, tmp_path / "a.csv")
    rolled, plain = load_trial(path, ROLLING), load_trial(path, SHIP)

    own = {"t": "s", "rudder": "rad", "revolutions": "1/s", "speed": "m/s", "sway": "m/s"}
    own |= {"yaw_rate": "rad/s", "heading": "rad", "roll": "rad"}
    names = ("t", "delta_r", "n", "u", "v", "r", "psi", "phi")
    rows = tuple(
        ShipColumn(channel=channel, column=name, unit=unit)
        for (channel, unit), name in zip(own.items(), names, strict=True)
    )

    assert load_trial(path, replace(SHIP, columns=rows)).speed == pytest.approx(plain.speed)
    assert readings_of(load_trial(path, replace(ROLLING, columns=rows))).shape == (300, 6)
    assert readings_of(rolled)[:, 4] == pytest.approx(columns["p"])
    assert np.flatnonzero(np.isnan(readings_of(rolled)[:, 5])).tolist() == [7]
    assert readings_of(rolled)[8:, 5] == pytest.approx(columns["phi"][8:])
    assert plain.roll is None
    assert readings_of(rolled)[:, :4] == pytest.approx(readings_of(plain))
    assert load_trial(path, ROLLING, every=2).column("roll")[4:] == pytest.approx(
        [columns["phi"][k : k + 2].mean() for k in range(8, 298, 2)]
    )


def test_a_bad_roll_is_refused_with_its_remedy(columns: dict[str, Numbers], tmp_path: Path) -> None:
    def refused(change: dict[str, Numbers], every: int = 1, ship: ShipFile = ROLLING) -> str:
        with pytest.raises(ConfigError) as wrong:
            load_trial(write_columns(columns | change, tmp_path / "bad.csv"), ship, every)
        return str(wrong.value)

    without = {name: one for name, one in columns.items() if name != "phi"}
    path = write_columns(without, tmp_path / "none.csv")
    with pytest.raises(ConfigError, match=r"none.csv: no roll was recorded, and ship.toml has \["):
        load_trial(path, ROLLING)
    phi, none = columns["phi"], np.full(300, math.nan)
    assert re.search(r"bad.csv: row 2 on: .*is it in rad, not deg", refused({"phi": phi / 57.3}))
    assert re.search(r"bad.csv: row 2 on: .*is it in deg, not rad", refused({"phi": phi * 57.3}))
    assert "fewer than 30 rows have one" in refused({"phi": none})
    assert re.search(r"a sample each 6 s, and a roll of ship.toml lasts 29.8 s", refused({}, 3))
    leaning = load_trial(write_columns(columns | {"phi": -phi}, tmp_path / "a.csv"), ROLLING)
    assert any("leans into the turn" in text for text in map(str, leaning.findings))


@pytest.mark.parametrize(
    ("roll", "told"),
    [
        ("gm_m = 0", r"ship.toml: \[roll\] gm_m = 0: must be above 0 to 20 m"),
        ("gm_m = -0.3", r"\[roll\] gm_m = -0.3: must be above 0"),
        ("radius_m = 9", r"\[roll\] .*lacks gm_m|\[roll\].*gm_m"),
        ("gm_m = 1\nperiod_s = 9", r"\[roll\] period_s"),
        ("gm_m = 1", r"\[roll\].* lacks radius_m, or beam_m in \[dimensions\]"),
    ],
)
def test_a_wrong_roll_of_a_ship_is_named(roll: str, told: str) -> None:
    text = re.sub(r"beam_m.*\n", "", ship_text(SHIP, ""))
    with pytest.raises(ConfigError, match=told):
        parse_ship(f"{text}\n[roll]\n{roll}\n", Path("ship.toml"))


def test_the_radius_is_by_the_beam_where_none_is_said() -> None:
    ship = parse_ship(ship_text(SHIP, "") + "\n[roll]\ngm_m = 2.0\n", Path("ship.toml"))

    assert ship.stiffness == pytest.approx(9.81 * 2.0 / (0.38 * 58.0) ** 2)
    assert SHIP.stiffness == 0.0
    page = (ROOT / "docs" / "nonlinear-ships.md").read_text(encoding="utf-8")
    told = re.search(r"```toml\n(\[roll\].*?)```", page, re.DOTALL)
    assert told is not None
    for text in (ship_text(ROLLING, ""), ship_text(SHIP, "") + told[1]):
        assert parse_ship(text, Path("ship.toml")).roll == ROLLING.roll


def known(name: str = "mmg", **change: float) -> ShipFile:
    """Return the tanker of small GM as a fit would have written her."""
    values = HEELED | {"Y_d": -0.15, "N_d": 0.8, "K_d": 2.0} | change
    model = model_for(ROLLING, name, wind=False)
    whole = {each: values.get(each, 0.0) for each in model.names}
    result = Fitted(model=name, speed_kn=15.0, revolutions_per_s=1.4)
    return replace(ROLLING, result=result, coefficients=whole, covariance=None)


def test_a_steady_turn_heels_as_its_moments_balance() -> None:
    linear = {"Y_v": -0.8, "N_v": -1.0, "N_r": -1.5, "X_vv": -0.5}
    ship = IdentifiedShip(known("linear", **linear))
    flight = fly_manoeuvre(ship, Turn(angle_deg=15.0, duration_s=2500.0), 15.0 * KNOT)
    u, v, r, phi, rudder = (float(flight.column(x)[-1]) for x in ("u", "v", "r", "phi", "delta_r"))
    size, L = math.hypot(u, v), 320.0
    moment = 0.05 + 14.0 * v / size - 6.0 * r * L / size - 2.0 * rudder

    assert abs(phi) > math.radians(0.5)
    assert phi == pytest.approx((size / L) ** 2 * moment / (1.1 * ROLLING.stiffness), rel=1e-4)
    assert phi < 0.0 < r  # she leans outwards


def test_a_ship_that_is_let_go_rolls_in_her_own_period() -> None:
    ship = IdentifiedShip(known(K_v=0.0, K_r=0.0, K_F=0.0, K_0=0.0, Y_phi=0.0, N_phi=0.0))
    ship.start(15.0 * KNOT)
    ship.incline(math.radians(5.0))
    rows = []
    for _ in range(int(60.0 / ship.step)):
        rows.append([ship.observe()[0], ship.observe()[-1]])
        ship.advance()
    t, phi = np.array(rows).T
    falls = t[np.flatnonzero((phi[:-1] > 0.0) & (phi[1:] <= 0.0))]
    natural, damping = math.sqrt(1.1 * ROLLING.stiffness), 0.5 * 0.14 * math.sqrt(ROLLING.stiffness)

    period = 2.0 * math.pi / math.sqrt(natural**2 - damping**2)
    assert falls[1] - falls[0] == pytest.approx(period, abs=2.0 * ship.step)
    place = round(period / ship.step)
    assert phi[place] / phi[0] == pytest.approx(math.exp(-damping * period), rel=0.03)


def asked(*words: object) -> Result:
    return CliRunner().invoke(cli, [str(word) for word in words])


@pytest.mark.slow
def test_a_ship_is_fitted_written_and_sailed_with_her_heel(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(vehicle, "MAX_DRAWS", 20)
    names = ("known.toml", "ship.toml", "found.toml", "20.csv", "10.csv", "c.csv", "fit.html")
    sailing, ship, result, record, other, table, page = (tmp_path / name for name in names)
    sailing.write_text(ship_text(known(), ""), encoding="utf-8")
    sensors = "\n[sensors]\nsway_kn = 0.04\nyaw_rate_deg_s = 0.005\nheading_deg = 0.05\n"
    ship.write_text(ship_text(ROLLING, "") + sensors, encoding="utf-8")
    made = [
        asked("manoeuvre", "zigzag-20", sailing, "--duration", 600, "--csv", record),
        asked("manoeuvre", "zigzag-10", sailing, "--duration", 600, "--csv", other),
    ]
    fitted = asked(
        *("identify", record, "--model", "mmg", "--ship", ship, "--every", 2, "--predict", other),
        *("--write-ship", result, "--coefficients", table, "--html", page),
    )
    turned = [asked("manoeuvre", "turning-circle", one, "--json") for one in (sailing, result)]

    assert [one.exit_code for one in (*made, fitted, *turned)] == [0] * 5, repr(fitted.exception)
    assert "roll: period 28." in fitted.output
    assert re.search(r"K_phi +-1\.\d+ ", fitted.output)
    assert re.search(r"10.csv +held back( +\S+){5} +9\d\.\d", fitted.output)
    assert "roll, 10.csv" in page.read_text(encoding="utf-8")
    assert re.search(r"^K_p,-0\.\d+,0\.\d+", table.read_text(encoding="utf-8"), re.MULTILINE)
    found = load_ship(result)
    assert found.roll == ROLLING.roll
    assert {"K_v", "K_phi", "N_phi"} <= set(found.uncertain)
    assert found.ranges["roll"][0] < 0.0 < found.ranges["roll"][1]
    told = [{x["name"]: x["value"] for x in json.loads(one.stdout)["measures"]} for one in turned]
    assert told[0]["largest roll"] < math.radians(-1.0) < 0.0 < told[0]["snap roll"]
    for name in ("snap roll", "largest roll"):
        assert told[1][name] == pytest.approx(told[0][name], rel=0.2)


def test_a_ship_of_small_gm_without_her_moments_is_refused() -> None:
    whole = {name: COEFFICIENTS.get(name, 0.0) for name in model_of("mmg", wind=False).names}
    ship = replace(known(), coefficients=whole)
    with pytest.raises(ConfigError, match=r"\[coefficients\] lacks K_0, K_v, K_r, K_F, K_phi"):
        IdentifiedShip(ship)
    with pytest.raises(ConfigError, match=r"\[coefficients\] K_0 is none of model mmg"):
        IdentifiedShip(replace(known(), roll=None))


@pytest.mark.long
def test_a_trial_says_what_it_would_tell_of_roll(tmp_path: Path) -> None:
    path = tmp_path / "known.toml"
    path.write_text(ship_text(known(), ""), encoding="utf-8")
    answer = asked("prbs", path, "--zigzag", "20/20", "--seconds", 500, "--json")
    told = {one["name"]: one for one in json.loads(answer.stdout)["plans"][0]["coefficients"]}

    assert told["K_phi"]["prior_share"] < 0.2
    assert 0.0 < told["K_F"]["deviation"] < 3.0


@pytest.mark.long
def test_a_search_from_the_truth_stays_there() -> None:
    trial, first = rolled_zigzag(20.0, seed=3)
    model = model_for(ROLLING, "mmg", wind=False)
    problem, _ = pose_problem(
        model, np.array(ROLLING.constants), [trial], prior_of(model, PLAIN)[0], 0.5
    )
    truth = np.array([*(HEELED[name] for name in model.free), *np.log(ROLL_NOISE), *first])

    end = by_scoring(problem, truth, USUAL_SEARCH)

    assert end.converged
    assert problem.value(truth) - end.cost < 45.0  # half of 50 parameters, and what books add
