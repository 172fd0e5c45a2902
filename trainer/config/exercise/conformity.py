"""What STCW asks of a simulator, and what of it is here, by configs/conformity.toml.

A line that says "has" names the test that shows it; any other says what lacks, or why it is not
asked for here.
"""

from dataclasses import dataclass
from typing import Any, Final

from trainer.config.files import (
    ConfigError,
    Position,
    number_problems,
    parse_toml,
    raise_problems,
    read_text,
    shipped_path,
)
from trainer.config.schema import Choice, Rows, Text, optional, read_record, required
from trainer.io.orders.grammar import Refused

FULLY_MET: Final = "has"
IN_PART: Final = "in part"
OUT_OF_SCOPE: Final = "out of scope"
LINE_STATES: Final = (FULLY_MET, IN_PART, OUT_OF_SCOPE)
CLOSING_DECLARATION: Final = "Self-declared, not certified."


@dataclass(frozen=True, kw_only=True)
class ConformityLine:
    """One thing that the code asks for."""

    section: str = required(Text(30, "of the STCW Code"))
    asks: str = required(Text(200, "what it asks for, in our words"))
    state: str = required(Choice(LINE_STATES, "whether it is here"))
    how: str = required(Text(300, "what there is; of what is out of scope, why"))
    lacks: str | None = optional(Text(300, "what is not there"))
    test: str | None = optional(Text(200, "FILE::NAME below tests/ that shows it"))
    page: str | None = optional(Text(100, "page of the documents, with its heading"))
    read: str | None = optional(Text(100, "where number and demand were read; none: from memory"))


UNREAD_MARK: Final = "not checked"  # stands by a number that was not read in the code
LINE_ROWS: Final = Rows(ConformityLine, ("note",), 1, 200, "what is asked for")


@dataclass(frozen=True, kw_only=True)
class Conformity:
    """All lines of the file."""

    schema: str = required(Choice(("conformity/1",), "form of the file"))
    lines: tuple[ConformityLine, ...] = required(LINE_ROWS)


def load_conformity() -> tuple[ConformityLine, ...]:
    """Return the shipped lines; ConfigError with all that is wrong."""
    path = shipped_path("", "conformity")
    return parse_conformity(read_text(path), path.name)


def parse_conformity(text: str, file: str) -> tuple[ConformityLine, ...]:
    """Return the lines of a text; ConfigError naming the line of what is wrong."""
    position = Position(file, "")
    table: dict[str, Any] = parse_toml(text, file)
    try:
        lines = read_record(Conformity, table, position, ()).lines
        raise_problems(
            [
                position.inside(f"lines[{i}]").wrong("state", line.state, refused.reason)
                for i, line in enumerate(lines)
                if (refused := _lacking(line))
            ]
        )
    except ConfigError as wrong:
        raise ConfigError(*number_problems(wrong.problems, text, file)) from None
    return lines


def _lacking(line: ConformityLine) -> Refused | None:
    """Return what a line of its state should say and does not, None if nothing."""
    if line.state == FULLY_MET and not line.test:
        return Refused("names no test that shows it")
    if line.state == FULLY_MET and line.lacks:
        return Refused("lacks nothing; say in part")
    silent = line.state == IN_PART and not line.lacks
    return Refused("must say what it lacks") if silent else None
