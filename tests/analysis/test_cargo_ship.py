"""A cargo ship through the library of manoeuvres: it has no planes, no depth and no roll.

MARINER in three degrees of freedom, in the form of Abkowitz; regression values of the validation
document of the vessel data, section 5.
"""

import json
import math
import re
import shlex
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner
from helpers.places import DATA, ROOT

from trainer.analysis.manoeuvres.catalogue import find_manoeuvre
from trainer.analysis.manoeuvres.flight import Manoeuvre, fly_manoeuvre
from trainer.analysis.manoeuvres.turns import Turn
from trainer.analysis.manoeuvres.zigzag import ZigZag
from trainer.boat.ship.forces import ROW_COUNT, add_terms, set_terms
from trainer.boat.ship.models import model_for
from trainer.cli.main import cli
from trainer.config.files import ConfigError, shipped_path
from trainer.config.ship.ship import load_ship, parse_ship
from trainer.identify.ships.vehicle import IdentifiedShip

TABLES: dict[str, Any] = tomllib.loads((DATA / "mariner_chislett.toml").read_text(encoding="utf-8"))
E = 1e-5  # of every derivative in the file
X, Y, N = TABLES["X"], TABLES["Y"], TABLES["N"]
SHIP = TABLES["vessel"]


def surge(u: float, v: float, r: float, d: float) -> float:
    """Return X'; u is the change of speed over the speed."""
    return E * (  # type: ignore[no-any-return]
        X["Xu"] * u
        + X["Xuu"] * u**2
        + X["Xuuu"] * u**3
        + X["Xvv"] * v**2
        + X["Xrr"] * r**2
        + X["Xrv"] * r * v
        + X["Xdd"] * d**2
        + X["Xudd"] * u * d**2
        + X["Xvd"] * v * d
        + X["Xuvd"] * u * v * d
    )


def sideways(c: dict[str, float], axis: str, u: float, v: float, r: float, d: float) -> float:
    """Return Y' or N', which have the same terms."""
    k = {name.removeprefix(axis): value for name, value in c.items()}
    return E * (
        (k["v"] + k["vu"] * u) * v
        + (k["r"] + k["ru"] * u) * r
        + k["vvv"] * v**3
        + k["vvr"] * v**2 * r
        + (k["d"] + k["ud"] * u + k["uud"] * u**2) * d
        + k["ddd"] * d**3
        + k["vdd"] * v * d**2
        + k["vvd"] * v**2 * d
        + k["0"]
        + k["0u"] * u
        + k["0uu"] * u**2
    )


def published_rates(change: float, v: float, r: float, delta: float) -> list[float]:
    """Return du/dt, dv/dt and dr/dt; the rudder's sense is that of the file, minus ours."""
    speed, length = math.hypot(SHIP["U0"] + change, v), SHIP["length"]
    u_, v_, r_ = change / speed, v / speed, r * length / speed
    m, x_g = SHIP["m_prime"], SHIP["xG_prime"]
    m22, m23 = m - E * Y["Yvdot"], m * x_g - E * Y["Yrdot"]
    m32, m33 = m * x_g - E * N["Nvdot"], SHIP["Iz_prime"] - E * N["Nrdot"]
    aside, turn = (sideways(c, a, u_, v_, r_, delta) for c, a in ((Y, "Y"), (N, "N")))
    whole = m22 * m33 - m23 * m32
    return [
        surge(u_, v_, r_, delta) * speed**2 / length / (m - E * X["Xudot"]),
        (m33 * aside - m23 * turn) * speed**2 / length / whole,
        (m22 * turn - m32 * aside) * (speed / length) ** 2 / whole,
    ]


def ship(manoeuvre: Manoeuvre) -> dict[str, float | None]:
    """Return the measures of a manoeuvre of the shipped ship."""
    vessel = IdentifiedShip(load_ship(shipped_path("ships", "mariner")))
    flight = fly_manoeuvre(vessel, manoeuvre, SHIP["U0"])
    return {one.name: one.value for one in manoeuvre.measures(flight)}


@pytest.mark.parametrize(("angle", "published"), [(20.0, (7.8, 6.4)), (10.0, (5.0, 4.5))])
def test_a_cargo_ship_makes_the_zig_zag_of_its_regression_values(
    angle: float, published: tuple[float, float]
) -> None:
    found = ship(ZigZag(angle, angle))

    # angles count from the rudder that holds her straight: what one side gains the other loses
    overshoots = [math.degrees(found[f"heading overshoot {i}"] or 0.0) for i in (1, 2)]
    assert sum(overshoots) == pytest.approx(sum(published), rel=0.03)


def shipped_rates(state: np.ndarray, rudder: float) -> np.ndarray:
    """Return du/dt, dv/dt and dr/dt of the shipped file's ship."""
    file = load_ship(shipped_path("ships", "mariner"))
    model = model_for(file, "abkowitz", wind=False)
    work, out = np.empty((ROW_COUNT, 1)), np.empty((3, 1))
    inputs = np.array([rudder, 1.25, 0.0, 0.0])
    set_terms(work, np.array(file.constants), state, inputs, np.zeros(5))
    add_terms(work, model.terms, model.whole(file.coefficients), np.array(file.constants), out)
    return out[:, 0]


@pytest.mark.parametrize("rudder", [-35.0, 0.0, 20.0])
def test_the_shipped_cargo_ship_accelerates_as_published(rudder: float) -> None:
    angle = math.radians(rudder)
    for du, v, r in np.random.default_rng(1).uniform(-1.0, 1.0, (20, 3)) * (3.0, 2.0, 0.02):
        rates = published_rates(du, v, r, -angle)
        own = shipped_rates(np.array([SHIP["U0"] + du, v, r]), angle)
        assert own == pytest.approx(rates, rel=1e-5, abs=1e-8)


@pytest.mark.parametrize(
    ("angle", "advance", "tactical", "steady"),
    [(35.0, 570.0, 1029.0, 1111.0), (20.0, 674.0, 1160.0, 1226.0)],
)
def test_the_shipped_cargo_ship_turns_from_the_rudder_that_holds_it_straight(
    angle: float, advance: float, tactical: float, steady: float
) -> None:
    found = ship(Turn(angle, 900.0))

    # 1.2 degrees of rudder to port hold it straight, and angles count from there
    assert found["advance"] == pytest.approx(advance, rel=0.03)
    assert found["tactical diameter"] == pytest.approx(tactical, rel=0.03)
    assert found["steady diameter"] == pytest.approx(steady, rel=0.03)


@pytest.mark.slow
def test_the_page_takes_the_shipped_cargo_ship_through_identification(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    page = (ROOT / "docs" / "nonlinear-ships.md").read_text(encoding="utf-8")
    blocks = re.findall(r"```console\n(.*?)```", page, re.DOTALL)
    lines = next(block for block in blocks if "turning-circle mariner" in block).splitlines()

    *flown, answer = [CliRunner().invoke(cli, (*shlex.split(line)[2:], "--json")) for line in lines]
    told = json.loads(answer.stdout)

    assert [one.exit_code for one in flown] == [0, 0, 0]
    assert answer.exit_code == 0, answer.output
    assert told["settled"]
    assert [one["name"] for one in told["coefficients"]][:3] == ["X_0", "X_vv", "X_vr"]
    assert "held, by the ship's file: X_T 0, " in "".join(told["findings"])
    assert told["predictions"][1]["explained"][2] > 99.5
    gain = next(one for one in told["coefficients"] if one["name"] == "N_d")
    assert gain["value"] == pytest.approx(1.6275, rel=0.05)


@pytest.mark.parametrize(
    ("there", "instead", "said"),
    [
        ("advance_m = 6.174", "", r"\[dimensions\] lacks advance_m, which N_ddd needs"),
        (
            "Y_ddd =",
            "Y_dddd =",
            r"\[coefficients\] Y_dddd is none of model abkowitz; nearest is Y_ddd",
        ),
        ("N_v =", "N_vw =", r"\[coefficients\] lacks N_v$"),
    ],
)
def test_a_ship_whose_polynomial_is_not_whole_is_refused(
    there: str, instead: str, said: str
) -> None:
    path = shipped_path("ships", "mariner")
    text = path.read_text(encoding="utf-8").replace(there, instead, 1)

    with pytest.raises(ConfigError, match=said):
        IdentifiedShip(parse_ship(text, path))


def test_a_vehicle_without_the_control_is_refused_by_name() -> None:
    with pytest.raises(ConfigError, match="needs a control 'engine', and it has rudder alone"):
        ship(find_manoeuvre("crash-stop"))
