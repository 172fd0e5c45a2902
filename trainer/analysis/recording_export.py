"""A recording for other programs: tables, arrays and frames, Rerun's viewer, columns drawn."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import click
import numpy as np

from trainer.analysis.series import FEWEST, Series, load_series
from trainer.config.extras import require_library
from trainer.config.files import ConfigError, nearest, quote
from trainer.core.kernel import Numbers
from trainer.io.recording import recording as recording_file
from trainer.io.recording.queries import Excess
from trainer.io.tables import (
    Cell,
    Layout,
    Table,
    events_table,
    export_csv,
    export_parquet,
    orders_table,
    states_table,
)
from trainer.report.columns import DEPTH_COLUMNS, page_unit
from trainer.report.plots import Curve, Panel, draw
from trainer.session.header import layout_of, method_of, reading, trainees_of
from trainer.session.layout import numbers_of

USUAL: Final = ("z", "theta", "u")  # drawn unless other columns are asked for


def export_file(path: Path, wanted: Mapping[str, Path | None], branch: int | None) -> None:
    """Write the forms ``wanted``, csv, parquet or rrd, and print the names of the files.

    ConfigError if they cannot be written.
    """
    chosen = {form: out for form, out in wanted.items() if out is not None}
    if not chosen:
        forms = "--csv FILE, --parquet FILE, --rrd FILE or --plot FILE"
        raise ConfigError(f"{path}: export to what? say {forms}")
    if is_csv(path):
        raise ConfigError(f"{path}: is a table already; of a CSV file only --plot FILE is made")
    written: list[Path] = []
    with reading(path) as recording:
        for form, out in chosen.items():
            written += WRITERS[form](recording, out, branch)
        tell_excess(path, recording.excess())
    click.echo("\n".join(map(str, written)))


def tell_excess(path: Path, excess: Iterable[Excess]) -> None:
    """Print of what a recording has more than is read of it."""
    for each in excess:
        click.echo(f"trainer: {path}: {each}", err=True)


def is_csv(path: Path) -> bool:
    """Return whether a path is that of a CSV file, not of a recording."""
    return path.suffix.lower() == ".csv"


def draw_run(path: Path, out: Path, columns: Sequence[str], branch: int | None) -> None:
    """Draw columns of a recording or a CSV file over time. Print the plot's name.

    Names with commas between share a panel. ConfigError if there is no such column, or no plot
    can be written.
    """
    shown = [[name.strip() for name in names.split(",")] for names in columns or USUAL]
    wanted = list(dict.fromkeys(name for names in shown for name in names))
    series = load_series(path) if is_csv(path) else recorded_series(path, wanted, branch)
    draw(tuple(panel_of(series, names) for names in shown), out)
    click.echo(str(out))


def recorded_series(path: Path, names: Sequence[str], branch: int | None) -> Series:
    """Return those columns of a recording's branch, and the time.

    ConfigError if it has no such column, or fewer than two states.
    """
    with reading(path) as recording:
        layout = table_layout(recording)
        for name in names:
            if name not in layout.columns:
                near = nearest(name, layout.columns)
                raise ConfigError(f"{path}: no column {quote(name)}{near}")
        places = [layout.columns.index(name) for name in names]
        rows = []
        for flown in recording.flown(recording.branch if branch is None else branch):
            numbers = layout.numbers(flown.state)
            rows.append([flown.tick * layout.step, *(numbers[i] for i in places)])
    if len(rows) < FEWEST:
        raise ConfigError(f"{path}: has {len(rows)} states; a plot needs {FEWEST} or more")
    table = np.array(rows).T
    return Series(path, {"t": table[0], **dict(zip(names, table[1:], strict=True))})


def panel_of(series: Series, names: Sequence[str]) -> Panel:
    """Return columns over time on one pair of axes; ConfigError if their units differ."""
    columns = [series.column(name) for name in names]
    units = list(dict.fromkeys(page_unit(name)[1] for name in names))
    if len(units) > 1:
        raise ConfigError(
            f"--column {','.join(names)}: {' and '.join(units)} do not share an axis; give "
            "--column once for each"
        )
    curves = tuple(
        Curve(name, series.t, page_unit(name)[0] * values)
        for name, values in zip(names, columns, strict=True)
    )
    title = ", ".join(names)
    return Panel(
        title,
        "time [s]",
        f"{title} [{units[0]}]",
        curves,
        downwards=DEPTH_COLUMNS.issuperset(names),
    )


def csv_files(recording: recording_file.Recording, path: Path, branch: int | None) -> list[Path]:
    """Write a branch as CSV; return the files written."""
    return export_csv(recording, table_layout(recording), path, branch)


def parquet_files(
    recording: recording_file.Recording, path: Path, branch: int | None
) -> list[Path]:
    """Write a branch as Parquet; return the files written."""
    return export_parquet(recording, table_layout(recording), path, branch)


def rrd_file(recording: recording_file.Recording, path: Path, branch: int | None) -> list[Path]:
    """Write a branch as a file for Rerun; return the file written."""
    require_library("rerun", "--rrd")
    from trainer.session.rerun.request import write_record  # noqa: PLC0415  a second to import

    try:
        write_record(recording, path, recording.branch if branch is None else branch)
    except OSError as error:
        raise ConfigError(f"--rrd {path}: {error.strerror}") from None
    return [path]


WRITERS: Final = {"csv": csv_files, "parquet": parquet_files, "rrd": rrd_file}


def table_layout(recording: recording_file.Recording) -> Layout:
    """Return how the recorded states are read, each number under its name.

    Its ``numbers`` raises ConfigError if a state is damaged.
    """
    header = recording.header()
    names = layout_of(header)
    wanted = [i for i, name in enumerate(names) if name != "tick"]

    def numbers(state: bytes) -> Sequence[float]:
        whole: list[float] = numbers_of(state, names).tolist()
        return [whole[i] for i in wanted]

    return Layout(tuple(names[i] for i in wanted), numbers, method_of(header).step)


@dataclass(frozen=True, repr=False)
class Recording:
    """A recording read as arrays: one branch of it, with what led there.

    ``columns`` has one array for each column of ``trainer export --csv``, in SI units and radians:
    ``t`` [s], ``z`` [m], ``theta`` [rad], and so on. A time [ns] that nobody measured is NaN.
    ``orders`` and ``events`` are lists of dicts with the keys of the CSV files beside it. Events
    are those of all branches. ``branch`` is its number, ``step`` [s] the time from tick to tick,
    ``trainees`` the names of who was trained, ``path`` the file.
    """

    path: Path
    branch: int
    step: float  # [s]
    trainees: tuple[str, ...]
    columns: dict[str, Numbers]
    orders: list[dict[str, Cell]]
    events: list[dict[str, Cell]]

    def __getitem__(self, name: str) -> Numbers:
        """Return a column by its name; TrainerError with the nearest name if there is none."""
        if name not in self.columns:
            raise ConfigError(f"{self.path}: no column {quote(name)}{nearest(name, self.columns)}")
        return self.columns[name]

    def frame(self) -> Any:
        """Return the columns as a pandas frame, with the time ``t`` [s] as its index.

        TrainerError where pandas is not installed; the extra ``pandas`` brings it.
        """
        return frame_of(self.columns)

    def __repr__(self) -> str:
        last = self.columns["t"][-1]
        told = f"branch {self.branch}, {len(self.columns['t'])} states to {last:g} s"
        return f"{self.path}: {told}, {len(self.orders)} orders, {len(self.events)} events"


def read_recording(path: str | Path, branch: int | None = None) -> Recording:
    """Return a recording as arrays, by default its latest branch.

    ``path`` is a file that ``trainer run --record`` or ``Boat(record=...)`` has written.
    TrainerError if it cannot be read, or has no such branch.
    """
    with reading(Path(path)) as recording:
        layout = table_layout(recording)
        chosen = recording.branch if branch is None else branch
        return Recording(
            path=Path(path),
            branch=chosen,
            step=layout.step,
            trainees=trainees_of(recording.header()),
            columns=_arrays(states_table(recording, layout, chosen)),
            orders=_dicts(orders_table(recording, layout, chosen)),
            events=_dicts(events_table(recording.events(), layout)),
        )


def frame_of(columns: Mapping[str, Numbers]) -> Any:
    """Return columns as a pandas frame, by the time ``t`` [s] if there is one.

    ConfigError where pandas is not installed.
    """
    require_library("pandas", "a frame")
    import pandas as pd  # noqa: PLC0415  half a second

    frame = pd.DataFrame(dict(columns))
    return frame.set_index("t") if "t" in columns else frame


def _arrays(table: Table) -> dict[str, Numbers]:
    """Return the columns of a table of numbers; what is missing is NaN."""
    flat = (math.nan if cell is None else float(cell) for row in table.rows for cell in row)
    whole = np.fromiter(flat, np.float64).reshape(-1, len(table.columns))
    return {name: whole[:, place].copy() for place, name in enumerate(table.columns)}


def _dicts(table: Table) -> list[dict[str, Cell]]:
    """Return the rows of a table, each with the names of its columns."""
    return [dict(zip(table.columns, row, strict=True)) for row in table.rows]
