"""The file of a ship's linear steering derivatives, as the report of 1974 tabulates them.

``trainer ship steering`` reads it. Model identification, section 2; Tables 8.1, 9.1 and 10.2.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Final

from trainer.config.files import ConfigError, Position, parse_toml, read_text
from trainer.config.schema import Choice, Text, read_record, required, with_default, within

DERIVATIVES_SCHEMA: Final = "derivatives/1"
ENTRY_LIMITS: Final = within(-1e3, 1e3)


@dataclass(frozen=True, kw_only=True)
class DerivativesFile:
    """A table's column in the prime or the bis system.

    Any common factor cancels in gains, time constants and lever arms: bis is prime over m', and
    Table 8.1 is in hundredths.
    """

    schema: str = required(Choice((DERIVATIVES_SCHEMA,), "form of the file"))
    name: str = required(Text(79, "name shown"))
    length_m: float = required("m", within(0.1, 600), "length")
    speed_kn: float = required("kn", within(0.01, 60), "speed")
    m11: float = required("-", ENTRY_LIMITS, "m - Y_vdot, sway force by sway acceleration")
    m12: float = with_default(0.0, "-", ENTRY_LIMITS, "m x_G - Y_rdot; else 0")
    m21: float = with_default(0.0, "-", ENTRY_LIMITS, "m x_G - N_vdot; else 0")
    m22: float = required("-", ENTRY_LIMITS, "I_z - N_rdot")
    Y_v: float = required("-", ENTRY_LIMITS, "sway force by sway")
    Y_r: float = required("-", ENTRY_LIMITS, "by yaw, less the mass: Y_r - m")
    N_v: float = required("-", ENTRY_LIMITS, "yaw moment by sway")
    N_r: float = required("-", ENTRY_LIMITS, "by yaw: N_r - m x_G")
    Y_delta: float = required("-", ENTRY_LIMITS, "sway force by rudder, positive to port")
    N_delta: float = required("-", ENTRY_LIMITS, "yaw moment by rudder, below 0")


def load_derivatives(path: Path) -> DerivativesFile:
    """Return the table in a file; ConfigError with all that is wrong."""
    position = Position(path.name, "")
    table = parse_toml(read_text(path), path.name)
    ship = read_record(DerivativesFile, table, position, ("note", "source"))
    if ship.m11 * ship.m22 == ship.m12 * ship.m21:
        raise ConfigError(position.problem("m11 m22 = m12 m21: a ship without mass has no motion"))
    return ship
