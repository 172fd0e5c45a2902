"""The targets that read recordings: spoilt files, and headers of anybody's making."""

import contextlib
import functools
import json
from contextlib import suppress
from pathlib import Path
from typing import Any, Final

from faults import recordings
from helpers.givers import HELM

from fuzz.fuzz import Target, folder, shipped_texts, text_of, write_file
from trainer.boat.assemble import Method
from trainer.boat.boat import Boat
from trainer.config.boat.vessel import load_vessel
from trainer.config.files import ConfigError
from trainer.debrief.passage.recording_export import table_layout
from trainer.io.recording.recording import Moment, Recording, RecordingError
from trainer.session.past.header import (
    PLAN_FORMAT,
    differences,
    layout_of,
    method_of,
    notes,
    plan_of,
)
from trainer.session.past.layout import LAYOUT
from trainer.units import KNOT

PATCH: Final = 4  # [bytes]  three of a place, one to stand there
TICKS: Final = 8
LINE: Final = 400  # [bytes] of a header's line in an example
DECLARED: Final = ConfigError, RecordingError
OPTIONS: Final[dict[str, Any]] = {
    "exercise": None,
    "vessel": "sdv-mk9",
    "sea": None,
    "seed": 1,
    "orders_file": None,
    "duration": 10.0,
    "equations": "modified",
    "rates": None,
    "trig": "exact",
    "integrator": "adams2",
    "step": None,
    "given": ["vessel"],
}


def header() -> dict[str, str]:
    """Return the header of a recording as this version makes it."""
    return {
        "plan": PLAN_FORMAT,
        "trainer": "0",
        "core": "0",
        "options": json.dumps(OPTIONS),
        "texts": json.dumps({"configs/vessels/x.toml": "schema = 1"}),
        "method": json.dumps(
            {
                "equations": "modified",
                "rates": "lagged",
                "trig": "exact",
                "integrator": "adams2",
                "step": 0.5,
            }
        ),
        "layout": json.dumps(LAYOUT),
        "vessel": json.dumps("configs/vessels/sdv-mk9.toml"),
        "seed": "1",
    }


@functools.cache
def good() -> bytes:
    """Return a recording of a few ticks, orders, a snapshot and two branches."""
    path = Path(folder().name) / "good.trainer"
    boat = Boat(load_vessel("sdv-mk9"), Method("modified", "lagged", "exact", "adams2", 0.5))
    boat.start(4 * KNOT, 20.0, 0.0)
    key = "configs/vessels/sdv-mk9.toml"
    told = {**header(), "texts": json.dumps({key: shipped_texts()[key]})}  # more than a page
    with contextlib.closing(
        Recording.create(path, told, boat.records.state.tobytes())
    ) as recording:
        for branch in (1, 2):
            for tick in range(1, TICKS):
                boat.tick()
                recording.state(tick, boat.records.state.tobytes())
                recording.timing(tick, 1, 2)
            order = recording.order(tick, HELM, "rudder left 5")
            recording.answered(order, "rudder left 5, by hand", accepted := branch == 1)
            recording.snapshot("here", Moment(branch, tick, b"", order, 0))
            if accepted:
                recording.fork(Moment(1, tick, boat.records.state.tobytes(), order, 0), "again")
    return path.read_bytes()


def spoil(data: bytes) -> bytes:
    """Return the good recording with places overwritten. It is cut short if a byte is over."""
    made = bytearray(good())
    for i in range(0, len(data) - PATCH + 1, PATCH):
        made[int.from_bytes(data[i : i + PATCH - 1], "big") % len(made)] = data[i + PATCH - 1]
    over = data[len(data) - len(data) % PATCH :]
    return bytes(made[: len(made) * over[0] // 256] if over else made)


def recording(data: bytes) -> None:
    """Read all that there is in a spoilt recording."""
    read_all(write_file("spoilt.trainer", spoil(data)))


def read_all(path: Path) -> None:
    """Read all of a recording, or the message of what is wrong."""
    with suppress(*DECLARED), contextlib.closing(Recording.look(path)) as looked:
        for branch in looked.branches():
            with suppress(*DECLARED):
                list(looked.orders(branch.id))
                list(looked.ledger(branch.id))
                layout = table_layout(looked)
                for tick in looked.flown(branch.id):
                    layout.numbers(tick.state)
        looked.snapshots()
        list(looked.events())
        looked.latest()


def alter(data: bytes) -> None:
    """Read all of a recording with changed rows and tables, three bytes a change."""
    path = write_file("altered.trainer", good())
    for i in range(0, len(data) - 2, 3):
        recordings.alter(path, *data[i : i + 3])
    read_all(path)


def log_book(data: bytes) -> None:
    """Read the header of a recording with some of its lines replaced: NAME=VALUE each."""
    pairs = (line.partition("=") for line in text_of(data).split("\n"))
    told = header() | {name: value for name, equals, value in pairs if equals}
    for read in (plan_of, method_of, layout_of, differences, notes):
        with suppress(ConfigError):
            read(told)


def patches() -> list[bytes]:
    """Return bytes that spoil the header of the file, of a page, and its end."""
    size = len(good())
    places = (0, 18, 100, 8192, 8200, size // 2, size - 1)
    return [b"".join(at.to_bytes(3, "big") + b"\x41" for at in places), b"\x80", b""]


def changes() -> list[bytes]:
    """Return a change of each table, and one of what the file is made of."""
    return [bytes((table, 1, value)) for table in range(7) for value in (0, 3, 9)] + [
        b"\xff\x00\x00"
    ]


def header_lines() -> list[bytes]:
    """Return the lines of a header, one at a time, and short ones together."""
    lines = [f"{name}={value}"[:LINE].encode() for name, value in header().items()]
    return [*lines, b"\n".join(line for line in lines if len(line) < LINE // 4)]


TARGETS: Final = (
    Target("recording", "a recording, spoilt somewhere", recording, patches, 64),
    Target("altered", "a recording with other rows and tables", alter, changes, 24),
    Target("log-book", "the header of a recording", log_book, header_lines, LINE),
)
