"""A ship in a few numbers: the file of an identified Nomoto model, read and written."""

from dataclasses import dataclass, fields
from pathlib import Path
from typing import Final

from trainer.config import Place, parse_toml, read_text
from trainer.files.schema import (
    Choice,
    Quantity,
    Text,
    key_rows,
    of,
    optional,
    read_record,
    within,
)

SCHEMA: Final = "nomoto/1"
TIME: Final = within(-1e6, 1e6)


@dataclass(frozen=True, kw_only=True)
class NomotoFile:
    """T1 T2 r'' + (T1 + T2) r' + r - kappa K |r| r = K (delta + T3 delta'); sway alike.

    The rudder is positive to port: K < 0 for a stable ship.
    """

    schema: str = of(Choice((SCHEMA,), "form of the file"))
    name: str = of(Text(79, "name shown"))
    length_m: float = of(Quantity("m", within(0.1, 600), "length"))
    speed_kn: float = of(Quantity("kn", within(0.01, 60), "speed it was identified at"))
    K_per_s: float = of(Quantity("1/s", within(-100, 100), "gain, rudder to yaw rate"))
    T1_s: float = of(Quantity("s", TIME, "larger time constant"))
    T2_s: float = of(Quantity("s", TIME, "smaller time constant; 0 for a first-order ship"))
    T3_s: float = of(Quantity("s", TIME, "time constant of the numerator"))
    kappa_s2: float | None = optional(Quantity("s^2", within(-1e9, 1e9), "of |r| r; else 0"))
    K_v_m_s: float | None = optional(Quantity("m/s", within(-1e4, 1e4), "gain to sway; else 0"))
    T3v_s: float | None = optional(Quantity("s", TIME, "numerator of sway; else 0"))
    neutral_deg: float | None = optional(Quantity("deg", within(-30, 30), "residual helm; else 0"))
    rudder_limit_deg: float = of(Quantity("deg", within(0.1, 90), "limit of the rudder"))
    rudder_rate_deg_s: float = of(Quantity("deg/s", within(0.01, 1000), "rate of the rudder"))
    step_s: float = of(Quantity("s", within(0.001, 10), "step of computation"))


def load_nomoto(path: Path) -> NomotoFile:
    """Return the ship in a file; ConfigError with all that is wrong.

    ``source`` and ``deviations`` tell where the numbers are from and are not read.
    """
    table = parse_toml(read_text(path), path.name)
    return read_record(NomotoFile, table, Place(path.name, ""), ("note", "source", "deviations"))


def is_nomoto(path: Path) -> bool:
    """Return whether a TOML file is of a Nomoto model; ConfigError if it is no TOML."""
    return parse_toml(read_text(path), path.name).get("schema") == SCHEMA


def written(ship: NomotoFile, source: str, deviations: dict[str, float]) -> str:
    """Return the text of the file, with its source and the numbers' standard deviations."""
    lines = []
    for item in fields(ship):
        value = getattr(ship, item.name)
        if value is not None:
            text = f'"{value}"' if isinstance(value, str) else f"{value:.9g}"
            lines.append(f"{item.name} = {text}")
    lines += [f'source = "{source}"', "", "[deviations]  # standard deviations, by the record"]
    lines += [f"{name} = {value:.3g}" for name, value in deviations.items()]
    return "\n".join(lines) + "\n"


def key_table() -> str:
    """Return the Markdown table of the keys, as docs/identification.md shows it."""
    return "\n".join(key_rows(NomotoFile, "nomoto")).replace("### `[nomoto]`\n\n", "") + "\n"
