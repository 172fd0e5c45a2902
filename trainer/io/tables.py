"""A recording as tables for other programs: CSV, or Parquet where pyarrow is installed.

``trainer export`` and ``trainer run --csv`` write by it. Three files: the states at the path given,
orders and events beside it, as in `out.csv`, `out.orders.csv`, `out.events.csv`. States and orders
are those of one branch and the ancestry that led to it; events are those of all branches. A
`Layout` tells what the bytes of a state mean, because this package does not know the boat. All
numbers are in SI and radians, with every digit.
"""

import csv
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import Any, Final, Protocol

from trainer.io.outputs import open_output, replacing
from trainer.io.recording.recording import RecordedEvent, Recording, RecordingError

BATCH_ROWS: Final = 5000  # [rows] of a Parquet file written at once

# How a formula of a spreadsheet begins.
FORMULA_SIGNS: Final = ("=", "+", "-", "@", "\t", "\r")

Cell = int | float | str | bool | None

MOMENT_COLUMNS: Final = {"branch": int, "tick": int, "t": float}  # where in the run; t [s]
TIMING_COLUMNS: Final = {"lateness_ns": int, "work_ns": int}
ORDER_COLUMNS: Final = {"who": str, "text": str, "place": int, "accepted": bool, "answer": str}
EVENT_COLUMNS: Final = {"wall": str, "kind": str, "who": str, "text": str}
MOTION_COLUMNS: Final = (
    "tick",
    "t",
    "u",
    "v",
    "w",
    "p",
    "q",
    "r",
    "x",
    "y",
    "z",
    "phi",
    "theta",
    "psi",
    "delta_r",
    "delta_s",
    "delta_b",
    "u_c",
    "weight",
    "x_g",
    "z_g",
    "eta_wave",
    "validity",
)


@dataclass(frozen=True)
class Layout:
    """How the bytes of a state become numbers."""

    columns: tuple[str, ...]
    numbers: Callable[[bytes], Sequence[float]]  # one for each column
    step: float  # [s] from tick to tick


@dataclass(frozen=True)
class Table:
    """Rows on their way out, each with a cell for every column. Any cell may be missing."""

    columns: dict[str, type]
    rows: Iterator[Sequence[Cell]]


def export_csv(
    recording: Recording, layout: Layout, path: Path, branch: int | None = None
) -> list[Path]:
    """Write a branch, by default the latest, as CSV; return the files written.

    Files of these names are replaced. RecordingError if one cannot be written.
    """
    return _export(recording, layout, path, branch, _write_csv)


def export_parquet(
    recording: Recording, layout: Layout, path: Path, branch: int | None = None
) -> list[Path]:
    """Write a branch, by default the latest, as Parquet; return the files written.

    Files of these names are replaced. RecordingError if one cannot be written, or pyarrow is
    missing.
    """
    try:
        import pyarrow.parquet  # noqa: F401, PLC0415 - half a second, and not always there
    except ImportError:
        raise RecordingError(
            "Parquet needs pyarrow: pip install 'submarine-trainer[parquet]'"
        ) from None
    return _export(recording, layout, path, branch, _write_parquet)


def states_table(recording: Recording, layout: Layout, branch: int) -> Table:
    """Return one row for each tick, SI and radians; timings [ns] where they were measured."""
    columns = {**MOMENT_COLUMNS, **dict.fromkeys(layout.columns, float), **TIMING_COLUMNS}

    def rows() -> Iterator[Sequence[Cell]]:
        for tick in recording.flown(branch):
            numbers = layout.numbers(tick.state)
            time = tick.tick * layout.step
            yield (tick.branch, tick.tick, time, *numbers, tick.lateness, tick.work)

    return Table(columns, rows())


def orders_table(recording: Recording, layout: Layout, branch: int) -> Table:
    """Return one row for each order; `place` is that in the schedule of the exercise."""
    rows = (
        (
            order.id,
            order.branch,
            order.tick,
            order.tick * layout.step,
            order.who,
            order.text,
            order.entry,
            order.accepted,
            order.answer,
        )
        for order in recording.orders(branch)
    )
    return Table({"id": int, **MOMENT_COLUMNS, **ORDER_COLUMNS}, rows)


def events_table(events: Iterable[RecordedEvent], layout: Layout) -> Table:
    """Return one row for each event. `wall` is the time of day, UTC."""
    rows = (
        (
            event.branch,
            event.tick,
            event.tick * layout.step,
            event.wall,
            event.kind,
            event.who,
            event.text,
        )
        for event in events
    )
    return Table({**MOMENT_COLUMNS, **EVENT_COLUMNS}, rows)


def _export(
    recording: Recording,
    layout: Layout,
    path: Path,
    branch: int | None,
    write: Callable[[Table, Path], None],
) -> list[Path]:
    chosen = recording.branch if branch is None else branch
    tables = {path: states_table(recording, layout, chosen)}
    if path.is_file() or not path.exists():  # a pipe has nothing beside it
        tables[_beside(path, "orders")] = orders_table(recording, layout, chosen)
        tables[_beside(path, "events")] = events_table(recording.first_events(), layout)
    for name, table in tables.items():
        try:
            with replacing(name) as made:
                write(table, made)
        except OSError as error:
            reason = error.strerror or str(error)
            raise RecordingError(f"{name} cannot be written whole: {reason}") from None
    return list(tables)


def _beside(path: Path, noun: str) -> Path:
    return path.with_name(f"{path.stem}.{noun}{path.suffix}")


def _write_csv(table: Table, path: Path) -> None:
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(table.columns)
        writer.writerows([_inert(cell) for cell in row] for row in table.rows)


def _inert(cell: Cell) -> Cell:
    """Return a cell with an apostrophe before what a spreadsheet would take for a formula.

    A text of the crew could run one there. Numbers with a sign stay as they are.
    """
    if not (isinstance(cell, str) and cell.startswith(FORMULA_SIGNS)):
        return cell
    try:
        float(cell)
    except ValueError:
        return f"'{cell}"
    return cell


def _write_parquet(table: Table, path: Path) -> None:
    """Write some rows at a time: a recording may be longer than the memory."""
    import pyarrow as pa  # noqa: PLC0415
    import pyarrow.parquet as pq  # noqa: PLC0415

    kinds: dict[type, Any] = {int: pa.int64(), float: pa.float64(), str: pa.string()}
    kinds[bool] = pa.bool_()
    schema = pa.schema([(name, kinds[kind]) for name, kind in table.columns.items()])
    with pq.ParquetWriter(path, schema) as file:
        while rows := list(islice(table.rows, BATCH_ROWS)):
            columns = [
                pa.array(cells, field.type)
                for cells, field in zip(zip(*rows, strict=True), schema, strict=True)
            ]
            file.write_table(pa.table(columns, schema=schema))


class ColumnSink(Protocol):
    """A place that takes the columns of each tick."""

    trouble: str

    def row(self, values: Sequence[float]) -> None:
        """Take the columns of one tick."""


class CsvFile:
    """A CSV file of ticks. It keeps trouble with the disk as a text, so that the run goes on."""

    def __init__(self, path: Path, batch: int = 1) -> None:
        """Open ``path``, to be written ``batch`` rows at once; OSError if it cannot be."""
        self.path = path
        self.trouble = ""  # why no more are written
        self._batch = batch
        # Unbuffered, because ``flush`` must know how many rows are whole when the disk is full.
        self._file = open_output(path)
        self._lines = [",".join(MOTION_COLUMNS) + "\n"]
        self._written = 0  # lines on disk, the heading among them

    def row(self, values: Sequence[float]) -> None:
        """Take one row: the tick, then the other columns."""
        numbers = ",".join(map(repr, values[1:]))
        self._lines.append(f"{values[0]:.0f},{numbers}\n")
        if len(self._lines) >= self._batch:
            self.flush()

    def flush(self) -> None:
        """Write what has been taken."""
        data = "".join(self._lines).encode("ascii")
        self._lines.clear()
        if self.trouble:
            return
        done = 0
        try:
            while done < len(data):
                done += self._file.write(data[done:])
        except OSError as error:
            self._written += data.count(b"\n", 0, done)
            rows = max(self._written - 1, 0)
            self.trouble = f"{self.path}: {error.strerror}; {rows} rows are whole"
        else:
            self._written += data.count(b"\n")

    def close(self) -> None:
        """Write what is left and close."""
        self.flush()
        self._file.close()


class NoFile:
    """A place that drops all columns, so that a run needs no ``if``."""

    trouble = ""

    def row(self, values: Sequence[float]) -> None:
        """Drop it."""

    def close(self) -> None:
        """Do nothing."""
