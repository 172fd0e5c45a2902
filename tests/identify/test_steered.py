"""A Nomoto ship sails: steady turns, time constants, manoeuvres, and its file."""

import json
import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cases.reference_ships import TANKER
from click.testing import CliRunner
from helpers.places import DATA, ROOT

from trainer.analysis.manoeuvres.catalogue import find_manoeuvre
from trainer.analysis.manoeuvres.flight import fly_manoeuvre
from trainer.analysis.manoeuvres.nomoto_ship import NomotoShip
from trainer.analysis.manoeuvres.vehicle import LostError
from trainer.analysis.manoeuvres.zigzag import ZigZag
from trainer.cli.workshop.guide import manoeuvre
from trainer.cli.workshop.identify import identify, steering
from trainer.config.boat.vessel import load_vessel
from trainer.config.files import ConfigError
from trainer.config.ship.nomoto import NomotoFile, is_nomoto, load_nomoto, nomoto_text_of
from trainer.identify.fitting.nonlinear import BentShip
from trainer.identify.model.derived import arms_of, nomoto_of
from trainer.identify.model.models import MODELS
from trainer.identify.model.nomoto import find_steering as steering_of
from trainer.identify.pages.steering import of_nomoto, panels
from trainer.units import DEGREE, KNOT

SPEED = 10.0 * KNOT
PAGE = (ROOT / "docs" / "steering.md").read_text(encoding="utf-8")
PUBLISHED = json.loads((DATA / "identification" / "published_tables.json").read_text())
SIZES = {one["ship"]: (one["L"], one["V_kn"]) for one in PUBLISHED["dimensional"]["ships"]}


def nomoto_file(**changes: Any) -> Any:
    numbers = {
        "schema": "nomoto/1",
        "name": "a ship",
        "length_m": 100.0,
        "speed_kn": 10.0,
        "K_per_s": -0.05,
        "T1_s": 30.0,
        "T2_s": 5.0,
        "T3_s": 8.0,
        "rudder_limit_deg": 35.0,
        "rudder_rate_deg_s": 1e3,
        "step_s": 0.5,
    }
    return NomotoFile(**{**numbers, **changes})


def steered(ship: NomotoShip, rudder: float, ticks: int) -> dict[str, float]:
    """Return what a ship shows after so many ticks with a rudder [rad]."""
    ship.start(SPEED)
    ship.order("rudder", rudder)
    for _ in range(ticks):
        ship.advance()
    return dict(zip(ship.columns, ship.observe(), strict=True))


def test_a_nomoto_ship_turns_at_its_gain_after_long() -> None:
    ship = NomotoShip(nomoto_file(K_v_m_s=2.0, T3v_s=3.0))
    seen = steered(ship, math.radians(10.0), 1200)
    # starboard rudder is negative: r = K delta, v = K_v delta
    assert seen["r"] == pytest.approx(0.05 * math.radians(10.0), rel=1e-6)
    assert seen["v"] == pytest.approx(-2.0 * math.radians(10.0), rel=1e-6)
    assert seen["t"] == 600.0


@pytest.mark.parametrize("second", [{}, {"T2_s": 0.0, "T3_s": 0.0}])
def test_a_bent_ship_turns_as_its_steady_equation_says(second: Any) -> None:
    # r - kappa K |r| r = K delta with K = -0.05, kappa = 400, delta = -0.2: r + 20 r^2 = 0.01
    ship = NomotoShip(nomoto_file(kappa_s2=400.0, **second))
    seen = steered(ship, 0.2, 2000)
    r = (-1.0 + math.sqrt(1.0 + 4.0 * 20.0 * 0.01)) / 40.0
    assert seen["r"] == pytest.approx(r, rel=1e-9)


def test_a_ship_with_bech_s_curve_turns_as_its_steady_helm_says() -> None:
    curve = {"H1_s": 9.0, "H2_s2": -700.0, "H3_s3": -4e4}
    ship = NomotoShip(nomoto_file(K_per_s=0.11, T1_s=-300.0, T2_s=13.0, T3_s=33.0, **curve))
    seen = steered(ship, -0.3, 4000)  # to port
    r = seen["r"]
    assert 9.0 * r - 700.0 * abs(r) * r - 4e4 * r**3 == pytest.approx(0.3, rel=1e-6)
    assert r < 0.0


def test_a_first_order_ship_follows_its_exponential() -> None:
    ship = NomotoShip(nomoto_file(T2_s=0.0, T3_s=0.0, rudder_rate_deg_s=1000.0))
    seen = steered(ship, 0.1, 60)
    # after T1 = 30 s, less the step in which the rudder moves
    rate = seen["r"]
    assert rate == pytest.approx(0.05 * 0.1 * (1.0 - math.exp(-1.0)), rel=0.02)


def test_a_nomoto_ship_flies_a_zigzag_like_any_vehicle() -> None:
    flight = fly_manoeuvre(
        NomotoShip(nomoto_file()), ZigZag(angle_deg=10.0, execute_deg=10.0), SPEED
    )
    assert len([mark for mark in flight.marks if mark.name == "execute"]) > 2
    assert flight.lost == ""


def test_an_unstable_ship_is_lost_and_another_speed_refused() -> None:
    ship = NomotoShip(nomoto_file(T1_s=-5.0, K_per_s=0.05))
    with pytest.raises(LostError, match="spins"):
        steered(ship, 0.3, 2000)
    with pytest.raises(ConfigError, match="identified at 10 kn, not at 15 kn"):
        ship.start(15.0 * KNOT)


def test_a_nomoto_file_is_read_as_it_was_written(tmp_path: Path) -> None:
    ship = nomoto_file(kappa_s2=120.0, K_per_s=-0.0512345)
    path = tmp_path / "ship.toml"
    path.write_text(nomoto_text_of(ship, "model nomoto2 fitted to x.csv", {"K": 0.001}))
    assert load_nomoto(path) == ship
    assert is_nomoto(path)
    path.write_text(path.read_text().replace("T1_s", "T1"))
    with pytest.raises(ConfigError, match=r"no such key; nearest is T1_s"):
        load_nomoto(path)


@pytest.mark.parametrize(
    ("lines", "told"),
    [
        ("H3_s3 = 5", "H3_s3 = 5.0: goes with H1_s, which is not given"),
        ("H1_s = 5\nkappa_s2 = 9", "kappa_s2 = 9.0: stands in for H1_s: give one"),
    ],
)
def test_half_a_curve_or_two_are_refused(tmp_path: Path, lines: str, told: str) -> None:
    path = tmp_path / "ship.toml"
    text = nomoto_text_of(nomoto_file(), "x", {})
    path.write_text(text.replace("K_per_s", f"{lines}\nK_per_s"))
    with pytest.raises(ConfigError, match=re.escape(told)):
        load_nomoto(path)


def sailed(tmp_path: Path, *arguments: Any) -> Any:
    path = tmp_path / "ship.toml"
    path.write_text(nomoto_text_of(nomoto_file(), "model nomoto2 fitted to x.csv", {}))
    name, *options = arguments
    return CliRunner().invoke(manoeuvre, [name, str(path), *options])


def test_the_file_of_an_identified_ship_flies_a_manoeuvre(tmp_path: Path) -> None:
    result = sailed(tmp_path, "zigzag-10", "--json", "--step", "0.25")
    report = json.loads(result.stdout)
    measures = {one["name"]: one["value"] for one in report["measures"]}
    flight = fly_manoeuvre(NomotoShip(nomoto_file(step_s=0.25)), find_manoeuvre("zigzag-10"), SPEED)
    assert report["speed_kn"] == pytest.approx(10.0)
    assert measures["heading peak 1"] == pytest.approx(
        next(
            one.value
            for one in find_manoeuvre("zigzag-10").measures(flight)
            if "peak 1" in one.name
        )
    )
    assert "a ship: zigzag-10" in sailed(tmp_path, "zigzag-10").stdout


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (("zigzag-10", "--equations", "basic"), "--equations are for boats"),
        (("crash-stop",), "needs a control 'engine'"),
        (("rudder-impulse",), "is measured by phi"),
        (("turn", "--speed", "20"), "was identified at 10 kn, not at 20 kn"),
    ],
)
def test_what_a_nomoto_ship_cannot_do_is_told(tmp_path: Path, arguments: Any, told: Any) -> None:
    result = sailed(tmp_path, *arguments)
    assert result.exit_code != 0
    assert told in f"{result.exception} {result.output}"


def test_a_plot_of_a_nomoto_ship_leaves_out_what_she_has_not(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    plot = tmp_path / "z.svg"
    assert sailed(tmp_path, "zigzag-10", "--plot", str(plot)).exit_code == 0
    assert plot.stat().st_size > 0


def steering_of_file(path: Path, *more: str) -> Any:
    """Return the report of ``trainer ship steering`` about a file."""
    words = [str(path), *more, "--json"]
    return json.loads(CliRunner().invoke(steering, words, catch_exceptions=False).stdout)


def fernstrom(folder: Path) -> Path:
    """Write the page's file of A K Fernstrom, unstable, section 8; return its path."""
    path = folder / "fernstrom.toml"
    path.write_text(re.findall(r"```toml\n(.*?)```", PAGE, re.DOTALL)[0])
    return path


def flown(name: str, path: Path) -> dict[str, float]:
    result = CliRunner().invoke(manoeuvre, [name, str(path), "--json"], catch_exceptions=False)
    return {one["name"]: one["value"] for one in json.loads(result.stdout)["measures"]}


@pytest.mark.long
def test_the_spiral_of_an_unstable_ship_has_the_loop_of_its_kappa(tmp_path: Path) -> None:
    path = fernstrom(tmp_path)
    at = steering_of_file(path)["speeds"][0]
    rate, fold_rate, fold = at["loop"]
    # by hand: 1/(1230 0.114), half of it, and 1/(4 1230 0.114^2)
    assert (rate * DEGREE, fold_rate * DEGREE) == pytest.approx((0.0071317, 0.0035658), rel=1e-4)
    assert fold * DEGREE == pytest.approx(0.0156396, rel=1e-4)
    assert at["turns_deg_s"][0] == pytest.approx([-rate, 0.0, rate])
    assert not at["stable"]

    direct = flown("spiral", path)
    assert direct["yaw rate at +0 deg"] / DEGREE == pytest.approx(rate, rel=0.03)
    assert direct["width of the loop"] / DEGREE == pytest.approx(2.0 * rate, rel=0.03)
    reverse = flown("reverse-spiral", path)
    bent = BentShip(0.114, -304.0, 13.4, 33.4, 1230.0)
    for share in ("67 %", "33 %", "17 %", "-17 %", "-33 %", "-67 %"):
        (held,) = bent.helm(np.array([reverse[f"yaw rate at {share}"]]))
        assert reverse[f"rudder at {share}"] == pytest.approx(-held, abs=0.1 * DEGREE)
    assert reverse["rudder at 17 %"] < 0.0 < reverse["rudder at 67 %"]  # it must be held back


def test_the_page_shows_what_the_command_prints(tmp_path: Path) -> None:
    shown = re.findall(r"trainer ship steering fernstrom.toml\n(.*?)```", PAGE, re.DOTALL)[0]
    assert shown in CliRunner().invoke(steering, [str(fernstrom(tmp_path))]).stdout


@pytest.mark.long
def test_the_spiral_is_drawn_with_its_fold(tmp_path: Path) -> None:
    (panel,) = panels(of_nomoto(fernstrom(tmp_path)))
    (curve,) = panel.curves
    starboard = curve.y > 0.0
    assert curve.x[starboard].max() == pytest.approx(0.8961, rel=1e-3)  # port rudder, and yet
    arguments = ["spiral", str(tmp_path / "fernstrom.toml"), "--plot", str(tmp_path / "s.svg")]
    assert CliRunner().invoke(manoeuvre, arguments).exit_code == 0
    assert "steady turns" in (tmp_path / "s.svg").read_text()


def test_lever_arms_give_the_gains_of_their_table() -> None:
    """The table of lever arms of section 2.4 as MI 3.4 re-derives it."""
    ship = steering_of(load_vessel("bb2"), SPEED)
    l_v, l_r, l_delta, margin = ship.levers
    (Y_v, Y_r), Y_delta = ship.F[0], ship.g[0]
    assert pytest.approx(Y_delta * (l_delta - l_v) / (-Y_r * margin)) == ship.nomoto.K
    assert ship.nomoto.K_v == pytest.approx(Y_delta * (l_delta - l_r) / (Y_v * margin))
    assert (margin > 0.0) == ship.nomoto.stable


def test_lever_arms_of_a_fit_are_those_of_its_derivatives() -> None:
    model, truth = MODELS["1"], TANKER.truth
    values = model.vector(**truth)
    arms = arms_of(model, values, TANKER.ship)
    # Sea Splendour, 329 m: N_v/Y_v, N_r/Y_r, -0.065/0.199
    by_hand = [329.0 * 0.183 / 1.59, 329.0 * 0.125 / 0.616, -329.0 * 0.065 / 0.199]
    assert arms == pytest.approx([*by_hand, by_hand[1] - by_hand[0]])
    assert (arms[3] > 0.0) == nomoto_of(model, values, TANKER.ship).stable


def test_a_boat_has_lever_arms_at_each_speed_and_a_nomoto_ship_one_speed(tmp_path: Path) -> None:
    page = CliRunner().invoke(steering, ["bb2", "--speed", "5", "--speed", "10"]).stdout
    assert page.count("straight course stable, l_r - l_v = ") == 2
    refused = CliRunner().invoke(steering, [str(fernstrom(tmp_path)), "--speed", "5"])
    assert refused.exit_code == 2
    assert "--speed is for boats" in refused.output


def tabled(folder: Path, row: Any) -> tuple[Path, float, float]:
    """Write a column of the report's tables as a file; return its path, length and knots."""
    length, knots = next(SIZES[ship] for ship in SIZES if row["case"].startswith(ship))
    (m11, m12), (m21, m22) = row["M"]
    (Y_v, Y_r), (N_v, N_r) = row["F"]
    Y_delta, N_delta = row["g"]
    entries = {"m11": m11, "m12": m12, "m21": m21, "m22": m22, "Y_v": Y_v, "Y_r": Y_r}
    entries |= {"N_v": N_v, "N_r": N_r, "Y_delta": Y_delta, "N_delta": N_delta}
    heads = [f'schema = "derivatives/1"\nname = "{row["case"]}"']
    lines = {"length_m": length, "speed_kn": knots, **entries}.items()
    path = folder / "ship.toml"
    path.write_text("\n".join([*heads, *(f"{name} = {value}" for name, value in lines)]))
    return path, length, knots * KNOT


@pytest.mark.parametrize("row", PUBLISHED["rows"], ids=lambda row: f"{row['case']} {row['system']}")
def test_a_table_of_derivatives_gives_the_gains_printed_beside_it(row: Any, tmp_path: Path) -> None:
    """Tables 8.1, 9.1 and 10.2 give 9.2 and 10.3, within what the digits printed leave open."""
    path, L, V = tabled(tmp_path, row)
    numbers = steering_of_file(path)["speeds"][0]["numbers"]
    units = {"K": V / L, "Kv": V}
    compared = 0
    for name, told in row["comparison"].items():
        prime = numbers[{"Kv": "K_v"}.get(name, name)] / units.get(name, L / V)
        assert prime == pytest.approx(row["computed"][name], rel=1e-9)
        low, high = told["range_from_rounding"]
        found = prime if told["compared_as"] == "value" else 1.0 / prime
        printed = float(told["published"])
        if told["consistent_with_rounding"]:
            assert low <= found <= high
            compared += 1
        if told["compared_as"] == "value":
            assert printed == pytest.approx(prime, rel=0.06)
    assert compared >= 3


def test_sea_splendour_has_the_gains_of_table_9_2_in_seconds(tmp_path: Path) -> None:
    """K -0.018 1/s, K_v 3.8 m/s, T1 92.5 s at first, 155.6 s at last, whatever the system."""
    for system in ("prime", "bis"):
        for state, printed in (
            ("initial", {"K": -0.018, "K_v": 3.8, "T1": 92.5}),
            ("final", {"T1": 155.6}),
        ):
            case = (f"Sea Splendour {state}", system)
            row = next(one for one in PUBLISHED["rows"] if (one["case"], one["system"]) == case)
            path, *_ = tabled(tmp_path, row)
            page = CliRunner().invoke(steering, [str(path)], catch_exceptions=False).stdout
            found = {one[0]: float(one[2]) for one in map(str.split, page.splitlines()[5:11])}
            for name, value in printed.items():
                assert found[name] == pytest.approx(value, rel=0.02)


def test_the_page_shows_what_a_table_of_derivatives_gives(tmp_path: Path) -> None:
    text = next(one for one in re.findall(r"```toml\n(.*?)```", PAGE, re.DOTALL) if "m11" in one)
    path = tmp_path / "splendour.toml"
    path.write_text(text)
    shown = re.findall(r"trainer ship steering splendour.toml\n(.*?)```", PAGE, re.DOTALL)[0]
    assert shown in CliRunner().invoke(steering, [str(path)]).stdout


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (("derivatives/1", "derivatives/2"), 'must be "nomoto/1" or "derivatives/1"; nearest is'),
        (("m22", "m_22"), "m_22 = 0.105: no such key; nearest is m22"),
        (("m22 = 0.105", "m22 = 0"), "m11 m22 = m12 m21: a ship without mass"),
        (("_delta = 0.199", "_delta = 0"), "turn the ship to neither side"),
    ],
)
def test_a_table_that_is_no_ship_is_refused(change: Any, told: str, tmp_path: Path) -> None:
    text = next(one for one in re.findall(r"```toml\n(.*?)```", PAGE, re.DOTALL) if "m11" in one)
    text = text.replace(*change)
    if "_delta" in change[0]:
        text = text.replace("N_delta = -0.065", "N_delta = 0")
    path = tmp_path / "ship.toml"
    path.write_text(text)
    with pytest.raises(ConfigError, match=re.escape(told)):
        CliRunner().invoke(steering, [str(path)], catch_exceptions=False)


SPLENDOUR = {"K": -1.63, "T1": 3.87, "T2": 0.54, "T3": 0.79}  # Table 9.2, prime
SONG = {"K": -2.38, "T1": 8.32, "T2": 1.11, "T3": 4.61}  # Table 6.2, prime


def printed_ship(folder: Path, name: str, prime: dict[str, float]) -> Path:
    """Write a Nomoto file of a ship of the report by its prime numbers; return its path."""
    length, knots = SIZES[name]
    time = length / (knots * KNOT)
    numbers = {f"{key}_s": value * time for key, value in prime.items() if key != "K"}
    sizes = {"length_m": length, "speed_kn": knots, "rudder_rate_deg_s": 2.5}
    ship = nomoto_file(**numbers, **sizes, name=name, K_per_s=prime["K"] / time)
    path = folder / f"{name.rsplit(maxsplit=1)[-1]}.toml"
    path.write_text(nomoto_text_of(ship, "the report of 1974", {}))
    return path


def by_old_methods(path: Path, manoeuvre_name: str, *arguments: str) -> dict[Any, Any]:
    """Fly a manoeuvre, and return what ``trainer ship steering --record`` finds in it."""
    record = path.with_suffix(".csv")
    flight = [manoeuvre_name, str(path), "--csv", str(record), *arguments]
    CliRunner().invoke(manoeuvre, flight, catch_exceptions=False)
    return recorded(path, record)


def recorded(path: Path, record: Path) -> dict[Any, Any]:
    found = steering_of_file(path, "--record", str(record))["recorded"]
    return {(one["method"], one["name"]): one for one in found}


def test_a_turn_of_sea_splendour_has_the_gain_and_lag_of_table_9_2(tmp_path: Path) -> None:
    """The effective K' and T' = T1' + T2' - T3' of a linear ship are those of small helm."""
    path = printed_ship(tmp_path, "Sea Splendour", SPLENDOUR)
    found = by_old_methods(path, "turning-circle", "--duration", "1500")
    gain, lag = found["effective", "K"], found["effective", "T"]
    assert gain["prime"] == pytest.approx(-1.63, abs=0.005)
    assert lag["prime"] == pytest.approx(3.87 + 0.54 - 0.79, abs=0.01)
    assert gain["ship"] == pytest.approx(gain["value"], rel=1e-3)


def test_a_turn_of_an_unstable_ship_has_the_gain_of_its_bend(tmp_path: Path) -> None:
    path = fernstrom(tmp_path)
    gain = by_old_methods(path, "turning-circle", "--angle", "20")["effective", "K"]
    (rate,) = BentShip(0.114, -304.0, 13.4, 33.4, 1230.0).rates(20.0 * DEGREE)
    assert gain["value"] == pytest.approx(rate / (20.0 * DEGREE), rel=1e-3)
    assert gain["value"] < 0.0 < gain["ship"]


def test_the_gain_of_a_turn_that_loses_speed_is_length_over_radius(tmp_path: Path) -> None:
    record = tmp_path / "turn.csv"
    flight = ["turning-circle", "bb2", "--speed", "10", "--csv", str(record), "--json"]
    report = json.loads(CliRunner().invoke(manoeuvre, flight, catch_exceptions=False).stdout)
    diameter = next(one for one in report["measures"] if one["name"] == "steady diameter")["value"]
    asked = ["bb2", "--speed", "10", "--record", str(record), "--json"]
    found = json.loads(CliRunner().invoke(steering, asked, catch_exceptions=False).stdout)
    (gain, _), length = found["recorded"], found["length_m"]
    held = np.loadtxt(record, delimiter=",", skiprows=1)[-1]
    names = record.read_text().split("\n", 1)[0].split(",")
    rudder = held[names.index("delta_r")]
    assert gain["prime"] == pytest.approx(2.0 * length / diameter / rudder, rel=0.02)
    assert abs(gain["value"]) < abs(gain["prime"]) * 10.0 * KNOT / length  # by its rate alone


def test_nomoto_s_method_finds_the_first_order_ship_that_the_report_found(tmp_path: Path) -> None:
    """Section 8: K -0.08 1/s and T 148.3 s of a ship that is not stable."""
    found = by_old_methods(fernstrom(tmp_path), "zigzag-20", "--duration", "1500")
    assert found["Nomoto's", "K"]["value"] == pytest.approx(-0.08, abs=0.005)
    assert found["Nomoto's", "T"]["value"] == pytest.approx(148.3, abs=3.0)


@pytest.mark.parametrize("name", ["A K Fernstrom", "Sea Splendour"])
def test_the_phase_plot_of_a_zigzag_gives_the_time_constants_back(
    name: str, tmp_path: Path
) -> None:
    """T1', T2', T3' of Tables 8.1 (-9.1, 0.4, 1.0) and 9.2 (3.87, 0.54, 0.79)."""
    splendour = name == "Sea Splendour"
    path = printed_ship(tmp_path, name, SPLENDOUR) if splendour else fernstrom(tmp_path)
    found = by_old_methods(path, "zigzag-20", "--duration", "1500")
    printed = (3.87, 0.54, 0.79) if splendour else (-9.1, 0.4, 1.0)
    for constant, value in zip(("T1", "T2", "T3"), printed, strict=True):
        one = found["phase plot", constant]
        assert one["prime"] == pytest.approx(value, abs=0.01)
        assert one["value"] == pytest.approx(one["ship"], rel=0.01)


def test_nomoto_s_method_and_a_likelihood_find_one_ship(tmp_path: Path) -> None:
    """The method by hand is within a sixth of the likelihood's K and T of the same zig-zag."""
    pytest.importorskip("scipy")
    path = fernstrom(tmp_path)
    by_old_methods(path, "zigzag-20", "--duration", "1500")
    record, likely = path.with_suffix(".csv"), tmp_path / "likely.toml"
    wishes = ["--model", "nomoto1", "--length", "244", "--at", "14.2", "--every", "10"]
    fit = [str(record), *wishes, "--write-nomoto", str(likely), "--output", "yaw_rate"]
    CliRunner().invoke(identify, fit, catch_exceptions=False)
    found = recorded(likely, record)
    for name in ("K", "T"):
        one = found["Nomoto's", name]
        assert one["value"] == pytest.approx(one["ship"], rel=0.17)
        assert one["value"] != one["ship"]


def test_a_zigzag_of_two_swings_is_too_short(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="turning points: sail the zig-zag for longer"):
        by_old_methods(fernstrom(tmp_path), "zigzag-20", "--duration", "300")


def test_a_record_without_helm_is_refused(tmp_path: Path) -> None:
    record = tmp_path / "still.csv"
    rows = "".join(f"{t},0,0,{0.001 * t}\n" for t in range(40))
    record.write_text("t,delta_r,r,psi\n" + rows)
    with pytest.raises(ConfigError):
        recorded(fernstrom(tmp_path), record)


def test_the_third_order_model_has_the_numbers_of_table_6_2(tmp_path: Path) -> None:
    """Atlantic Song: K' -2.38, T' 8.32, 1.11 and 4.61 are K -0.115 1/s, T 172.3, 22.9, 95.5 s."""
    ship = printed_ship(tmp_path, "Atlantic Song", SONG)
    numbers = steering_of_file(ship)["speeds"][0]["numbers"]
    printed = {"K": (-0.115, 0.0005), "T1": (172.3, 0.15), "T2": (22.9, 0.1), "T3": (95.5, 0.1)}
    for name, (value, within) in printed.items():
        assert numbers[name] == pytest.approx(value, abs=within)
    found = by_old_methods(ship, "zigzag-10", "--duration", "1500")
    for name in ("T1", "T2", "T3"):
        assert found["phase plot", name]["prime"] == pytest.approx(SONG[name], rel=0.04)


def test_the_page_shows_what_the_old_methods_find(tmp_path: Path) -> None:
    path = fernstrom(tmp_path)
    by_old_methods(path, "zigzag-20", "--duration", "1500")
    shown = re.findall(
        r"trainer ship steering fernstrom.toml --record zz.csv\nof(.*?)```", PAGE, re.DOTALL
    )
    asked = [str(path), "--record", str(path.with_suffix(".csv"))]
    assert shown[0] in CliRunner().invoke(steering, asked).stdout
