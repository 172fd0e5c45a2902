"""The blueprint: what the viewer's window shows where, laid out for a debrief."""

from typing import Any, Final

import numpy as np

from trainer.rerun_log.batch import Numbers
from trainer.rerun_log.charts import LEDGER, Chart
from trainer.rerun_log.outlet import SECONDS
from trainer.rerun_log.scene import BOAT, TRACK, WORLD
from trainer.rerun_log.sdk import rr, rrb

ALWAYS: Final = ("depth", "course", "surfaces", "attitude")  # charts below one another
EYE: Final = np.array([-1.5, -1.1, -0.55])  # [-] of her length: astern, to port and above


def blueprint(charts: tuple[Chart, ...], length: float, start: Numbers, *, live: bool) -> Any:
    """Return the layout for a boat of a length [m] that starts at a place [m].

    Live it follows what comes; else it begins at the start.
    """
    shown = {chart.name: view(chart.path, f"{chart.name} [{chart.unit}]") for chart in charts}
    above = [shown.pop(name) for name in ALWAYS]
    others = rrb.Tabs(*shown.values(), view(LEDGER, "ledger [us]"))
    happened = rrb.Horizontal(
        rrb.TextLogView(origin="/log", name="log"),
        rrb.StateTimelineView(origin="/lanes", name="state"),
        column_shares=[1, 1],
    )
    return rrb.Blueprint(
        rrb.Horizontal(
            rrb.Vertical(scene(length, start), happened, row_shares=[3, 2]),
            rrb.Vertical(*above, others),
            column_shares=[3, 2],
        ),
        rrb.TimePanel(
            state="collapsed", timeline=SECONDS, play_state="following" if live else "paused"
        ),
        rrb.SelectionPanel(state="collapsed"),
        rrb.BlueprintPanel(state="collapsed"),
    )


def view(path: str, name: str) -> Any:
    """Return the view of a chart."""
    return rrb.TimeSeriesView(
        origin=path, name=name, plot_legend=rrb.PlotLegend(rrb.Corner2D.LeftTop)
    )


def scene(length: float, start: Numbers) -> Any:
    """Return the view of the boat, by an eye that follows her."""
    sailed = rrb.VisibleTimeRanges(
        rrb.VisibleTimeRange(
            SECONDS,
            start=rrb.TimeRangeBoundary.infinite(),
            end=rrb.TimeRangeBoundary.cursor_relative(),
        )
    )
    return rrb.Spatial3DView(
        origin=WORLD,
        name="boat",
        overrides={TRACK: sailed},
        eye_controls=rrb.EyeControls3D(
            kind=rrb.Eye3DKind.Orbital,
            position=start + length * EYE,
            look_target=start,
            eye_up=(0.0, 0.0, -1.0),
            tracking_entity=BOAT,
        ),
        line_grid=False,
        background=(8, 16, 28, 255),
    )
