"""What the screen of each role shows: its channels, charts and drawings.

``role_panes`` shows it, and ``launch`` subscribes to the channels at its rates.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Final

from trainer.console.charts import Quantity
from trainer.console.drawing import event_log, gauges, panels, plant, tanks
from trainer.console.drawing.attitude import hull
from trainer.console.drawing.chart import plan
from trainer.console.model import SessionModel
from trainer.console.pane import Lines

Drawing = Callable[[SessionModel, int, int], Lines]

SMOOTH_RATE: Final = "at 10 hz"
OFTEN_RATE: Final = "at 5 hz"
SELDOM_RATE: Final = "at 1 hz"
AID_NAMES: Final = ("ghost", "predictor")  # channels of every screen


@dataclass(frozen=True)
class PaneDrawing:
    """A drawing, and the name by which the style sheet finds its pane."""

    name: str
    draw: Drawing
    moving: bool = False  # between ticks


@dataclass(frozen=True)
class Layout:
    """The screen of a role."""

    role: str
    channels: tuple[str, ...]
    charts: tuple[Quantity, ...]
    upper: tuple[PaneDrawing, ...]
    lower: tuple[PaneDrawing, ...] = ()
    aside: tuple[PaneDrawing, ...] = ()


def quantities(gauge: str) -> dict[str, Quantity]:
    """Return what charts can show, depth and so on from that channel."""
    sides = ("R", "L")
    tilts = ("R", "D")
    shown = (
        Quantity("depth", "m", (gauge, "depth"), ("diving", "ordered_depth"), 4.0, crew="depth"),
        Quantity(
            "heading", "deg", (gauge, "heading"), ("steering", "ordered_course"), 4.0, crew="course"
        ),
        Quantity("speed", "kn", (gauge, "speed"), ("engine", "ordered_speed"), 2.0, crew="speed"),
        Quantity("pitch", "deg", (gauge, "pitch"), None, 4.0, ("+", "-"), "pitch"),
        Quantity("stern", "deg", ("diving", "stern"), ("diving", "ordered_stern"), 10.0, tilts),
        Quantity("bow", "deg", ("diving", "bow"), ("diving", "ordered_bow"), 10.0, tilts),
        Quantity(
            "rudder", "deg", ("steering", "rudder"), ("steering", "ordered_rudder"), 10.0, sides
        ),
    )
    return {each.name: each for each in shown}


def charts_named(gauge: str, *names: str) -> tuple[Quantity, ...]:
    """Return quantities by name."""
    known = quantities(gauge)
    return tuple(known[name] for name in names)


TANK_DRAWINGS: Final = (
    PaneDrawing("levels", tanks.levels),
    PaneDrawing("fittings", tanks.fittings),
)

LAYOUTS: Final[Mapping[str, Layout]] = {
    post.role: post
    for post in (
        Layout(
            "instructor",
            (
                "time",
                "gauges",
                "steering",
                "engine",
                "diving",
                "tanks",
                "air",
                "valves",
                "plant",
                "sea",
                "current",
                "casualties",
                "contacts",
                "ledger",
                "orders",
                "motion",
            ),
            charts_named("motion", "depth", "heading", "speed", "stern", "rudder", "pitch"),
            (
                PaneDrawing("state", gauges.state, moving=True),
                PaneDrawing("hull", hull, moving=True),
                PaneDrawing("levels", tanks.levels),
            ),
            aside=(
                PaneDrawing("plan", plan, moving=True),
                PaneDrawing("broken", event_log.around),
                PaneDrawing("plant", plant.plant),
                PaneDrawing("ledger", event_log.ledger),
            ),
        ),
        Layout(
            "helm",
            ("time", "steering", "engine", "supply", "orders", "gauges"),
            charts_named("gauges", "heading", "rudder"),
            (PaneDrawing("panel", panels.helm, moving=True),),
        ),
        Layout(
            "planes",
            ("time", "diving", "supply", "safe", "orders", "gauges"),
            charts_named("gauges", "depth", "pitch"),
            (PaneDrawing("panel", panels.planes, moving=True),),
        ),
        Layout(
            "pilot",
            ("time", "steering", "engine", "diving", "supply", "safe", "orders", "gauges"),
            charts_named("gauges", "depth", "heading"),
            (PaneDrawing("panel", panels.pilot, moving=True),),
        ),
        Layout(
            "ballast",
            ("time", "tanks", "air", "valves", "plant", "orders", "gauges"),
            charts_named("gauges", "depth", "pitch"),
            (
                PaneDrawing("panel", panels.gauges, moving=True),
                PaneDrawing("plant", plant.plant),
            ),
            TANK_DRAWINGS,
        ),
        Layout(
            "diving",
            ("time", "diving", "engine", "tanks", "air", "valves", "safe", "orders", "gauges"),
            charts_named("gauges", "depth", "pitch"),
            (PaneDrawing("panel", panels.planes, moving=True),),
            TANK_DRAWINGS,
        ),
        Layout(
            "deck",
            ("time", "orders", "gauges"),
            charts_named("gauges", "depth", "heading"),
            (PaneDrawing("panel", panels.gauges, moving=True),),
        ),
        Layout(
            "observer",
            ("time", "steering", "engine", "diving", "tanks", "air", "valves", "orders", "gauges"),
            charts_named("gauges", "depth", "heading"),
            (PaneDrawing("panel", panels.pilot, moving=True),),
        ),
        Layout(
            "scope",
            ("time", "scope", "orders", "gauges"),
            charts_named("gauges", "depth", "heading"),
            (PaneDrawing("panel", panels.periscope, moving=True),),
        ),
        Layout(
            "trainee",
            (
                *("time", "steering", "engine", "diving", "tanks"),
                *("air", "valves", "supply", "plant", "safe", "orders", "gauges"),
            ),
            charts_named("gauges", "depth", "heading"),
            (PaneDrawing("panel", panels.trainee, moving=True), PaneDrawing("plant", plant.plant)),
            (PaneDrawing("levels", panels.trainee_levels), PaneDrawing("fittings", tanks.fittings)),
        ),
        Layout(
            "visitor",
            ("time", "diving", "orders", "gauges"),
            charts_named("gauges", "depth", "pitch"),
            (PaneDrawing("panel", panels.planes, moving=True),),
        ),
    )
}


def wishes(post: Layout) -> dict[str, str]:
    """Return the wished rate of each channel. The channel that the charts follow is last."""
    often = {"motion": SMOOTH_RATE, "gauges": SMOOTH_RATE, "ledger": SELDOM_RATE}
    return {channel: often.get(channel, OFTEN_RATE) for channel in (*AID_NAMES, *post.channels)}
