"""The writer: batches made into what the viewer shows."""

from collections.abc import Sequence
from typing import Any, Final

import numpy as np

from trainer.core.kernel import Numbers
from trainer.session.rerun.batch import Batch, Block, Changes, Told
from trainer.session.rerun.charts import COLOURS, LEDGER, LEDGER_LABELS, charts_of, ledger_columns
from trainer.session.rerun.outlet import Outlet
from trainer.session.rerun.scene import Scene
from trainer.session.rerun.sdk import rr
from trainer.session.rerun.states import Lane, casualty_lanes, lanes_of
from trainer.session.rerun.subject import Subject

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
