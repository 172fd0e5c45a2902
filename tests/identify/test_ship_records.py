"""Records and files of ships that are not linear: what is read, what is refused, what sails."""

import json
import math
import re
import shlex
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result
from helpers import ships
from helpers.places import ROOT
from helpers.ships import COEFFICIENTS, SHIP, sailed_zigzag, trainer_columns, write_columns

import trainer
from trainer.analysis.manoeuvres.catalogue import adjust_manoeuvre
from trainer.analysis.manoeuvres.flight import fly_manoeuvre
from trainer.analysis.manoeuvres.page import ManoeuvreOptions
from trainer.analysis.manoeuvres.turns import Turn
from trainer.analysis.manoeuvres.vehicle import PORT, STARBOARD
from trainer.analysis.sweep.study import parse_study
from trainer.api.subjects import subject_of
from trainer.boat.ship.models import model_of
from trainer.cli.main import cli
from trainer.config.files import ConfigError
from trainer.config.ship.ship import FitResult as Fitted
from trainer.config.ship.ship import (
    RecordSettings,
    ShipColumn,
    ShipFile,
    load_ship,
    parse_ship,
    ship_text,
)
from trainer.core.kernel import Numbers
from trainer.identify.options import IdentifyOptions
from trainer.identify.ships import vehicle
from trainer.identify.ships.likelihood import ShipProblem
from trainer.identify.ships.records import filter_table, inputs_of, load_trial
from trainer.identify.ships.results import read_trials
from trainer.identify.ships.vehicle import IdentifiedShip, draw_ships, fly_ship
from trainer.units import KNOT

PAGE = (ROOT / "docs" / "nonlinear-ships.md").read_text(encoding="utf-8")
Columns = dict[str, Numbers]


@pytest.fixture(scope="module")
def columns() -> Columns:
    """Return the columns of a zig-zag as the trainer writes them."""
    return trainer_columns(sailed_zigzag(20.0, seed=1)[0])


def test_a_record_keeps_its_rudder_to_port_and_only_the_filter_has_it_to_starboard(
    columns: Columns, tmp_path: Path
) -> None:
    trial = load_trial(write_columns(columns, tmp_path / "a.csv"), SHIP)

    table = filter_table(trial, np.array(SHIP.constants))

    assert trial.speed == pytest.approx(columns["u"])
    assert trial.rudder == pytest.approx(columns["delta_r"])
    assert table[:, 4] == pytest.approx(-columns["delta_r"])
    assert (table[:, 9] == 1.0).all()
    assert not inputs_of(trial)[:, 2:].any()


@pytest.mark.parametrize(
    ("said", "every", "steps"), [("step", 1, -1.0), ("straight", 1, 1.0), ("step", 5, 1.0)]
)
def test_the_ships_file_says_how_the_rudder_goes_between_readings(
    columns: Columns, tmp_path: Path, said: str, every: int, steps: float
) -> None:
    ship = replace(SHIP, records=RecordSettings(between_readings=said))
    trial = load_trial(write_columns(columns, tmp_path / "a.csv"), ship, every=every)

    assert (np.sign(filter_table(trial, np.array(SHIP.constants))[:, 9]) == steps).all()
    (told,) = [one for one in map(str, trial.findings) if "taken as " in one]
    assert ("held until" in told) == (steps < 0.0)


def test_an_option_outranks_the_ships_file_about_the_rudder_between_readings(
    columns: Columns, tmp_path: Path
) -> None:
    said = replace(SHIP, records=RecordSettings(between_readings="straight"))
    path, record = tmp_path / "ship.toml", write_columns(columns, tmp_path / "a.csv")
    path.write_text(ship_text(said, ""), encoding="utf-8")

    for way in (None, "straight", "step"):
        options = IdentifyOptions(model="mmg", ship=path, between_readings=way, predict=(record,))
        _, trials, held = read_trials([record], options)
        assert {one.between_readings for one in (*trials, *held)} == {way or "straight"}


def test_rows_are_averaged_around_the_one_taken(columns: Columns, tmp_path: Path) -> None:
    trial = load_trial(write_columns(columns, tmp_path / "a.csv"), SHIP, every=5)

    assert trial.t[:2] == pytest.approx([4.0, 14.0])
    assert trial.column("speed")[0] == pytest.approx(columns["u"][:5].mean())
    assert trial.column("revolutions")[1] == pytest.approx(1.5)


def test_velocities_over_ground_are_turned_into_the_ship_where_the_water_stands(
    columns: Columns, tmp_path: Path
) -> None:
    u, v, psi = columns["u"], columns["v"], columns["psi"]
    north, east = u * np.cos(psi) - v * np.sin(psi), u * np.sin(psi) + v * np.cos(psi)
    ground = {key: columns[key] for key in ("t", "r", "psi", "delta_r")}
    ground |= {"vx": north, "vy": east, "rpm": 60.0 * columns["n"]}
    path = write_columns(ground, tmp_path / "a.csv")
    own = {"t": "t", "rudder": "delta_r", "yaw_rate": "r", "heading": "psi", "revolutions": "rpm"}
    own |= {"north_velocity": "vx", "east_velocity": "vy"}
    units = {"rudder": "rad", "yaw_rate": "rad/s", "heading": "rad", "revolutions": "rpm", "t": "s"}
    rows = tuple(
        ShipColumn(channel=key, column=name, unit=units.get(key, "m/s"))
        for key, name in own.items()
    )
    ship = replace(SHIP, columns=rows)

    with pytest.raises(ConfigError, match=r'over ground.*current = "none"'):
        load_trial(path, ship)
    trial = load_trial(path, replace(ship, records=RecordSettings(current="none")))

    assert trial.speed == pytest.approx(u)
    assert trial.sway == pytest.approx(v, abs=1e-9)
    assert trial.revolutions == pytest.approx(1.5)


def test_wind_by_speed_and_direction_comes_from_ahead_and_starboard(
    columns: Columns, tmp_path: Path
) -> None:
    wind = {"wind_ahead": columns["u"], "wind_starboard": 0.0 * columns["u"] + 2.0}
    trial = load_trial(write_columns({**columns, **wind}, tmp_path / "a.csv"), SHIP)

    assert trial.wind_starboard == pytest.approx(2.0)
    assert "N_ww" in model_of("mmg", wind=True).free


def repeated(columns: Columns) -> Columns:
    t = columns["t"].copy()
    t[7] = t[6]
    return {**columns, "t": t}


def gap(columns: Columns) -> Columns:
    n = columns["n"].copy()
    n[4] = math.nan
    return {**columns, "n": n}


def without(name: str) -> Callable[[Columns], Columns]:
    return lambda columns: {key: one for key, one in columns.items() if key != name}


def times(name: str, factor: float) -> Callable[[Columns], Columns]:
    return lambda columns: {**columns, name: factor * columns[name]}


BAD: dict[str, tuple[Callable[[Columns], Columns], str]] = {
    "no revolutions": (without("n"), r"no revolutions was recorded: .*slipstream.*\[\[columns\]\]"),
    "no speed": (without("u"), "no speed was recorded: the speed through the water"),
    "no sway": (without("v"), "no sway was recorded"),
    "no times": (without("t"), "no column of times: .*interval_s"),
    "the rudder's sign": (times("delta_r", -1.0), r'turns her to starboard .*"starboard"'),
    "revolutions per minute": (times("n", 60.0), r"row 2: the propeller advances J = .*rpm"),
    "degrees": (times("r", 180.0 / math.pi), r'unit = "deg/s"'),
    "a time that repeats": (repeated, r"row 9: t = 12 s is repeated"),
}


def test_a_gap_of_an_input_is_gone_straight_across_and_told(
    columns: Columns, tmp_path: Path
) -> None:
    path = write_columns(gap(columns), tmp_path / "gap.csv")
    record = load_trial(path, SHIP)
    assert np.isfinite(record.column("revolutions")).all()
    assert any("n: has no reading for 4 s, one each 2 s else" in str(f) for f in record.findings)


@pytest.mark.parametrize("name", BAD)
def test_a_bad_record_is_refused_with_its_remedy(
    name: str, columns: Columns, tmp_path: Path
) -> None:
    change, told = BAD[name]
    path = write_columns(change(columns), tmp_path / "bad.csv")

    with pytest.raises(ConfigError, match=told) as wrong:
        load_trial(path, SHIP)
    assert "bad.csv" in str(wrong.value)


def test_a_length_in_feet_is_asked_after() -> None:
    text = ship_text(SHIP, "").replace("length_m = 320.0", "length_m = 1049.9")

    with pytest.raises(
        ConfigError, match=r"length_m = 1049.9: must be 0.1 to 500 m; is it in feet"
    ):
        parse_ship(text, Path("ship.toml"))


def test_a_wrong_key_of_a_ship_file_is_named_with_the_nearest() -> None:
    with pytest.raises(ConfigError, match=r"ship.toml: \[dimensions\] beem_m .*beam_m"):
        parse_ship(ship_text(SHIP, "").replace("beam_m", "beem_m"), Path("ship.toml"))
    with pytest.raises(ConfigError, match=r"sensor = .*no such key; nearest is sensors"):
        parse_ship("sensor = 1\n" + ship_text(SHIP, ""), Path("ship.toml"))


@pytest.mark.parametrize(
    ("wrong", "told"),
    [
        ("coefficients = 1", r"ship.toml"),
        ("[coefficients]\nN_F = 'much'", r"\[coefficients\] N_F"),
        ("[coefficients]\nN_F = 1\n[covariance]\nN_v = [1.0]", r"N_v is no coefficient"),
        ("[coefficients]\nN_F = 1\n[covariance]\nN_F = [1.0, 2.0]", r"\[covariance\] N_F"),
    ],
)
def test_a_wrong_result_is_refused_by_name(wrong: str, told: str) -> None:
    top = "" if wrong.startswith("[") else f"{wrong}\n"
    whole = ship_text(SHIP, "").replace('schema = "ship/1"\n', f'schema = "ship/1"\n{top}')
    whole += '[result]\nmodel = "mmg"\nspeed_kn = 15\nrevolutions_per_s = 1\n'
    with pytest.raises(ConfigError, match=told):
        parse_ship(whole + ("" if top else wrong), Path("ship.toml"))


@pytest.fixture
def known() -> ShipFile:
    """Return the tanker as a fit would have written it, with an uncertain rudder."""
    whole = {name: COEFFICIENTS.get(name, 0.0) for name in model_of("mmg", wind=False).names}
    return replace(
        SHIP,
        result=Fitted(model="mmg", speed_kn=15.0, revolutions_per_s=1.4),
        coefficients=whole,
        uncertain=("N_F", "Y_F"),
        covariance=((0.0016, -0.0003), (-0.0003, 0.0001)),
        ranges={"rudder": (-0.2, 0.2), "speed": (4.0, 8.0)},
    )


def test_a_ship_file_says_again_what_it_said(known: ShipFile) -> None:
    known = replace(known, name='an "old" tanker\\')
    again = parse_ship(ship_text(known, 'of "a" test'), Path("ship.toml"))

    assert again.name == known.name
    assert again.coefficients == known.coefficients
    assert again.covariance == known.covariance
    assert (again.dimensions, again.result) == (known.dimensions, known.result)
    assert again.ranges == {"rudder": (-0.2, 0.2), "speed": (4.0, 8.0)}


def test_a_ship_begins_in_steady_straight_motion(known: ShipFile) -> None:
    ship = IdentifiedShip(known)
    ship.start(15.0 * KNOT)
    for _ in range(200):
        ship.advance()
    _, u, _, r, _, _, psi, _, _ = ship.observe()

    assert u == pytest.approx(15.0 * KNOT, rel=1e-6)
    assert abs(r) < 1e-9
    assert abs(psi) < 1e-6


def test_a_symmetric_ship_turns_alike_to_both_sides(known: ShipFile) -> None:
    even = {**known.coefficients, "Y_0": 0.0, "N_0": 0.0}
    ship = IdentifiedShip(replace(known, coefficients=even))
    turns = [
        fly_manoeuvre(ship, Turn(angle_deg=35.0, duration_s=400.0, side=side), 7.0)
        for side in (STARBOARD, PORT)
    ]

    assert turns[0].column("y") == pytest.approx(-turns[1].column("y"), abs=1e-6)
    assert turns[0].column("psi")[-1] > math.pi


def test_a_speed_that_nothing_holds_is_refused(known: ShipFile) -> None:
    with pytest.raises(ConfigError, match=r"nothing holds it straight at 15 kn"):
        IdentifiedShip(replace(known, coefficients={**known.coefficients, "X_T": -1.0})).start(
            15.0 * KNOT
        )


def test_a_file_without_a_result_cannot_sail() -> None:
    with pytest.raises(ConfigError, match=r"ship.toml: lacks \[result\]"):
        IdentifiedShip(SHIP)


def test_ships_are_drawn_from_the_covariance(known: ShipFile) -> None:
    drawn = np.array(
        [[one.coefficients[name] for name in known.uncertain] for one in draw_ships(known, 4000)]
    )

    assert drawn.mean(axis=0) == pytest.approx([1.2, -0.2], abs=0.004)
    assert np.cov(drawn.T) == pytest.approx(np.array(known.covariance), rel=0.1, abs=2e-5)


def test_a_manoeuvre_says_its_band_and_what_is_beyond_the_records(
    known: ShipFile, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(vehicle, "MAX_DRAWS", 30)

    report, _ = fly_ship(known, "turning-circle", ManoeuvreOptions())

    band = {one.name: one for one in report.intervals}
    own = {one.name: one.value for one in report.measures}
    for name in ("advance", "tactical diameter", "steady diameter"):
        low, high, value = band[name].low, band[name].high, own[name]
        assert low is not None
        assert high is not None
        assert value is not None
        assert low < value < high
        assert high - low < 0.2 * value
    assert report.draws == 30
    assert any("the rudder goes from" in text for text in report.notices)
    assert "95 % of 30 ships" in vehicle.render(report)


SAMPLE = '[sample]\nplan = "{}"\nseed = 1\n'
STUDY = """schema = "sweep/1"
name = "turns"
vessel = "./found.toml"
measures = ["heading after 60 s"]
[manoeuvre]
name = "turning-circle"
duration_s = 80.0
"""
VARIED = '[[vary]]\nname = "{}"\nkey = "{}"\n{}\n'
DRAWN = VARIED.format("draw", "vessel", 'distribution = "estimate"')
DRAWS_20 = SAMPLE.format("monte-carlo") + "members = 20\n" + DRAWN


def test_a_study_draws_a_ship_by_the_covariance_of_its_file(
    known: ShipFile, tmp_path: Path
) -> None:
    whole = parse_study(STUDY + DRAWS_20.replace("20", "4000"), _beside(known, tmp_path))
    numbers = whole.draws.drawn(0, 4000)["draw"]
    drawn = [whole.varied({"draw": one})["vessel"]["coefficients"] for one in numbers]
    pairs = np.array([[one[name] for name in known.uncertain] for one in drawn])

    assert pairs.mean(axis=0) == pytest.approx([1.2, -0.2], abs=0.004)
    assert np.cov(pairs.T) == pytest.approx(np.array(known.covariance), rel=0.1, abs=2e-5)
    assert all(one["N_v"] == known.coefficients["N_v"] for one in drawn)
    assert whole.varied({"draw": 0})["vessel"]["coefficients"] == known.coefficients


def _beside(ship: ShipFile, folder: Path) -> Path:
    """Return the path of a study, with the ship's file beside it."""
    (folder / "found.toml").write_text(ship_text(ship, ""), encoding="utf-8")
    return folder / "study.toml"


def test_a_member_is_the_ship_sailed_alone(known: ShipFile, tmp_path: Path) -> None:
    path = _beside(known, tmp_path)
    rate = VARIED.format("rate", "vessel.dimensions.rudder_rate_deg_s", "values = [1.0, 3.0]")
    study = parse_study(STUDY + SAMPLE.format("grid") + rate, path)
    slow, fast = subject_of(study).batch(0, 2).outputs[:, 0]

    hull = replace(known.dimensions, rudder_rate_deg_s=3.0)
    ship = IdentifiedShip(replace(known, dimensions=hull))
    turn = adjust_manoeuvre("turning-circle", ship, {"duration": 80.0})
    flight = fly_manoeuvre(ship, turn, 15.0 * KNOT)
    alone = {one.name: one.value for one in turn.measures(flight)}

    assert fast == alone["heading after 60 s"]
    assert slow < 0.99 * fast


@pytest.mark.parametrize(
    ("there", "instead", "said"),
    [
        ("duration_s", 'law = "report"\nduration_s', 'law = "report": is for boats, not for'),
        ("[manoeuvre]", '[method]\ntrig = "exact"\n[manoeuvre]', "is for boats, not for ships"),
        ('"turning-circle"', '"crash-stop"', "engine"),
        ("./found.toml", "./unsure.toml", "lacks the table [covariance]"),
        ("./found.toml", "./torn.toml", "covariance: must be 2 rows of 2 numbers, symmetric"),
        ('"vessel"', '"vessel.coefficients"', "must be vessel: an estimate is drawn whole"),
    ],
)
def test_a_study_that_no_ship_can_sail_is_refused(
    known: ShipFile, tmp_path: Path, there: str, instead: str, said: str
) -> None:
    path, text = _beside(known, tmp_path), ship_text(known, "")
    (tmp_path / "unsure.toml").write_text(text.split("\n[covariance]")[0], encoding="utf-8")
    (tmp_path / "torn.toml").write_text(text.replace("Y_F = [-0.0003", "Y_F = [-0.3"), "utf-8")
    wrong = (STUDY + DRAWS_20).replace(there, instead, 1)

    with pytest.raises(ConfigError) as refused:
        subject_of(parse_study(wrong, path))

    assert said in str(refused.value)


def asked(*words: str) -> Result:
    return CliRunner().invoke(cli, words)


def test_what_the_models_do_not_know_is_refused(columns: Columns, tmp_path: Path) -> None:
    record, ship = str(write_columns(columns, tmp_path / "a.csv")), str(tmp_path / "ship.toml")
    Path(ship).write_text(ship_text(SHIP, ""), encoding="utf-8")

    answers = {
        "needs --ship": asked("identify", record, "--model", "mmg"),
        "noise": asked(
            "identify", record, "--model", "mmg", "--ship", ship, "--noise", "covariance"
        ),
        r"lacks [result]": asked("manoeuvre", "zigzag-20", ship),
    }

    assert all(one.exit_code != 0 for one in answers.values())
    for words, one in answers.items():
        assert words in one.output + str(one.exception), words


def test_a_fit_has_a_page_of_its_own_in_which_markup_is_text(
    columns: Columns, tmp_path: Path
) -> None:
    record, ship = str(write_columns(columns, tmp_path / "a.csv")), tmp_path / "ship.toml"
    ship.write_text(ship_text(replace(SHIP, name="<b>tanker</b> & co"), ""), encoding="utf-8")
    page, command = tmp_path / "fit.html", ("identify", record, "--model", "linear")
    more = ("--ship", str(ship), "--predict", record, "--html", str(page), "--json")

    answer = asked(*command, *more)
    text = page.read_text(encoding="utf-8")
    data = re.search(r'<script type="application/json" id="identified">(.*?)</script>', text)

    assert data
    assert json.loads(data[1]) == json.loads(answer.stdout)
    assert "&lt;b&gt;tanker&lt;/b&gt; &amp; co" in text
    assert "<b>" not in text.replace(data[0], "")
    screens = re.findall(r"<h2>(.*?)</h2>", text)
    assert screens[:3] == ["Record", "Numbers", "Held back"]
    assert len(screens) == 3 + 3  # v', r', rudder
    assert text.count("<figure>") == 2 * 4 + 3 * 3
    assert "What the record cannot tell" in text


def test_a_fit_that_has_no_slope_answers_null_and_says_why(
    columns: Columns, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    record, ship = str(write_columns(columns, tmp_path / "a.csv")), tmp_path / "ship.toml"
    ship.write_text(ship_text(SHIP, ""), encoding="utf-8")
    own = ShipProblem.slope

    def no_slope(problem: ShipProblem, a: Numbers) -> tuple[float, Numbers]:
        cost, gradient = own(problem, a)
        return cost, math.nan * gradient

    monkeypatch.setattr(ShipProblem, "slope", no_slope)
    words = ("identify", record, "--model", "linear", "--ship", str(ship))
    page, answer = asked(*words), asked(*words, "--json")

    def refuse(name: str) -> None:
        raise AssertionError(name)

    told = json.loads(answer.stdout, parse_constant=refuse)
    assert (page.exit_code, answer.exit_code) == (1, 1)
    assert told["promise"] is None
    assert "impossible beside it" in told["doubt"]
    assert all(one["deviation"] is None for one in told["coefficients"])
    assert "DID NOT SETTLE" in page.stdout
    assert "impossible beside it: intervals do not hold" in page.stdout


def test_the_python_face_sends_to_the_command(columns: Columns, tmp_path: Path) -> None:
    record = write_columns(columns, tmp_path / "a.csv")

    with pytest.raises(ConfigError, match="model mmg: is fitted by the command"):
        trainer.identify_ship(record, model="mmg", length=320.0)


def blocks(kind: str) -> list[str]:
    """Return the blocks of a kind on the page."""
    return re.findall(rf"```{kind}\n(.*?)```", PAGE, re.DOTALL)


@pytest.mark.slow
def test_the_page_leads_from_a_record_to_a_turning_circle(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(vehicle, "MAX_DRAWS", 30)
    ship, known_ship, bands = blocks("toml")[:3]
    Path("ship.toml").write_text(ship, encoding="utf-8")
    Path("known.toml").write_text(known_ship, encoding="utf-8")
    Path("bands.toml").write_text(bands, encoding="utf-8")
    lines = [line.removeprefix("$ ") for line in blocks("console")[0].splitlines()]

    answers = [asked(*shlex.split(line)[1:]) for line in lines]
    told = asked("manoeuvre", "turning-circle", "known.toml", "--json")

    assert [one.exit_code for one in answers] == [0] * 4, [one.output for one in answers]
    assert "settled in" in answers[2].output
    assert "What the record cannot tell" in answers[2].output
    assert re.search(r"zz10.csv +held back +\S+ +\S+ +(99|100)\.\d", answers[2].output)
    found = load_ship(Path("found.toml"))
    assert found.coefficients["N_F"] == pytest.approx(1.2, abs=0.1)
    (begin,) = (one for one in blocks("console") if "identify new" in one)
    begun = asked(*shlex.split(begin.removeprefix("$ trainer ")))
    assert begun.exit_code == 0, begun.output
    assert "length_m = 320 " in Path("mine.toml").read_text(encoding="utf-8")
    sweep = shlex.split(blocks("console")[1].removeprefix("$ trainer "))
    spread = json.loads(asked(*sweep, "--members", "12", "--jobs", "1", "--json").stdout)
    assert spread["troubled"] == 0
    assert spread["effects"] == {name: [] for name in spread["effects"]}  # a draw is no scale
    truth = {one["name"]: one["value"] for one in json.loads(told.stdout)["measures"]}
    row = re.search(r"  advance +([\d.]+) +([\d.]+) +m", answers[3].output)
    assert row
    assert float(row[1]) - 15.0 < truth["advance"] < float(row[2]) + 15.0
    assert spread["spreads"][0]["name"] == "advance"
    assert float(row[1]) < spread["spreads"][0]["mean"] < float(row[2])


def test_a_record_of_another_ship_is_not_fitted_with_it(
    columns: Columns, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(
        ships, "COEFFICIENTS", {**COEFFICIENTS, "N_F": 0.3, "N_v": -1.0, "N_r": -4.0}
    )
    strange = trainer_columns(sailed_zigzag(20.0, seed=2)[0])
    first = str(write_columns(columns, tmp_path / "a.csv"))
    second = str(write_columns(strange, tmp_path / "b.csv"))
    (tmp_path / "ship.toml").write_text(ship_text(SHIP, ""), encoding="utf-8")

    answer = asked(
        *("identify", first, second, "--model", "mmg", "--ship", str(tmp_path / "ship.toml"))
    )

    assert answer.exit_code != 0
    assert re.search(r"[ab]\.csv: row 1 on: .*another ship.*one by one", repr(answer.exception))
