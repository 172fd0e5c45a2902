"""The blueprint: what the viewer's window shows where, laid out for a debrief."""

from typing import Any, Final

from trainer.session.rerun.charts import LEDGER, Chart
from trainer.session.rerun.outlet import SECONDS
from trainer.session.rerun.scene import FOLLOWER, TRACK, WORLD
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
