"""``trainer export``: a recording for other programs, as tables, arrays, frames or pictures.

``cli/recordings`` calls ``export_file`` and ``panels_of_run``; ``Recording`` is the face for
Python, ``trainer.Recording``. Nobody else has to know how states lie in a recording.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import click
import numpy as np

from trainer.config.extras import require_library
from trainer.config.files import ConfigError, nearest, quote
from trainer.config.ship.series import MIN_ROWS, Series, load_series
from trainer.core.kernel import Numbers
from trainer.io.mcap import export_mcap
from trainer.io.recording import recording as recording_file
from trainer.io.tables import (
    Cell,
    Layout,
    events_table,
    export_csv,
    export_parquet,
    orders_table,
    states_table,
)
from trainer.report.columns import DEPTH_COLUMNS, page_unit
from trainer.report.plots import Curve, Panel
from trainer.session.past.header import layout_of, method_of, open_whole_recording, trainees_of
from trainer.session.past.layout import numbers_of

FORM_LIBRARIES: Final = {"parquet": "pyarrow", "rrd": "rerun", "mcap": "mcap"}  # of forms
TABLE_WRITERS: Final = {"csv": export_csv, "parquet": export_parquet, "mcap": export_mcap}
USUAL_COLUMNS: Final = ("z", "theta", "u")  # drawn unless other columns are asked for


def export_file(path: Path, wanted: Mapping[str, Path | None], branch: int | None) -> None:
    """Write the forms ``wanted``, csv to mcap, and print the names of the files.

    ConfigError if they cannot be written.
    """
    chosen = {form: out for form, out in wanted.items() if out is not None}
    if not chosen:
        forms = "--csv FILE, --parquet FILE, --rrd FILE, --mcap FILE or --plot FILE"
        raise ConfigError(f"{path}: export to what? say {forms}")
    if path.suffix.lower() == ".csv":
        raise ConfigError(f"{path}: is a table already; of a CSV file only --plot FILE is made")
    for form in chosen.keys() & FORM_LIBRARIES.keys():  # before any file is written
        require_library(FORM_LIBRARIES[form], f"--{form}")
    written: list[Path] = []
    with open_whole_recording(path) as recording:
        for form, out in chosen.items():
            if form == "rrd":
                from trainer.session.rerun.request import write_record  # noqa: PLC0415  a second to import

                try:
                    write_record(recording, out, recording.branch if branch is None else branch)
                except OSError as error:
                    raise ConfigError(f"--rrd {out}: {error.strerror}") from None
                written.append(out)
            else:
                write = TABLE_WRITERS[form]
                written += write(recording, table_layout(recording), out, branch)
        for problem in recording.excess():
            click.echo(f"trainer: {path}: {problem}", err=True)
    click.echo("\n".join(map(str, written)))


def panels_of_run(path: Path, columns: Sequence[str], branch: int | None) -> tuple[Panel, ...]:
    """Return panels of columns of a recording or a CSV file over time.

    Names with commas between share a panel. ConfigError if there is no such column, or no library
    that draws it.
    """
    require_library("matplotlib", "--plot")
    shown = [[name.strip() for name in names.split(",")] for names in columns or USUAL_COLUMNS]
    wanted = list(dict.fromkeys(name for names in shown for name in names))
    table = path.suffix.lower() == ".csv"
    series = load_series(path) if table else recorded_series(path, wanted, branch)
    return tuple(panel_of(series, names) for names in shown)


def recorded_series(path: Path, names: Sequence[str], branch: int | None) -> Series:
    """Return those columns of a recording's branch, and the time.

    ConfigError if it has no such column, or fewer than two states.
    """
    with open_whole_recording(path) as recording:
        layout = table_layout(recording)
        for name in names:
            if name not in layout.columns:
                near = nearest(name, layout.columns)
                raise ConfigError(f"{path}: no column {quote(name)}{near}")
        indices = [layout.columns.index(name) for name in names]
        rows = []
        for flown in recording.flown(recording.branch if branch is None else branch):
            numbers = layout.numbers(flown.state)
            rows.append([flown.tick * layout.step, *(numbers[i] for i in indices)])
    if len(rows) < MIN_ROWS:
        raise ConfigError(f"{path}: has {len(rows)} states; a plot needs {MIN_ROWS} or more")
    table = np.array(rows).T
    return Series(path, {"t": table[0], **dict(zip(names, table[1:], strict=True))})


def panel_of(series: Series, names: Sequence[str]) -> Panel:
    """Return columns over time on one pair of axes; ConfigError if their units differ."""
    units = list(dict.fromkeys(page_unit(name)[1] for name in names))
    if len(units) > 1:
        raise ConfigError(
            f"--column {','.join(names)}: {' and '.join(units)} do not share an axis; give "
            "--column once for each"
        )
    curves = tuple(
        Curve(name, series.t, page_unit(name)[0] * series.column(name)) for name in names
    )
    title, lower = ", ".join(names), DEPTH_COLUMNS.issuperset(names)
    return Panel(title, "time [s]", f"{title} [{units[0]}]", curves, downwards=lower)


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
        content = f"branch {self.branch}, {len(self.columns['t'])} states to {last:g} s"
        return f"{self.path}: {content}, {len(self.orders)} orders, {len(self.events)} events"


def read_recording(path: str | Path, branch: int | None = None) -> Recording:
    """Return a recording as arrays, by default its latest branch.

    ``path`` is a file that ``trainer run --record`` or ``Boat(record=...)`` has written.
    TrainerError if it cannot be read, or has no such branch.
    """
    with open_whole_recording(Path(path)) as recording:
        layout = table_layout(recording)
        chosen = recording.branch if branch is None else branch
        states = states_table(recording, layout, chosen)
        flat = (math.nan if cell is None else float(cell) for row in states.rows for cell in row)
        whole = np.fromiter(flat, np.float64).reshape(-1, len(states.columns))
        tables = orders_table(recording, layout, chosen), events_table(recording.events(), layout)
        orders, events = (
            [dict(zip(table.columns, row, strict=True)) for row in table.rows] for table in tables
        )
        return Recording(
            path=Path(path),
            branch=chosen,
            step=layout.step,
            trainees=trainees_of(recording.header()),
            columns={name: whole[:, i].copy() for i, name in enumerate(states.columns)},
            orders=orders,
            events=events,
        )


def frame_of(columns: Mapping[str, Numbers]) -> Any:
    """Return columns as a pandas frame, by the time ``t`` [s] if there is one.

    ConfigError where pandas is not installed.
    """
    require_library("pandas", "a frame")
    import pandas as pd  # noqa: PLC0415  half a second

    frame = pd.DataFrame(dict(columns))
    return frame.set_index("t") if "t" in columns else frame
