"""The file of a ship in Nomoto's form, read and written.

``trainer identify`` writes it. Manoeuvres sail such a ship, and exercises have them as contacts.
``boat/world/nomoto`` has the law.
"""

from dataclasses import dataclass, fields
from pathlib import Path
from typing import Final

from trainer.config.files import ConfigError, Position, parse_toml, read_text, toml_value
from trainer.config.schema import (
    Choice,
    Text,
    optional,
    read_record,
    required,
    within,
)

NOMOTO_SCHEMA: Final = "nomoto/1"
TIME_LIMITS_S: Final = within(-1e6, 1e6)


@dataclass(frozen=True, kw_only=True)
class NomotoFile:
    """A Nomoto ship with a nonlinear term in its yaw, and with sway.

    T1 T2 r'' + (T1 + T2) r' + r - kappa K |r| r = K (delta + T3 delta').

    The rudder is positive to port: K < 0 for a stable ship. With H1 the left side ends in K H(r),
    H(r) = H1 r + H2 |r| r + H3 r^3 the helm of steady turns.
    """

    schema: str = required(Choice((NOMOTO_SCHEMA,), "form of the file"))
    name: str = required(Text(79, "name shown"))
    length_m: float = required("m", within(0.1, 600), "length")
    speed_kn: float = required("kn", within(0.01, 60), "speed it was identified at")
    K_per_s: float = required("1/s", within(-100, 100), "gain, rudder to yaw rate")
    T1_s: float = required("s", TIME_LIMITS_S, "larger time constant")
    T2_s: float = required("s", TIME_LIMITS_S, "smaller time constant; 0 for a first-order ship")
    T3_s: float = required("s", TIME_LIMITS_S, "time constant of the numerator")
    kappa_s2: float | None = optional("s^2", within(-1e9, 1e9), "of |r| r; else 0")
    H1_s: float | None = optional("s", TIME_LIMITS_S, "of r in Bech's H(r), instead of kappa")
    H2_s2: float | None = optional("s^2", within(-1e9, 1e9), "of |r| r; else 0")
    H3_s3: float | None = optional("s^3", within(-1e12, 1e12), "of r^3; else 0")
    K_v_m_s: float | None = optional("m/s", within(-1e4, 1e4), "gain to sway; else 0")
    T3v_s: float | None = optional("s", TIME_LIMITS_S, "numerator of sway; else 0")
    neutral_deg: float | None = optional("deg", within(-30, 30), "residual helm; else 0")
    rudder_limit_deg: float = required("deg", within(0.1, 90), "limit of the rudder")
    rudder_rate_deg_s: float = required("deg/s", within(0.01, 1000), "rate of the rudder")
    step_s: float = required("s", within(0.001, 10), "step of computation")

    @property
    def bend(self) -> tuple[float, float, float]:
        """Return the factors of r [-], |r| r [s] and r^3 [s^2] in K H(r).

        Without H1 they are those of r - kappa K |r| r.
        """
        K = self.K_per_s
        if self.H1_s is None:
            return 1.0, -(self.kappa_s2 or 0.0) * K, 0.0
        return K * self.H1_s, K * (self.H2_s2 or 0.0), K * (self.H3_s3 or 0.0)


def load_nomoto(path: Path) -> NomotoFile:
    """Return the ship in a file; ConfigError with all that is wrong.

    ``source`` and ``deviations`` are for people, and are not read.
    """
    table = parse_toml(read_text(path), path.name)
    position = Position(path.name, "")
    ship = read_record(NomotoFile, table, position, ("note", "source", "deviations"))
    for key, value in (("H2_s2", ship.H2_s2), ("H3_s3", ship.H3_s3)):
        if value is not None and ship.H1_s is None:
            raise ConfigError(position.wrong(key, value, "goes with H1_s, which is not given"))
    if ship.H1_s is not None and ship.kappa_s2 is not None:
        raise ConfigError(position.wrong("kappa_s2", ship.kappa_s2, "stands in for H1_s: give one"))
    return ship


def is_nomoto(path: Path) -> bool:
    """Return whether a TOML file is of a Nomoto model. ConfigError if it is no TOML."""
    return parse_toml(read_text(path), path.name).get("schema") == NOMOTO_SCHEMA


def nomoto_text_of(ship: NomotoFile, source: str, deviations: dict[str, float]) -> str:
    """Return the text of the file, with its source and the numbers' standard deviations."""
    lines = []
    for item in fields(ship):
        value = getattr(ship, item.name)
        if value is not None:
            lines.append(f"{item.name} = {toml_value(value, '.9g')}")
    lines.append(f"source = {toml_value(source)}")
    lines += ["", "[deviations]  # standard deviations, by the record"]
    lines += [f"{name} = {toml_value(value, '.3g')}" for name, value in deviations.items()]
    return "\n".join(lines) + "\n"
