"""Sinks: a file, and a viewer on this machine or another, with their blueprint."""

import socket
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np

from trainer.core.kernel import Numbers
from trainer.session.rerun.batch import Batch, Block, Changes, Subject, Told
from trainer.session.rerun.charts import (
    COLOURS,
    LEDGER,
    LEDGER_LABELS,
    Chart,
    Lane,
    casualty_lanes,
    charts_of,
    lanes_of,
    ledger_columns,
)
from trainer.session.rerun.outlet import SECONDS, Outlet
from trainer.session.rerun.scene import FOLLOWER, TRACK, WORLD, Scene
from trainer.session.rerun.sdk import rr, rrb

ALWAYS: Final = ("depth", "heading", "surfaces")  # charts below one another; the rest are tabs
EYE: Final = (-1.0, -0.75, -0.3)  # [-] of its length: astern, to port and above

WHOLE: Final = rr.TimeRange(
    start=rrb.TimeRangeBoundary.infinite(), end=rrb.TimeRangeBoundary.infinite()
)


def blueprint(charts: tuple[Chart, ...], length: float) -> Any:
    """Return the layout for a boat of a length [m]."""
    shown = {chart.name: view(chart.path, chart.title) for chart in charts}
    above = [shown.pop(name) for name in ALWAYS]
    others = rrb.Tabs(*shown.values(), view(LEDGER, "ticks [us]"))
    happened = rrb.Horizontal(
        rrb.TextLogView(
            origin="/log",
            name="log",
            columns=rrb.TextLogColumns(text_log_columns=["LogLevel", "Body"]),
        ),
        rrb.StateTimelineView(
            origin="/lanes", name="state", time_view=rrb.TimeAxis(view_range=WHOLE)
        ),
        column_shares=[1, 1],
    )
    return rrb.Blueprint(
        rrb.Horizontal(
            rrb.Vertical(scene(length), happened, row_shares=[3, 2]),
            rrb.Vertical(*above, others),
            column_shares=[3, 2],
        ),
        rrb.TimePanel(state="collapsed", timeline=SECONDS, play_state="following"),
        rrb.SelectionPanel(state="collapsed"),
        rrb.BlueprintPanel(state="collapsed"),
    )


def view(path: str, name: str) -> Any:
    """Return the view of a chart."""
    return rrb.TimeSeriesView(
        origin=path,
        name=name,
        plot_legend=rrb.PlotLegend(rrb.Corner2D.LeftTop),
        axis_x=rrb.TimeAxis(view_range=WHOLE),
    )


def scene(length: float) -> Any:
    """Return the view of the boat, by an eye that follows it."""
    sailed = rrb.VisibleTimeRanges(
        rrb.VisibleTimeRange(
            SECONDS,
            start=rrb.TimeRangeBoundary.infinite(),
            end=rrb.TimeRangeBoundary.cursor_relative(),
        )
    )
    return rrb.Spatial3DView(
        origin=FOLLOWER,  # seen from there, all else moves past
        contents=f"/{WORLD}/**",
        name="boat",
        overrides={TRACK: sailed},
        eye_controls=rrb.EyeControls3D(
            kind=rrb.Eye3DKind.Orbital,
            position=tuple(length * part for part in EYE),
            look_target=(0.0, 0.0, 0.0),
            eye_up=(0.0, 0.0, -1.0),
        ),
        line_grid=False,
        background=(8, 16, 28, 255),
    )


LEVELS: Final = {
    "trouble": "ERROR",
    "watch": "WARN",
    "pilot": "WARN",
    "depth": "WARN",
    "mark": "WARN",
}  # by kind of news


class Writer:
    """Everything of one run, written to one outlet batch by batch."""

    def __init__(self, subject: Subject, outlet: Outlet) -> None:
        """Take what is shown and where; nothing is written yet."""
        self._outlet = outlet
        self._scene = Scene(subject, outlet)
        self._charts = charts_of(subject.boat)
        self._lanes = {lane.path: lane for lane in lanes_of(subject.boat)}
        self._begun: set[str] = set()  # lanes that have had a word
        self._changes = Changes()

    def begin(self) -> None:
        """Write what is the same at all times."""
        self._scene.begin()
        for chart in self._charts:
            self._outlet.fix(chart.path, lines(chart.labels))
        self._outlet.fix(LEDGER, lines(LEDGER_LABELS))

    def write(self, batch: Batch) -> None:
        """Write a batch."""
        if batch.block.times.ticks.size:
            self._write_block(batch.block)
        if batch.worked.times.ticks.size:
            columns = scalars(ledger_columns(batch.worked))
            self._outlet.send(LEDGER, batch.worked.times, columns)
        if batch.told.kinds:
            self._write_news(batch.told)

    def _write_block(self, block: Block) -> None:
        self._scene.write(block)
        for chart in self._charts:
            self._outlet.send(chart.path, block.times, scalars(chart.columns(block)))
        for lane in casualty_lanes(block):
            self._lanes.setdefault(lane.path, lane)
        for lane in self._lanes.values():
            self._write_lane(lane, block)

    def _write_lane(self, lane: Lane, block: Block) -> None:
        """Write where a lane has another word; it begins with its first."""
        codes = lane.codes(block)
        rows = self._changes.of(lane.path, codes)
        words = [lane.word(code) for code in codes[rows].tolist()]
        if lane.path not in self._begun:
            if not any(words):
                return
            self._begun.add(lane.path)
            if lane.colours:
                self._outlet.fix(lane.path, colours_of(lane))
        if words:
            self._outlet.send(lane.path, block.times.at(rows), rr.StateChange.columns(state=words))

    def _write_news(self, told: Told) -> None:
        kinds = np.array(told.kinds)
        for kind in dict.fromkeys(told.kinds):
            rows = kinds == kind
            texts = [text for text, here in zip(told.texts, rows, strict=True) if here]
            levels = [LEVELS.get(kind, "INFO")] * len(texts)
            columns = rr.TextLog.columns(text=texts, level=levels)
            self._outlet.send(f"log/{kind}", told.times.at(rows), columns)


def lines(labels: Sequence[str]) -> Any:
    """Return how the lines of a chart are drawn."""
    colours = [COLOURS[i % len(COLOURS)] for i in range(len(labels))]
    return rr.SeriesLines(names=labels, colors=colours, widths=[1.5] * len(labels))


def colours_of(lane: Lane) -> Any:
    """Return the colours of a lane's words."""
    values, colours = list(lane.colours), list(lane.colours.values())
    return rr.StateConfiguration(values=values, labels=values, colors=colours)


def scalars(columns: Numbers) -> Any:
    """Return one number for each line at each row."""
    rows, count = columns.shape
    whole = rr.Scalars.columns(scalars=np.ascontiguousarray(columns).reshape(-1))
    return whole.partition(np.full(rows, count))


PROBE: Final = 0.5  # [s] that a viewer has to answer


class RrdFile:
    """A file for the viewer. Few large pieces, since each has a head of its own."""

    period = 20.0
    patience = 30.0
    needed = True

    def __init__(self, path: Path, subject: Subject) -> None:
        """Take the file's name; it is replaced when opened."""
        self.name = str(path)
        self._path, self._subject = path, subject

    def open(self) -> None:
        """Begin the file with what is the same at all times."""
        self._path.open("wb").close()  # tells better than the library why it cannot be written
        self._outlet = Outlet(self._subject.title)
        self._outlet.save(
            self._path, blueprint(charts_of(self._subject.boat), self._subject.length)
        )
        self._writer = Writer(self._subject, self._outlet)
        self._writer.begin()

    def write(self, batch: Batch) -> None:
        """Write a batch to the file."""
        self._writer.write(batch)
        self._outlet.flush()

    def close(self) -> None:
        """Complete the file."""
        self._outlet.close()


class Viewer:
    """A viewer that listens already."""

    period = 1.0
    patience = 2.0
    needed = False

    def __init__(self, host: str, port: int, subject: Subject) -> None:
        """Take where it listens."""
        self.name = f"viewer at {host}:{port}"
        self._host, self._port, self._subject = host, port, subject

    def open(self) -> None:
        """Send what is the same at all times."""
        layout = blueprint(charts_of(self._subject.boat), self._subject.length)
        self._outlet = Outlet(self._subject.title)
        self._outlet.connect(self._host, self._port, layout)
        self._writer = Writer(self._subject, self._outlet)
        self._writer.begin()

    def write(self, batch: Batch) -> None:
        """Send a batch; ConnectionError if the viewer has gone."""
        self._writer.write(batch)
        try:
            self._outlet.flush()
        except RuntimeError:
            raise ConnectionError("it has gone") from None

    def close(self) -> None:
        """End the recording; the viewer keeps what it has."""
        self._outlet.close()


def listens(host: str, port: int) -> bool:
    """Return whether something listens there: without it the library waits for ever."""
    try:
        socket.create_connection((host, port), PROBE).close()
    except OSError:
        return False
    return True
