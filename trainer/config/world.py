"""The world around the boat in an exercise. Each of its tables has its own reader."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Final

from trainer.config.bottom import BottomTable, read_bottom
from trainer.config.contacts import (
    CONTACT_RECORDS,
    contacts_schema,
    encounters_schema,
    read_contacts,
    read_encounters,
)
from trainer.config.current import current_schema, read_current
from trainer.config.files import ConfigError, Place, collecting
from trainer.config.schema import record_schema

# by the name of the table: from what it holds, its place, and the exercise's path to a record
READERS: Final[Mapping[str, Callable[[object, Place, Path], Any]]] = {
    "bottom": read_bottom,
    "contact": read_contacts,
    "contacts": read_encounters,
    "current": read_current,
}

SCHEMAS: Final[Mapping[str, Callable[[], dict[str, Any]]]] = {
    "contact": contacts_schema,
    "contacts": encounters_schema,
    "current": current_schema,
    "bottom": lambda: record_schema(BottomTable, ("note",)),
}
WORLD_RECORDS: Final[Mapping[str, type[Any]]] = {
    **CONTACT_RECORDS,
    "bottom": BottomTable,
}  # for their keys
WorldTables = Mapping[str, Any]  # records, by the names of their tables


def read_world(table: Mapping[str, Any], path: Path) -> WorldTables:
    """Return what an exercise's tables say of the world; ConfigError with all that is wrong."""
    problems: list[str] = []
    found = {}
    for name, read in READERS.items():
        with collecting(problems):
            if name in table:
                found[name] = read(table[name], Place(path.name, name), path)
    if problems:
        raise ConfigError(*problems)
    return found
