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
from typing import Any, ClassVar

import numpy as np
import pytest
from click.testing import CliRunner
from helpers.places import DATA, ROOT

from trainer.analysis.manoeuvres.catalogue import find_manoeuvre
from trainer.analysis.manoeuvres.flight import Flight, Manoeuvre, fly_manoeuvre
from trainer.analysis.manoeuvres.turns import PullOut, ReverseSpiral, Spiral, Turn
from trainer.analysis.manoeuvres.vehicle import Control
from trainer.analysis.manoeuvres.zigzag import ZigZag
from trainer.boat.ship.forces import ROW_COUNT, add_terms, set_terms
from trainer.boat.ship.models import model_for
from trainer.cli.main import cli
from trainer.config.files import ConfigError, shipped_path
from trainer.config.ship import load_ship, parse_ship
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


class Mariner:
    """The ship; its propeller turns as for the speed at the start."""

    name = "MARINER"
    length = SHIP["length"]
    columns = ("t", "u", "v", "r", "x", "y", "psi", "delta_r")
    controls: ClassVar[dict[str, Control]] = {
        "rudder": Control(
            -math.radians(SHIP["rudder_limit_deg"]), math.radians(SHIP["rudder_limit_deg"])
        )
    }

    def __init__(self, step: float) -> None:
        self.step = step
        self.start(SHIP["U0"])

    def start(self, speed: float) -> None:
        """Begin straight ahead, rudder amidships; x, y, psi from zero."""
        self.ahead, self.time, self.rudder = speed, 0.0, 0.0
        # change of u, v, r, x, y, psi, delta: MSS's delta is minus ours
        self.state = np.zeros(7)

    def order(self, control: str, value: float) -> None:
        """Order the rudder, positive to starboard."""
        assert control == "rudder"
        self.rudder = value

    def keep(self, quantity: str) -> None:
        """Do nothing: a ship floats, and its propeller turns as it did."""

    def observe(self) -> tuple[float, ...]:
        """Return the columns."""
        u, v, r, x, y, psi, delta = (float(one) for one in self.state)
        return self.time, self.ahead + u, v, r, x, y, psi, delta

    def rates(self, state: np.ndarray) -> np.ndarray:
        """Return d(state)/dt; the rudder's sense is that of our orders."""
        du, v, r, _, _, psi, angle = state
        speed, length = math.hypot(self.ahead + du, v), self.length
        delta = -angle
        u_, v_, r_ = du / speed, v / speed, r * length / speed
        m, x_g = SHIP["m_prime"], SHIP["xG_prime"]
        m11 = m - E * X["Xudot"]
        m22, m23 = m - E * Y["Yvdot"], m * x_g - E * Y["Yrdot"]
        m32, m33 = m * x_g - E * N["Nvdot"], SHIP["Iz_prime"] - E * N["Nrdot"]
        push = surge(u_, v_, r_, delta)
        aside, turn = (sideways(c, a, u_, v_, r_, delta) for c, a in ((Y, "Y"), (N, "N")))
        whole = m22 * m33 - m23 * m32
        most = math.radians(SHIP["rudder_rate_deg_s"])
        return np.array(
            [
                push * speed**2 / length / m11,
                (m33 * aside - m23 * turn) * speed**2 / length / whole,
                (m22 * turn - m32 * aside) * (speed / length) ** 2 / whole,
                math.cos(psi) * (self.ahead + du) - math.sin(psi) * v,
                math.sin(psi) * (self.ahead + du) + math.cos(psi) * v,
                r,
                min(max(self.rudder - angle, -most), most),
            ]
        )

    def advance(self) -> None:
        """Advance by one step of Runge and Kutta, the rudder's order held."""
        h, s = self.step, self.state
        k1 = self.rates(s)
        k2 = self.rates(s + 0.5 * h * k1)
        k3 = self.rates(s + 0.5 * h * k2)
        k4 = self.rates(s + h * k3)
        self.state = s + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
        self.time += h

    def incline(self, heel: float) -> None:
        """Refuse: it has no roll."""
        raise NotImplementedError(heel)  # the vehicle asks for it; no manoeuvre of a ship inclines


def ship(manoeuvre: Manoeuvre, step: float = 0.1) -> tuple[Flight, dict[str, float | None]]:
    flight = fly_manoeuvre(Mariner(step), manoeuvre, 7.7175)
    return flight, {one.name: one.value for one in manoeuvre.measures(flight)}


@pytest.mark.parametrize(
    ("angle", "first", "second", "execute"), [(20.0, 7.8, 6.4, 34.2), (10.0, 5.0, 4.5, None)]
)
def test_a_cargo_ship_makes_the_zig_zag_of_its_regression_values(
    angle: float, first: float, second: float, execute: float | None
) -> None:
    _, found = ship(ZigZag(angle, angle))

    overshoots = [math.degrees(found[f"heading overshoot {i}"] or 0.0) for i in (1, 2)]
    assert overshoots == pytest.approx([first, second], rel=0.02)
    if execute:
        assert found["time of execute 2"] == pytest.approx(execute, rel=0.02)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("angle", "advance", "tactical", "steady"),
    [(35.0, 570.0, 1029.0, 1111.0), (20.0, 674.0, 1160.0, 1226.0)],
)
def test_a_cargo_ship_makes_the_turn_of_its_regression_values(
    angle: float, advance: float, tactical: float, steady: float
) -> None:
    flight, found = ship(Turn(angle, 900.0))

    assert found["advance"] == pytest.approx(advance, rel=0.02)
    assert found["tactical diameter"] == pytest.approx(tactical, rel=0.02)
    assert found["steady diameter"] == pytest.approx(steady, rel=0.02)
    if angle == 35.0:
        speed = math.hypot(flight.column("u")[-1], flight.column("v")[-1])
        assert speed / 7.7175 == pytest.approx(0.78, rel=0.02)


@pytest.mark.slow
def test_a_ship_unstable_on_course_turns_by_itself_and_the_reverse_spiral_shows_it() -> None:
    _, pulled = ship(PullOut(), 0.5)
    _, direct = ship(Spiral(), 0.5)
    _, reverse = ship(ReverseSpiral(), 0.5)

    assert (pulled["yaw rate left after starboard"] or 0.0) > 1e-3
    assert (pulled["yaw rate left after port"] or 0.0) > 1e-3
    assert (direct["width of the loop"] or 0.0) > 5e-4
    # a slow turn to starboard has to be held by rudder to port of what holds the ship straight
    assert (reverse["rudder at 17 %"] or 0.0) > (reverse["rudder at 0 %"] or 0.0)
    assert (reverse["rudder at 33 %"] or 0.0) < math.radians(15.0) / 3.0


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
    published, angle = Mariner(0.1), math.radians(rudder)
    for du, v, r in np.random.default_rng(1).uniform(-1.0, 1.0, (20, 3)) * (3.0, 2.0, 0.02):
        rates = published.rates(np.array([du, v, r, 0.0, 0.0, 0.0, angle]))[:3]
        own = shipped_rates(np.array([SHIP["U0"] + du, v, r]), angle)
        assert own == pytest.approx(rates, rel=1e-5, abs=1e-8)


@pytest.mark.parametrize(
    ("angle", "advance", "tactical", "steady"),
    [(35.0, 570.0, 1029.0, 1111.0), (20.0, 674.0, 1160.0, 1226.0)],
)
def test_the_shipped_cargo_ship_turns_from_the_rudder_that_holds_it_straight(
    angle: float, advance: float, tactical: float, steady: float
) -> None:
    vessel = IdentifiedShip(load_ship(shipped_path("ships", "mariner")))
    turn = Turn(angle, 900.0)
    found = {one.name: one.value for one in turn.measures(fly_manoeuvre(vessel, turn, SHIP["U0"]))}

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
