"""What an exercise file may say, table by table: keys, units and limits."""

from dataclasses import dataclass
from typing import Final

from trainer.config import ConfigError, Place
from trainer.files.schema import (
    Choice,
    Quantity,
    Rows,
    Text,
    of,
    optional,
    tables_of,
    within,
)
from trainer.fitout import EQUATIONS
from trainer.io.schedule import LATEST
from trainer.scores.score_rule import Score
from trainer.watch import Limits


@dataclass(frozen=True)
class Page:
    """Some lines of text."""

    longest: int
    meaning: str

    @property
    def cells(self) -> tuple[str, str, str]:
        """Return unit, range and meaning."""
        return "text", f"1 to {self.longest} characters", self.meaning

    def read(self, key: str, value: object, place: Place) -> str:
        """Return the text; ConfigError if it is empty, too long or not printable."""
        good = isinstance(value, str) and value.replace("\n", "").isprintable()
        if not isinstance(value, str) or not good or not 1 <= len(value.strip()) <= self.longest:
            raise ConfigError(
                place.wrong(key, value, f"must be printable text of 1 to {self.longest} characters")
            )
        return value.strip()


@dataclass(frozen=True, kw_only=True)
class Heading:
    """What an exercise is, and how the boat is computed."""

    schema: str = of(Choice(("exercise/1",), "form of the file"))
    name: str = of(Text(55, "one line for the list of exercises"))
    briefing: str = of(Page(4000, "what the crew is told at the start"))
    vessel: str | None = optional(Text(200, "name of a boat, or path of its file"))
    equations: str | None = optional(Choice(EQUATIONS, "set of equations"))
    rates: str | None = optional(Choice(("exact", "lagged"), "how accelerations are found"))
    integrator: str | None = optional(Text(200, "as --integrator"))
    step_s: float | None = optional(Quantity("s", within(0.001, 2), "time step"))
    seed: float | None = optional(Quantity("-", within(0, 1e15), "of everything random"))
    duration_s: float | None = optional(Quantity("s", within(0.001, LATEST), "end of the exercise"))
    casualty_table: str | None = optional(Text(200, "path of a table of casualties of your own"))


@dataclass(frozen=True, kw_only=True)
class Initial:
    """Where the boat starts; what is left out is the vessel file's, the course north."""

    speed_kn: float | None = optional(Quantity("kn", within(0.001, 60), "speed"))
    depth_m: float | None = optional(Quantity("m", within(0, 12000), "depth"))
    course_deg: float | None = optional(Quantity("deg", within(0, 360), "course"))


@dataclass(frozen=True, kw_only=True)
class OrderRow:
    """One order and its time."""

    at_s: float = of(Quantity("s", within(0, LATEST), "time from the start"))
    order: str = of(Text(80, "as it is typed"))


@dataclass(frozen=True, kw_only=True)
class CasualtyRow:
    """Something that breaks, at a time or when a condition comes to hold."""

    name: str = of(Text(40, "as `trainer casualties` lists it"))
    severity: float | None = optional(Quantity("-", within(-10, 10), "else the table's"))
    ramp_s: float | None = optional(Quantity("s", within(0, 3600), "else the table's"))
    at_s: float | None = optional(Quantity("s", within(0, LATEST), "time from the start"))
    when: str | None = optional(Text(79, "condition, instead of at_s"))
    rule: str | None = optional(Choice(("once", "again"), "how often, with when; else once"))
    clear_at_s: float | None = optional(Quantity("s", within(0, LATEST), "when it is cleared"))


ORDERS: Final = Rows(OrderRow, ("note",), 0, 500, "scheduled orders, below")
CASUALTIES: Final = Rows(CasualtyRow, ("note",), 0, 20, "what breaks, below")

RECORDS: Final = {
    "": Heading,
    "initial": Initial,
    "[orders]": OrderRow,
    "[casualties]": CasualtyRow,
    "limits": Limits,
    "[scores]": Score,
}


def key_tables() -> str:
    """Return the Markdown tables of every key, as docs/exercises.md shows them."""
    return tables_of(RECORDS)
