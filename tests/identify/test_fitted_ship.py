"""The Python face of fits: arrays, frames and files in; numbers, predictions and plots out."""

import math
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers.places import environment
from helpers.ships import COEFFICIENTS, SHIP, sailed_zigzag

import trainer
from trainer import identify
from trainer.config.ship.nomoto import load_nomoto
from trainer.config.ship.ship import load_ship, ship_text
from trainer.identify.experiment import hold_bits, prbs

pytest.importorskip("scipy")

K, T, STEP = -0.05, 20.0, 2.0


def motion(seed: int, count: int = 300) -> Any:
    """Return time [s], rudder [rad] and yaw rate [rad/s] of a first-order ship, noisy."""
    helm = np.radians(np.resize(hold_bits(prbs(5, seed), 5.0, 5), count))
    rate, fade = np.zeros(count), np.exp(-STEP / T)
    for i in range(count - 1):
        rate[i + 1] = fade * rate[i] + (1.0 - fade) * K * helm[i]
    noise = np.radians(0.01) * np.random.default_rng(seed).standard_normal(count)
    return {"t": STEP * np.arange(count), "rudder": helm, "yaw_rate": rate + noise}


def fitted(frame: Any, **keywords: Any) -> Any:
    return identify.fit(frame, "nomoto1", length=120, speed=12, **keywords)


@pytest.fixture(scope="module")
def ship() -> Any:
    return fitted(motion(1))


@pytest.mark.process
def test_importing_it_costs_nothing_until_it_is_used() -> None:
    code = (
        "import sys, trainer.identify as i; assert 'numpy' not in sys.modules; "
        "i.fit; assert 'numpy' in sys.modules"
    )
    done = subprocess.run([sys.executable, "-c", code], env=environment(), check=False)
    assert done.returncode == 0
    with pytest.raises(AttributeError, match="no attribute 'fitt'"):
        identify.fitt  # type: ignore[attr-defined]  # noqa: B018


def test_a_ship_is_found_from_arrays(ship: Any) -> None:
    assert ship.converged
    assert ship.doubt == ""
    assert abs(ship.K - K) < 4.0 * ship.deviations["K"]
    assert ship.parameters["T"] == ship.T1
    assert ship.numbers["T1"].low < T < ship.numbers["T1"].high
    names = list(ship.parameters)
    assert ship.covariance.shape == (len(names), len(names))
    assert ship.covariance[0, 0] == pytest.approx(ship.deviations["K"] ** 2)
    assert "IDENTIFICATION, model nomoto1" in repr(ship)
    with pytest.raises(AttributeError, match="this ship has no 'K_v'; it has K, T1"):
        ship.K_v  # noqa: B018


def test_columns_units_and_signs_may_be_one_s_own(ship: Any) -> None:
    own = motion(1)
    frame = {
        "clock": own["t"] / 60.0,
        "helm": -np.degrees(own["rudder"]),
        "rate": np.degrees(own["yaw_rate"]),
    }
    found = fitted(
        frame,
        columns={"t": "clock", "rudder": "helm", "yaw_rate": "rate"},
        units={"t": "min", "rudder": "deg", "yaw_rate": "deg/s"},
        positive_rudder="starboard",
    )
    assert found.parameters == pytest.approx(ship.parameters, rel=1e-4)
    predicted = found.predict(frame)["yaw_rate"]
    assert predicted == pytest.approx(np.degrees(ship.predict(own)["yaw_rate"]), abs=1e-4)


@pytest.mark.slow
def test_a_frame_of_pandas_and_a_file_give_the_same_ship(ship: Any, tmp_path: Path) -> None:
    pandas = pytest.importorskip("pandas")
    own = motion(1)
    names = {"t": "t", "rudder": "delta_r", "yaw_rate": "r"}
    table = pandas.DataFrame({names[name]: column for name, column in own.items()})
    table.to_csv(tmp_path / "trial.csv", index=False)
    timed = table.set_index("t")
    for frame in (table, timed, tmp_path / "trial.csv"):
        more = {"outputs": ["yaw_rate"]} if isinstance(frame, Path) else {}
        if isinstance(frame, Path):
            table.assign(psi=0.0, v=0.0, u=6.0).to_csv(frame, index=False)
        assert fitted(frame, **more).parameters == pytest.approx(ship.parameters, rel=1e-6)


def test_another_record_is_predicted_by_rudder_alone(ship: Any) -> None:
    other = motion(3)
    found = ship.predict(other)
    assert list(found) == ["t", "yaw_rate"]
    assert np.std(found["yaw_rate"] - other["yaw_rate"]) < np.radians(0.015)
    # without a reading the ship begins at rest
    blind = ship.predict({"t": other["t"], "rudder": other["rudder"]})["yaw_rate"]
    assert blind[0] == pytest.approx(0.0, abs=1e-12)
    assert np.std(blind - other["yaw_rate"]) < np.radians(0.05)
    assert ship.residuals["yaw_rate"].shape == (300,)
    assert np.std(ship.residuals["yaw_rate"]) == pytest.approx(np.radians(0.01), rel=0.15)


@pytest.mark.slow
def test_series_matrices_plots_and_files_come_out(ship: Any, tmp_path: Path) -> None:
    assert ship.series()["yaw_rate_measured_deg_s"] == pytest.approx(
        np.degrees(motion(1)["yaw_rate"])
    )
    assert ship.matrices()["estimate"]["continuous"]["A"][1] == [1.0, 0.0]
    ship.write(tmp_path / "ship.toml")
    assert load_nomoto(tmp_path / "ship.toml").K_per_s == pytest.approx(ship.K)
    pytest.importorskip("matplotlib")
    assert len(ship.plot().axes) == 13
    ship.plot(tmp_path / "fit.png")
    assert (tmp_path / "fit.png").read_bytes()[:4] == b"\x89PNG"


def test_parameters_may_begin_elsewhere_and_be_held() -> None:
    found = fitted(motion(1), fixed={"T": np.float32(25.0)}, start={"K": -0.03}, every=np.int64(1))
    assert "T" not in found.parameters
    assert found.T1 == 25.0


@pytest.mark.parametrize(
    ("change", "keywords", "told"),
    [
        ({"rudder": None}, {}, "frame: no column 'rudder' for rudder; it has t, yaw_rate"),
        ({"t": np.zeros(300)}, {}, "frame: row 1: t = 0 s is repeated"),
        ({"yaw_rate": np.zeros(299)}, {}, r"yaw_rate: has shape \(299,\), must be \(300,\)"),
        ({"yaw_rate": ["fast"] * 300}, {}, "yaw_rate: is no array of numbers"),
        ({}, {"units": {"rudder": "kn"}}, 'rudder: unit "kn": must be rad or deg'),
        ({}, {"units": {"ruder": "deg"}}, "no channel 'ruder'; nearest is rudder"),
        ({}, {"lenght": 3}, "no keyword 'lenght'; nearest is length"),
        ({}, {"noise": "white"}, 'fit: noise = "white": must be output-error or'),
        ({}, {"length": None}, r"frame: lacks \[ship\]"),
        ({}, {"length": math.nan}, "fit: length = nan: must be finite, 0.1 to 600 m"),
        ({}, {"length": "120"}, 'fit: length = "120": must be a number, 0.1 to 600 m'),
        ({}, {"speed": -12}, "fit: speed = -12: must be 0.01 to 60 kn"),
        ({}, {"every": 0}, "fit: every = 0: must be a whole number, 1 to 1000"),
        ({}, {"end": "x"}, 'fit: end = "x": must be a number'),
        ({}, {"start": {"T": math.nan}}, "fit: start: T = nan: must be a finite number"),
        ({}, {"fixed": {"T": "x"}}, "fit: fixed: T = 'x': must be a finite number"),
        ({}, {"start": 5}, "fit: start: must be numbers by name, such as {'T': 20.0}"),
    ],
)
def test_what_cannot_be_fitted_is_named(change: Any, keywords: Any, told: str) -> None:
    frame = {name: column for name, column in (motion(1) | change).items() if column is not None}
    with pytest.raises(trainer.TrainerError, match=told):
        identify.fit(frame, "nomoto1", **{"length": 120, "speed": 12, **keywords})


def zigzag(angle: float, seed: int) -> dict[str, Any]:
    """Return the arrays of a zig-zag of a tanker, a positive rudder to port."""
    trial, _ = sailed_zigzag(angle, seed)
    names = ("t", "rudder", "speed", "sway", "yaw_rate", "heading")
    return {"n": trial.revolutions} | {name: getattr(trial, name) for name in names}


@pytest.fixture(scope="module")
def dimensions(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the path of the tanker's dimensions."""
    path = tmp_path_factory.mktemp("ships") / "ship.toml"
    path.write_text(ship_text(SHIP, "a test"), encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def tanker(dimensions: Path) -> Any:
    return identify.fit(zigzag(20.0, 1), "mmg", ship=dimensions)


@pytest.mark.slow
def test_a_ship_that_is_not_linear_is_found_from_arrays(tanker: Any, tmp_path: Path) -> None:
    assert tanker.converged
    assert abs(tanker.parameters["N_F"] - COEFFICIENTS["N_F"]) < 4.0 * tanker.deviations["N_F"]
    names = list(tanker.parameters)
    assert tanker.covariance.shape == (len(names), len(names))
    assert np.sqrt(np.diag(tanker.covariance)) == pytest.approx(list(tanker.deviations.values()))
    assert tanker.prior_share["l"] > 0.9 > tanker.prior_share["N_F"]
    assert any({"N_vrr", "N_vvr"} <= set(parts) for parts in tanker.untold)
    (cost,) = re.findall(r"-log L with the prior (\S+)", repr(tanker))
    assert tanker.log_likelihood > -float(cost)  # the prior takes some off
    assert "IDENTIFICATION OF A SHIP, model mmg" in repr(tanker)
    tanker.write(tmp_path / "found.toml")
    found = load_ship(tmp_path / "found.toml")
    assert found.coefficients["N_F"] == tanker.parameters["N_F"]
    assert found.covariance == pytest.approx(tanker.covariance, rel=1e-6, abs=1e-12)
    pytest.importorskip("matplotlib")
    assert len(tanker.plot().axes) == 13


@pytest.mark.slow
def test_it_predicts_a_record_that_it_has_not_seen_in_the_units_of_the_fit(
    tanker: Any, dimensions: Path
) -> None:
    other = zigzag(-10.0, 7)
    found = tanker.predict(other)
    left = np.std(found["yaw_rate"] - other["yaw_rate"])
    assert left < 0.2 * np.std(other["yaw_rate"])
    assert list(found) == ["t", "speed", "sway", "yaw_rate", "heading"]

    own = zigzag(20.0, 1)
    frame = own | {"helm": -np.degrees(own["rudder"]), "rpm": 60.0 * own["n"]}
    frame |= {"log": own["speed"] / 0.514444444444444}
    again = identify.fit(
        {name: frame[name] for name in ("t", "helm", "rpm", "log", "sway", "yaw_rate", "heading")},
        "linear",
        ship=dimensions,
        columns={"rudder": "helm", "revolutions": "rpm", "speed": "log"},
        units={"rudder": "deg", "revolutions": "rpm", "speed": "kn"},
        positive_rudder="starboard",
    )
    plain = identify.fit(own, "linear", ship=dimensions)
    assert again.parameters == pytest.approx(plain.parameters, rel=1e-4, abs=1e-6)
    assert again.predict(frame)["speed"] * 0.514444444444444 == pytest.approx(
        plain.predict(own)["speed"], rel=1e-4
    )


@pytest.mark.slow
def test_records_of_one_ship_are_fitted_together_and_may_be_files(
    dimensions: Path, tmp_path: Path
) -> None:
    frames = [zigzag(20.0, 1), zigzag(-20.0, 2)]
    own = {"speed": "u", "sway": "v", "yaw_rate": "r", "heading": "psi", "rudder": "delta_r"}
    rows = np.column_stack(list(frames[1].values()))
    head = ",".join(own.get(name, name) for name in frames[1])
    np.savetxt(tmp_path / "b.csv", rows, delimiter=",", header=head, comments="", fmt="%.17g")
    mixed = identify.fit([frames[0], tmp_path / "b.csv"], "linear", ship=dimensions, every=2)
    both = identify.fit(frames, "linear", ship=dimensions, every=2)
    one = identify.fit(frames[0], "linear", ship=dimensions, every=2)
    assert mixed.parameters == pytest.approx(both.parameters, rel=1e-9)
    assert both.deviations["N_d"] < 0.9 * one.deviations["N_d"]


@pytest.mark.parametrize(
    ("change", "keywords", "told"),
    [
        ({"n": None}, {}, "frame: no revolutions was recorded: the propeller's slipstream"),
        ({}, {"ship": None}, "model mmg: lacks ship"),
        ({}, {"length": 320.0}, "length: not with model mmg"),
        ({}, {"units": {"revolutions": "deg"}}, 'revolutions: unit "deg": must be 1/s or rps'),
        ({}, {"prior_strength": -1.0}, "prior_strength = -1.0: must be 0 to 100"),
    ],
)
def test_what_such_a_ship_cannot_be_fitted_to_is_named(
    change: Any, keywords: Any, told: str, dimensions: Path
) -> None:
    arrays = zigzag(20.0, 1) | change
    frame = {name: column for name, column in arrays.items() if column is not None}
    with pytest.raises(trainer.TrainerError, match=told):
        identify.fit(frame, "mmg", **{"ship": dimensions, **keywords})


def test_keywords_of_books_and_several_frames_are_for_ships_that_are_not_linear() -> None:
    with pytest.raises(trainer.TrainerError, match="ship: not with model nomoto1"):
        fitted(motion(1), ship="ship.toml")
    with pytest.raises(trainer.TrainerError, match="model nomoto1: takes one frame"):
        fitted([motion(1)])
