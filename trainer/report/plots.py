"""Plots for paper and screen, by matplotlib where it is installed.

Programs with ``--plot`` call ``draw_plot``, and ``panels`` draws the same for pages. Curves differ
by line style as well as colour, and the colours are those of Okabe and Ito (2008), so that a plot
reads in grey and to the colour-blind. The same panels give the same bytes.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import cycle
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from trainer.config.files import ConfigError
from trainer.core.kernel import Numbers
from trainer.io.outputs import replacing

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

TRACK_TITLE: Final = "track"  # title of a panel with one scale both ways
FILE_ENDINGS: Final = (".png", ".svg", ".pdf")
CURVE_COLOURS: Final = ("#000000", "#D55E00", "#0072B2", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
# five beside seven colours: 35 pairs before one recurs
LINE_STYLES: Final = ("-", "--", "-.", ":", (0, (8, 2, 2, 2, 2, 2)))
POINT_MARKERS: Final = ("o", "s", "^", "D", "v", "P", "X")
PLOT_STYLE: Final[dict[Any, Any]] = {
    "font.size": 9.0,
    "axes.grid": True,
    "grid.color": "#CCCCCC",
    "grid.linewidth": 0.5,
    "lines.linewidth": 1.4,
    "figure.dpi": 150.0,
    "svg.hashsalt": "trainer",  # the same names in the file each time
    "pdf.fonttype": 42,
}
# What would differ from one time to the next.
FILE_METADATA: Final[dict[str, dict[str, Any]]] = {
    ".png": {"Software": None},
    ".svg": {"Date": None},
    ".pdf": {"CreationDate": None},
}
PANEL_WIDTH, PANEL_HEIGHT = 6.4, 3.0  # [in]
SCREEN_WIDTH = 12.8  # [in] two panels beside each other


@dataclass(frozen=True)
class Curve:
    """A line through points; NaN leaves a gap."""

    label: str
    x: Numbers
    y: Numbers
    points: bool = False  # drawn as points, not as a line


@dataclass(frozen=True)
class Panel:
    """One pair of axes: curves, and lines across at marked values of x and y."""

    title: str
    x: str  # what is along it, [unit]
    y: str
    curves: tuple[Curve, ...]
    marks: tuple[tuple[str, float], ...] = ()  # label and value of x
    levels: tuple[float, ...] = ()  # values of y
    decades: bool = False  # x by its logarithm
    downwards: bool = False  # larger is lower, as depths are


@dataclass(frozen=True)
class Screen:
    """Panels that are seen together, on one screen or page."""

    title: str
    panels: tuple[Panel, ...]


@dataclass(frozen=True)
class Bar:
    """The range over which one cause moves a quantity, and the texts at its ends."""

    label: str
    ends: tuple[float, float]
    told: tuple[str, str]


@dataclass(frozen=True)
class BarGroup:
    """Bars across, from the first on top, about a line: a tornado."""

    title: str
    x: str  # what is along it, [unit]
    bars: tuple[Bar, ...]
    middle: float


def draw_plot(panels: Sequence[Panel | BarGroup | Screen], path: Path) -> None:
    """Write ``panels``, one below the other, to ``path``; ConfigError if that cannot be.

    Screens are two panels wide, in a PDF each on a page of its own.
    """
    if path.suffix.lower() not in FILE_ENDINGS:
        raise ConfigError(
            f"--plot {path}: must end in {', '.join(FILE_ENDINGS[:-1])} or {FILE_ENDINGS[-1]}"
        )
    try:
        from matplotlib import rc_context  # noqa: PLC0415
        from matplotlib.backends.backend_pdf import PdfPages  # noqa: PLC0415
    except ImportError as missing:
        raise ConfigError(
            f"--plot needs matplotlib, which cannot be loaded ({missing}); install it with: "
            "pip install 'submarine-trainer[plot]'"
        ) from missing
    metadata = FILE_METADATA[path.suffix.lower()]
    screens = [each for each in panels if isinstance(each, Screen)]
    with rc_context(PLOT_STYLE):
        try:
            with replacing(path) as made:
                if not screens or path.suffix.lower() != ".pdf":
                    figure_of(panels).savefig(made, metadata=metadata)
                    return
                with PdfPages(made, metadata=metadata) as pages:
                    for screen in screens:
                        pages.savefig(figure_of([screen]))
        except OSError as error:
            raise ConfigError(f"--plot {path}: cannot be written: {error.strerror}") from error


def figure_of(panels: Sequence[Panel | BarGroup | Screen]) -> "Figure":
    """Return a figure of matplotlib: panels one below the other, those of screens in pairs."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg  # noqa: PLC0415
    from matplotlib.figure import Figure  # noqa: PLC0415

    rows: list[tuple[Panel | BarGroup, ...]] = []
    for entry in panels:
        if isinstance(entry, Screen):
            rows += [entry.panels[i : i + 2] for i in range(0, len(entry.panels), 2)]
        else:
            rows.append((entry,))
    wide = 2 if any(isinstance(each, Screen) for each in panels) else 1
    size = (SCREEN_WIDTH if wide == 2 else PANEL_WIDTH, PANEL_HEIGHT * len(rows))
    figure = Figure(figsize=size, layout="constrained")
    FigureCanvasAgg(figure)
    for i, row in enumerate(rows):
        for j, panel in enumerate(row):
            axes = figure.add_subplot(len(rows), wide, i * wide + j + 1)
            if isinstance(panel, BarGroup):
                _draw_bars(panel, axes)
            else:
                _draw_panel(panel, axes)
    return figure


def _draw_bars(panel: BarGroup, axes: "Axes") -> None:
    """Draw bars across. Hatching tells a cause's low end from its high end."""
    for row, bar in enumerate(panel.bars):
        sides = zip(bar.ends, bar.told, CURVE_COLOURS[1:3], ("", "////"), strict=False)
        for end, end_text, colour, hatch in sides:
            how: dict[str, Any] = {"color": colour, "height": 0.6}
            if hatch:
                how |= {"color": "white", "edgecolor": colour, "hatch": hatch}
            axes.barh(row, end - panel.middle, left=panel.middle, **how)
            right = end >= panel.middle
            axes.annotate(
                end_text,
                (end, row),
                (3.0 if right else -3.0, 0.0),
                textcoords="offset points",
                ha="left" if right else "right",
                va="center",
                fontsize=7.0,
            )
    axes.set_axisbelow(True)
    axes.axvline(panel.middle, color="#000000", linewidth=0.8)
    axes.set_yticks(range(len(panel.bars)), [bar.label for bar in panel.bars])
    axes.invert_yaxis()
    axes.margins(x=0.15)
    axes.set_title(panel.title, fontsize=10.0, loc="left")
    axes.set_xlabel(panel.x)


def _draw_panel(panel: Panel, axes: "Axes") -> None:
    """Draw one panel."""
    styles = zip(cycle(CURVE_COLOURS), cycle(LINE_STYLES), cycle(POINT_MARKERS))
    if panel.decades:
        axes.set_xscale("log")
    for curve, (colour, line, marker) in zip(panel.curves, styles, strict=False):
        how: dict[str, Any] = {"linestyle": line}
        if curve.points:
            how = {"linestyle": "none", "marker": marker, "markersize": 4.0, "fillstyle": "none"}
        axes.plot(curve.x, curve.y, color=colour, label=curve.label, **how)
    for label, value in panel.marks:
        axes.axvline(value, color="#666666", linewidth=0.8, linestyle=(0, (4, 4)))
        where = ("data", "axes fraction")
        axes.annotate(
            label,
            (value, 0.98),
            xycoords=where,
            rotation=90,
            ha="right",
            va="top",
            fontsize=7.0,
            bbox={"facecolor": "white", "edgecolor": "none", "pad": 1.0},
        )
    for value in panel.levels:
        axes.axhline(value, color="#666666", linewidth=0.8, linestyle=(0, (4, 4)))
    axes.set_title(panel.title, fontsize=10.0, loc="left")
    axes.set_xlabel(panel.x)
    axes.set_ylabel(panel.y)
    if panel.downwards:
        axes.invert_yaxis()
    if panel.title == TRACK_TITLE:
        axes.set_aspect("equal", adjustable="datalim")  # a turning circle is round
    if len(panel.curves) > 1:  # beside the axes, where it hides nothing
        axes.legend(fontsize=8.0, loc="upper left", bbox_to_anchor=(1.01, 1.0))
