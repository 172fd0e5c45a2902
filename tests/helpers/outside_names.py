"""The names that others have: on disk, on the wire, in files that people write.

A name in the code may be changed at any time; one of these is a promise.
``python -m helpers.outside_names`` in ``tests/`` writes the list anew: who does so takes a promise
back, and says it in CHANGELOG.md.
"""

import json
import re
from contextlib import closing
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Final

import click

from helpers.places import ROOT
from helpers.recorded import record
from trainer.cli.main import EARLIER_NAMES, cli
from trainer.cli.schema import SCHEMA_MODULES, schema_of
from trainer.config.exercise.check_case import CASE_CHANNELS, TIME_COLUMN
from trainer.core.casualties import KINDS
from trainer.debrief.page.data import debrief_figures, gather_debrief
from trainer.io.orders.sentences import FACTS
from trainer.io.orders.words import ORDER_WORDS
from trainer.io.recording.file import SCHEMA
from trainer.io.recording.recording import Recording
from trainer.io.tables import (
    EVENT_COLUMNS,
    MOMENT_COLUMNS,
    MOTION_COLUMNS,
    ORDER_COLUMNS,
    TIMING_COLUMNS,
)
from trainer.session.past.layout import LAYOUT
from trainer.session.stations.channels import CHANNELS
from trainer.session.stations.roles import ROLES

LIST: Final = ROOT / "tests" / "data" / "outside_names.json"
TABLE: Final = re.compile(r"CREATE TABLE (\w+) \((.*?)\n?\)(?: WITHOUT ROWID)?;", re.DOTALL)
COLUMN: Final = re.compile(r"(\w+) (?:TEXT|INTEGER|BLOB)\b")


def outside_names() -> dict[str, Any]:
    """Return all names that are not ours alone, by where they stand."""
    return {
        "orders": sorted(ORDER_WORDS),
        "commands": sorted(commands_below(cli)) + sorted(EARLIER_NAMES),
        "facts": sorted(FACTS),
        "roles": sorted(ROLES),
        "channels": {
            name: [field.name for field in channel.fields] for name, channel in CHANNELS.items()
        },
        "casualties": list(KINDS),
        "state": sorted({name.partition("[")[0] for name in LAYOUT}),
        "tables": [
            *MOMENT_COLUMNS,
            *TIMING_COLUMNS,
            *ORDER_COLUMNS,
            *EVENT_COLUMNS,
            *MOTION_COLUMNS,
        ],
        "check cases": [TIME_COLUMN, *CASE_CHANNELS],
        "recording": {name: COLUMN.findall(body) for name, body in TABLE.findall(SCHEMA)},
        **of_a_recording(),
        "files": {kind: keys_of(schema_of(kind)) for kind in SCHEMA_MODULES},
    }


def commands_below(group: click.Group) -> list[str]:
    """Return what is typed for each command of a group, without the earlier names."""
    found = []
    for name, command in group.commands.items():
        below = command.commands if isinstance(command, click.Group) else {}
        found += [name, *(f"{name} {each}" for each in below)]
    return found


def of_a_recording() -> dict[str, list[str]]:
    """Return the keys of a recording's header, and of a debrief's figures."""
    with TemporaryDirectory() as folder:
        path = record(Path(folder) / "run.trainer", "depth-changes", {61.0: "depth 100 aye"})
        with closing(Recording.look(path)) as recording:
            debrief = debrief_figures(gather_debrief(recording, path, None))
            return {"header": sorted(recording.header()), "debrief": paths_of(debrief)}


def paths_of(value: Any, before: str = "") -> list[str]:
    """Return the paths of all keys in JSON, sorted; the entries of a list share theirs."""
    if isinstance(value, dict):
        inner = [paths_of(each, f"{before}/{key}") for key, each in value.items()]
        return sorted({path for paths in inner for path in paths} | {before} - {""})
    if isinstance(value, list | tuple):
        return sorted({path for each in value for path in paths_of(each, before)} | {before})
    return [before]


def keys_of(schema: Any) -> list[str]:
    """Return the keys that a JSON Schema names, sorted."""
    if isinstance(schema, list):
        return sorted({key for each in schema for key in keys_of(each)})
    if not isinstance(schema, dict):
        return []
    own = set(schema["properties"]) if isinstance(schema.get("properties"), dict) else set()
    return sorted(own | {key for each in schema.values() for key in keys_of(each)})


if __name__ == "__main__":
    LIST.write_text(json.dumps(outside_names(), indent=1) + "\n", encoding="utf-8")
