"""Files of ships begun from records as model basins publish them."""

import math
from pathlib import Path

import numpy as np
import pytest
from helpers.ships import sailed_zigzag
from helpers.studies import answered

from trainer.config.ship.ship import load_ship
from trainer.core.kernel import Numbers
from trainer.identify.ships.records import inputs_of, load_trial, readings_of

DEGREE = math.pi / 180.0
FILLED = (  # what a user types in place of the lines to fill in
    ("# length_m = 320.0  # fill in:", "length_m = 320.0  #"),
    ("# propeller_diameter_m", "propeller_diameter_m"),
    ("# wake_fraction", "wake_fraction"),
    ("# thrust", "thrust"),
)


@pytest.fixture(scope="module")
def sailed() -> Numbers:
    """Return t, u, v, r, heading, rudder to starboard and revolutions of a 20/20, by rows."""
    trial, _ = sailed_zigzag(20.0, seed=1)
    return np.column_stack([trial.t, readings_of(trial), inputs_of(trial)[:, :2]])


def write(path: Path, heads: str, columns: list[Numbers], form: str = "%.17g") -> Path:
    np.savetxt(path, np.column_stack(columns), form, delimiter=",", header=heads, comments="")
    return path


def fill_in(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    for old, new in FILLED:
        assert text.count(old) == 1
        text = text.replace(old, new)
    path.write_text(text, encoding="utf-8")


def test_a_free_running_model_with_wind_is_read_by_the_file_begun(
    sailed: Numbers, tmp_path: Path
) -> None:
    t, u, v, r, psi, rudder, n = sailed.T
    heads = (
        "t [s],x_position_mid [m],u_velo [m/s],vm_velo [m/s],psi_hat [rad],r_angvelo [rad/s],"
        "n_prop [rps],delta_rudder [rad],wind_velo_relative_mid [m/s],"
        "wind_dir_relative_mid [rad],wind_velo_true [m/s],wind_dir_true [rad]"
    )
    wind, angle = 5.0 + 0.0 * t, 0.5 - psi
    columns = [t, 8.0 * t, u, v, psi, r, n, rudder, wind, angle, 9.0 * wind, 0.1 * angle]
    record = write(tmp_path / "model test.csv", heads, columns)
    ship = tmp_path / "ship.toml"

    said = answered("new", record, "--ship", ship).output
    fill_in(ship)
    trial = load_trial(record, load_ship(ship))

    assert "no column" not in said
    assert "taken for the relative wind" in said
    assert f"trainer identify '{record}' --model mmg --ship {ship}" in said
    assert load_ship(ship).records.positive_rudder == "starboard"
    assert trial.rudder == pytest.approx(-rudder)
    assert readings_of(trial) == pytest.approx(np.column_stack([u, v, r, psi]))
    assert trial.revolutions == pytest.approx(n)
    assert trial.wind_ahead == pytest.approx(5.0 * np.cos(angle))


def test_a_record_over_ground_in_degrees_with_rounded_times_is_read_by_the_file_begun(
    sailed: Numbers, tmp_path: Path
) -> None:
    t, u, v, r, psi, rudder, n = sailed.T
    north, east = u * np.cos(psi) - v * np.sin(psi), u * np.sin(psi) + v * np.cos(psi)
    fine = np.arange(0.0, t[-1], 0.5)
    columns = [
        np.interp(fine, t, one)
        for one in (t, psi / DEGREE, north, east, r / DEGREE, -rudder / DEGREE, 60.0 * n)
    ]
    record = write(tmp_path / "basin.dat", "t,psi,x0_dot,y0_dot,r,delta,rpm", columns, "%.2E")
    ship = tmp_path / "ship.toml"

    said = answered("new", record, "--ship", ship, "--length", 320).output
    text = ship.read_text(encoding="utf-8")
    ship.write_text(text.replace("length_m = 320  #", "# length_m = 320.0  # fill in:"))
    fill_in(ship)
    trial = load_trial(record, load_ship(ship))

    assert "no column" not in said
    assert trial.t == pytest.approx(fine, abs=0.01)
    assert load_ship(ship).records.current == "none"
    assert trial.speed == pytest.approx(np.interp(fine, t, u), abs=0.06)
    assert trial.rudder == pytest.approx(-np.interp(fine, t, rudder), abs=0.002)
    assert trial.revolutions == pytest.approx(np.interp(fine, t, n), rel=0.01)


@pytest.mark.parametrize(
    ("name", "speed", "turns", "unit"),
    [
        ("rpm", 8.0, 91.0, "rpm"),
        ("n", 8.0, 91.0, "rpm"),
        ("n", 8.0, 1.5, "1/s"),
        ("n", 0.4, 16.7, "1/s"),
    ],
)
def test_a_model_s_propeller_turns_faster_than_a_ship_s(
    tmp_path: Path, name: str, speed: float, turns: float, unit: str
) -> None:
    t = np.arange(0.0, 60.0)
    wave = 0.3 * np.sin(t / 10.0)
    record = write(
        tmp_path / "a.csv",
        f"t,rudder,psi,u,v,{name}",
        [t, wave, -wave, speed + 0.0 * t, 0.1 * wave, turns + 0.0 * t],
    )
    answered("new", record, "--ship", tmp_path / "ship.toml")
    text = (tmp_path / "ship.toml").read_text(encoding="utf-8")
    assert f'column = "{name}"\nunit = "{unit}"  # guessed' in text


def test_what_a_fit_needs_and_no_column_has_is_left_to_fill_in(
    sailed: Numbers, tmp_path: Path
) -> None:
    t, u, _, r, _, rudder, _ = sailed.T
    record = write(tmp_path / "a.csv", "t,u,r,rudder", [t, u, r, -rudder])

    said = answered("new", record, "--ship", tmp_path / "ship.toml").output
    text = (tmp_path / "ship.toml").read_text(encoding="utf-8")

    assert "no column for sway found" in said
    assert "no column for revolutions found" in said
    assert "# [[columns]]  # fill in: the drift cannot be told" in text


def test_columns_of_the_trainer_need_no_names(sailed: Numbers, tmp_path: Path) -> None:
    t, u, v, r, psi, rudder, n = sailed.T
    record = write(tmp_path / "a.csv", "t,u,v,r,psi,delta_r,n", [t, u, v, r, psi, -rudder, n])

    answered("new", record, "--ship", tmp_path / "ship.toml")

    assert "[[columns]]" not in (tmp_path / "ship.toml").read_text(encoding="utf-8")


BAD = {
    "numbers alone": ("0,1,2\n1,2,3\n", "line 1: numbers; the headings of columns belong there"),
    "text above": (
        "Basin\n20 / -20\n\n" + "1\t2\t3\n" * 30,
        "line 1: one heading, and rows of 3 columns: write the headings",
    ),
    "nothing known": ("a,b\n1,2\n2,3\n", "no column looks like the rudder.*it has a, b"),
}


@pytest.mark.parametrize("kind", BAD)
def test_what_is_no_record_is_refused_and_nothing_written(tmp_path: Path, kind: str) -> None:
    text, said = BAD[kind]
    record = tmp_path / "a.csv"
    record.write_text(text, encoding="utf-8")
    with pytest.raises(Exception, match=said):
        answered("new", record, "--ship", tmp_path / "ship.toml")
    assert not (tmp_path / "ship.toml").exists()


def test_a_study_and_a_ship_are_not_begun_at_once(sailed: Numbers, tmp_path: Path) -> None:
    record = write(tmp_path / "a.csv", "t,u", [sailed[:, 0], sailed[:, 1]])
    said = answered("new", record, "--ship", tmp_path / "s.toml", "-o", tmp_path / "a.toml", code=2)
    assert "--ship takes the place of --output" in said.output


def test_the_wind_over_ground_is_not_taken(sailed: Numbers, tmp_path: Path) -> None:
    t, u, v, r, psi, rudder, n = sailed.T
    heads = "t,u,v,r,psi,rudder,n,true_wind_speed,wind_dir_true"
    record = write(tmp_path / "a.csv", heads, [t, u, v, r, psi, -rudder, n, u, psi])
    answered("new", record, "--ship", tmp_path / "ship.toml")
    assert 'channel = "wind' not in (tmp_path / "ship.toml").read_text(encoding="utf-8")
