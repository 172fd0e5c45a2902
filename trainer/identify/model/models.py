"""The ship models: what their parameters are called, and their matrices by them.

``fitting/problem`` makes a plant of one. Model document, section 5. The rudder is in degrees and
turns the ship to port when positive, outputs are in knots, degrees and degrees a second, states in
m/s, rad/s and rad. Variances are taken by magnitude, correlations and the time lag by sine, so that
every number gives a model.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Final

import numpy as np

from trainer.config.files import ConfigError, nearest
from trainer.config.words import OUTPUT_CHANNELS
from trainer.core.kernel import Numbers
from trainer.identify.kernels import ship_models
from trainer.identify.kernels.kernel import Entries
from trainer.identify.model.nomoto import rate_coefficients

# output channels, by their index in the kernels
OUTPUT_UNITS: Final = {  # of a channel, and how many of them one SI unit is
    "bow_sway": ("kn", 3600.0 / 1852.0),
    "stern_sway": ("kn", 3600.0 / 1852.0),
    "sway": ("kn", 3600.0 / 1852.0),
    "yaw_rate": ("deg/s", 180.0 / np.pi),
    "heading": ("deg", 180.0 / np.pi),
}


STEADY_FORCES: Final = ("Y_0", "N_0", "f1", "f2", "f3", "delta_0")  # forces that stay for a run
# units and bounds of parameters that mean the same in all models; the rest have neither
# fmt: off
PARAMETER_UNITS: Final = {
    **dict.fromkeys(("v1_0", "v2_0", "v_0"), "kn"), "r_0": "deg/s", "delta_0": "deg",
    **dict.fromkeys(("R2_v", "R2_v1", "R2_v2"), "kn^2"), "R2_r": "(deg/s)^2", "R2_psi": "deg^2",
    **dict.fromkeys(("R1_YN", "R1_12", "R2_rpsi", "lag"), "rad"),
    **dict.fromkeys(("f1", "f2", "f3", "R1_1", "R1_2", "R1_3", "R1_13", "R1_23", "R1_r"), "SI"),
    **dict.fromkeys(("P11", "P22", "P33", "P12", "P13", "P23"), "SI"),
}
PARAMETER_KINDS: Final = {
    **dict.fromkeys(("R1_Y", "R1_N", "R1_r", "R1_1", "R1_2", "R1_3"), "variance"),
    **dict.fromkeys(("P11", "P22", "P33"), "variance"),
    **dict.fromkeys(("R2_v", "R2_v1", "R2_v2", "R2_r", "R2_psi"), "error"),
    **dict.fromkeys(("R1_YN", "R1_12", "R2_rpsi"), "angle"),
    "lag": "lag",
}
# fmt: on


@dataclass(frozen=True)
class Parameter:
    """One number of a model: ``kind`` is how it is bounded.

    "free" any number, "variance" by magnitude, "error" a reading's variance, "angle" [rad] by its
    sine, "lag" [rad] by the sine's magnitude.
    """

    name: str
    unit: str
    kind: str = "free"


@dataclass(frozen=True)
class Model:
    """A family of linear systems: ``assemble`` fills the matrices, see kernels.ship_models.

    A user may name ``given`` numbers, such as K and T of Nomoto, for the first parameters:
    ``follow`` computes these from all of them. ``system`` is a user's own system, which is no ship.
    """

    name: str
    parameters: tuple[Parameter, ...]
    outputs: tuple[str, ...]
    states: int
    assemble: Callable[..., Any]
    inputs: int = 1
    given: tuple[str, ...] = ()
    follow: Callable[..., tuple[float, ...]] | None = None
    system: Any = None  # an own_systems.System

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Return the parameters' names, in order."""
        return tuple(parameter.name for parameter in self.parameters)

    @cached_property
    def of_each_run(self) -> tuple[str, ...]:
        """Return the parameters that each of several runs has for itself.

        They are the first state, and the steady forces of wind and residual helm, because ship and
        instruments are the same in all runs but weather and start are not.
        """
        if self.system is not None:
            return tuple(self.system.only_in({"x0"}))
        states = (f"x{i}_0" for i in range(1, 1 + self.states))
        return tuple(name for name in (*states, *STEADY_FORCES) if name in self.names)

    @cached_property
    def paired(self) -> tuple[tuple[str, str], ...]:
        """Return each initial state with its variance."""
        if self.system is not None:
            return tuple(self.system.pairs)
        return tuple((f"x{i}_0", f"P{i}{i}") for i in range(1, 1 + self.states))

    def unit(self, output: str) -> str:
        """Return the unit of an output."""
        if self.system is None:
            return OUTPUT_UNITS[output][0]
        return str(self.system.units[self.outputs.index(output)])

    def index(self, name: str) -> int:
        """Return a parameter's index, by name or as theta1, theta2, ...; ConfigError if none."""
        if name.startswith("theta") and name[5:].isdecimal():
            index = int(name[5:]) - 1
            if 0 <= index < len(self.parameters):
                return index
        elif name in self.names:
            return self.names.index(name)
        elif name in self.given:
            follow = ", ".join(self.names[: len(self.given)])
            raise ConfigError(
                f"model {self.name} estimates {follow}, and {name} follows from them: "
                f"name all of {', '.join(self.given)}, or one of {follow}"
            )
        raise ConfigError(
            f"model {self.name} has no parameter {name!r}{nearest(name, self.names)}; it has "
            f"{', '.join(self.names)}, also called theta1 to theta{len(self.parameters)}"
        )

    def indices(self, names: Iterable[str]) -> tuple[int, ...]:
        """Return the indices of ``names``, each once.

        The names of ``given`` stand for the first parameters, which follow from them, and only if
        all of them are named.
        """
        unique_names = list(dict.fromkeys(names))
        inside = [name for name in self.given if name in unique_names]
        if inside and len(inside) < len(self.given):
            self.index(inside[0])
        indices = [
            *range(len(inside)),
            *(self.index(one) for one in unique_names if one not in inside),
        ]
        return tuple(dict.fromkeys(indices))

    def vector(self, **values: float) -> Numbers:
        """Return the parameters with these values, zero elsewhere."""
        theta = np.zeros(len(self.parameters))
        inside = [name for name in self.given if name in values]
        if self.follow and inside:
            theta[list(self.indices(inside))] = self.follow(*(values[name] for name in self.given))
        for name, value in values.items():
            if name not in inside:
                theta[self.index(name)] = value
        return theta


@dataclass(frozen=True)
class Ship:
    """The scales of the models, and the indices of the logs."""

    length: float  # [m]
    speed: float  # [m/s]
    bow_log: float = 0.0  # [m] forward of the centre of mass
    stern_log: float = 0.0  # [m] aft of the centre of mass


@dataclass(frozen=True)
class Blocks:
    """Continuous systems, one for each row of parameters; see ship_models.ModelBlocks.

    They are complex where the parameters are: imaginary parts carry derivatives.
    """

    drift: Entries  # (b, x+y, x+u+1)
    noise: Entries  # (b, x+y, x+y)
    start: Entries  # (b, x, 1+x)
    lag: Entries  # (b,) [s]
    gain: Entries | None = None  # (b, x, y) of a predictor, where the model gives it


@dataclass(frozen=True)
class Plant:
    """A model of a certain ship with certain outputs, read every ``period`` [s]."""

    model: Model
    ship: Ship
    outputs: tuple[str, ...]
    period: float

    def __post_init__(self) -> None:
        for output in self.outputs:
            if output not in self.model.outputs:
                has = ", ".join(self.model.outputs)
                raise ConfigError(f"model {self.model.name} has no output {output!r}; it has {has}")
        if {"sway", "bow_sway"} <= set(self.outputs):
            raise ConfigError("outputs: bow_sway and sway share a bias and an error; drop one")

    @cached_property
    def numbers(self) -> Numbers:
        """Return what the kernels know of the ship."""
        ship = self.ship
        indices = [
            float(OUTPUT_CHANNELS.index(output))
            for output in self.outputs
            if output in OUTPUT_CHANNELS
        ]
        return np.array(
            [ship.length, ship.speed, ship.bow_log, ship.stern_log, self.period, *indices]
        )

    def blocks(self, theta: Entries) -> Blocks:
        """Return the systems of the parameter vectors ``theta`` (b, n)."""
        batch, states = len(theta), self.model.states
        rows = states + len(self.outputs)
        blocks = ship_models.ModelBlocks(
            np.zeros((batch, rows, states + self.model.inputs + 1), theta.dtype),
            np.zeros((batch, rows, rows), theta.dtype),
            np.zeros((batch, states, 1 + states), theta.dtype),
            np.zeros(batch, theta.dtype),
        )
        gain = self.model.assemble(theta, self.numbers, blocks)
        return Blocks(*blocks, gain)


def _parameters(indices: Any, **own_units: str) -> tuple[Parameter, ...]:
    """Return the parameters at the ``indices`` of a kernel, some with units of this model alone."""
    units = PARAMETER_UNITS | own_units
    return tuple(
        Parameter(name, units.get(name, "-"), PARAMETER_KINDS.get(name, "free"))
        for name in indices._fields
    )


# m11 to m22 are m - Y_vdot, m x_G - Y_rdot, m x_G - N_vdot, I_z - N_rdot; Y_r is less m, N_r less
# m x_G. Lever arms are those of the wind, N_psi/Y_psi, and of the rudder, -N_delta/Y_delta.
MODEL_1: Final = Model(
    "1",
    _parameters(ship_models.MODEL_1, x1_0="kn", x2_0="deg/s", x3_0="deg"),
    OUTPUT_CHANNELS,
    3,
    ship_models.model_1,
)
# a are coefficients of the denominator, c of rudder to sway
MODEL_2: Final = Model(
    "2",
    _parameters(ship_models.MODEL_2, x1_0="kn", x2_0="SI", x3_0="SI"),
    ("sway",),
    3,
    ship_models.model_2,
)
# likewise, b of rudder to heading
MODEL_3: Final = Model(
    "3",
    _parameters(ship_models.MODEL_3, x1_0="1/s^2", x2_0="deg/s", x3_0="deg"),
    ("yaw_rate", "heading"),
    3,
    ship_models.model_3,
)
NOMOTO_1: Final = Model(
    "nomoto1",
    _parameters(ship_models.NOMOTO_1, K="1/s", T="s", x1_0="deg/s", x2_0="deg"),
    ("yaw_rate", "heading"),
    2,
    ship_models.nomoto_first,
)
# a1 is 1/T1 + 1/T2, a2 is 1/(T1 T2), b1 is K T3/(T1 T2), b2 is K/(T1 T2)
NOMOTO_2: Final = Model(
    "nomoto2",
    _parameters(
        ship_models.NOMOTO_2,
        a1="1/s",
        a2="1/s^2",
        b1="1/s^2",
        b2="1/s^3",
        x1_0="deg/s^2",
        x2_0="deg/s",
        x3_0="deg",
    ),
    ("yaw_rate", "heading"),
    3,
    ship_models.nomoto,
    given=("K", "T1", "T2", "T3"),
    follow=rate_coefficients,
)

MODELS: Final = {m.name: m for m in (MODEL_1, MODEL_2, MODEL_3, NOMOTO_1, NOMOTO_2)}
