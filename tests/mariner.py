"""A cargo ship for the manoeuvres: three degrees of freedom, Abkowitz form, no submarine in it."""

import math
import tomllib
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from trainer.study.manoeuvres.vehicle import Control

TABLES: dict[str, Any] = tomllib.loads(
    (Path(__file__).parent / "data" / "mariner_chislett.toml").read_text(encoding="utf-8")
)
E = 1e-5  # of every derivative in the file
X, Y, N = TABLES["X"], TABLES["Y"], TABLES["N"]
SHIP = TABLES["vessel"]


def surge(u: float, v: float, r: float, d: float) -> float:
    """Return X'; u is the change of speed over the speed."""
    return E * (
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
        raise NotImplementedError(heel)
