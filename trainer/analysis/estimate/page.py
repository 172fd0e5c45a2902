"""``trainer boat estimate``: an estimated boat as text for the terminal, and as a page.

``survey`` has the figures. The page draws the hull with its panels, so that a wrong number is seen.
"""

import math
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from typing import Final

import numpy as np
from markupsafe import Markup

from trainer import __version__
from trainer.analysis.estimate.boat_file import WrittenBoat
from trainer.analysis.estimate.coefficients import Hull
from trainer.analysis.estimate.geometry import Panel
from trainer.analysis.estimate.survey import EstimateBand, Influence, Survey
from trainer.analysis.estimate.uncertainty import coefficient_origins
from trainer.config.files import as_typed
from trainer.core.terms import TERM_TABLE
from trainer.report.html import embed_json, fill_page, paragraph, section, table
from trainer.report.svg import Axis, rect, rule, scale_axis, svg_element, text
from trainer.report.text import ascii_text, format_number, wrap
from trainer.report.text import table as text_table

PAPER_WIDTH_PX: Final = 640.0  # [px]
PAPER_EDGE_PX: Final = 20.0  # [px] beside the hull
TITLE_ROOM_PX: Final = 42.0  # [px] above each view: its title, and below it a name of a surface
AXIS_ROOM_PX: Final = 30.0  # [px] below each view
OUTLINE_STRIDE: Final = 2  # stations a point of the outline
# share of a panel that a view shows: less is seen edge on, and not named
MIN_PANEL_SHARE: Final = 0.3
BAR_ROW_PX, BARS_LEFT, BARS_WIDTH, BARS_EDGE = 26.0, 150.0, 340.0, 40.0  # [px] of a bar chart
LETTER_WIDTH_PX: Final = 6.2  # [px] about as wide as one
MIN_BAND_DRAWS: Final = 40  # draws, of which one lies beyond either end of 95 %
BAND_HEADS: Final = ("", "estimate", "68 %", "95 %")
INFLUENCE_HEADS: Final = ("input", "value", "changed by", "lower", "higher")
BAND_NOTE: Final = (
    "Bands are of draws of the whole set: first the constants of the method, then each "
    "coefficient. They know nothing of a wrong drawing."
)
BAND_LEGEND: Final = "Thick: 68 of 100 draws; thin: 95 of 100; line: the estimate. " + BAND_NOTE


@dataclass(frozen=True)
class Paper:
    """Where metres lie on the paper; x aft from the nose, up from the axis."""

    along: Axis
    up: Axis

    def point(self, x: float, z: float) -> str:
        """Return a place as SVG has it."""
        return f"{self.along.at(x):.1f} {self.up.at(z):.1f}"


def draw_hull(hull: Hull) -> Markup:
    """Return the hull from starboard and from above, to one scale, bow to the left."""
    s, parts, top = hull.shape, [], 0.0
    corners = np.array([corner for panel in hull.panels for corner in corners_of(panel)])
    highest = max(float((s.centre + s.height / 2.0).max()), float(corners[:, 1].max()))
    lowest = min(float((s.centre - s.height / 2.0).min()), float(corners[:, 1].min()))
    wide = max(float(s.breadth.max()) / 2.0, float(np.abs(corners[:, 2]).max()))
    aft = max(0.0, float(corners[:, 0].max()) - s.length)  # how far surfaces go beyond the stern
    px_per_m = (PAPER_WIDTH_PX - 2.0 * PAPER_EDGE_PX) / (s.length + aft)
    along = Axis(0.0, s.length, PAPER_EDGE_PX, PAPER_EDGE_PX + px_per_m * s.length)
    for view, low, high in (("side", lowest, highest), ("top", -wide, wide)):
        top += TITLE_ROOM_PX
        bottom = top + px_per_m * (high - low)
        title = "From starboard" if view == "side" else "From above, starboard upwards"
        parts.append(text("title", PAPER_EDGE_PX, top - 24.0, f"{title} [m]"))
        parts += _view(hull, view, Paper(along, Axis(low, high, bottom, top)))
        parts += scale_axis(along, bottom + 8.0, 10)
        top = bottom + AXIS_ROOM_PX
    title = f"{hull.file.name} from the side and from above"
    return svg_element(title, (PAPER_WIDTH_PX, top), parts)


def corners_of(panel: Panel) -> list[tuple[float, float, float]]:
    """Return the four corners of a panel [m]: aft, up, to starboard."""
    corners = []
    ends = ((0, panel.root, 0.0), (1, panel.tip, 0.0), (1, panel.tip, 1.0), (0, panel.root, 1.0))
    for k, radius, share in ends:
        x = panel.leading[k] + share * panel.chords[k]
        up = panel.axis_up + radius * math.sin(panel.angle)
        corners.append((x, up, radius * math.cos(panel.angle)))
    return corners


def _view(hull: Hull, view: str, paper: Paper) -> Iterator[str]:
    """Yield outline, axis, surfaces and centres of one view."""
    s = hull.shape
    half, middle = (
        (s.height / 2.0, s.centre) if view == "side" else (s.breadth / 2.0, 0.0 * s.centre)
    )
    stations = [*range(0, len(s.x), OUTLINE_STRIDE), len(s.x) - 1]
    over = [paper.point(s.x[i], (middle + half)[i]) for i in stations]
    under = [paper.point(s.x[i], (middle - half)[i]) for i in reversed(stations)]
    yield f'<path class="hull" d="M{"L".join([*over, *under])}Z"/>'
    yield rule("mark", paper.along.begin, paper.up.at(0.0), paper.along.end, paper.up.at(0.0))
    named: set[str] = set()
    for panel in hull.panels:
        k = 1 if view == "side" else 2
        corners = [(corner[0], corner[k]) for corner in corners_of(panel)]
        points = "L".join(paper.point(*corner) for corner in corners)
        moves = "" if panel.control == "none" else " moves"
        yield f'<path class="panel{moves}" d="M{points}Z"/>'
        if panel.name not in named and abs(panel.normal[k - 1]) > MIN_PANEL_SHARE:
            named.add(panel.name)  # above its outline, or before it where the edge is near
            x = paper.along.at(sum(corner[0] for corner in corners) / 4.0)
            z = paper.up.at(max(corner[1] for corner in corners))
            near = x + LETTER_WIDTH_PX * len(panel.name) / 2.0 > PAPER_WIDTH_PX
            style, x = ("name end", min(x, PAPER_WIDTH_PX - 2.0)) if near else ("name middle", x)
            yield text(style, x, z - 4.0, panel.name)
    yield from _centres(hull, view, paper)


def _centres(hull: Hull, view: str, paper: Paper) -> Iterator[str]:
    """Yield the centres of gravity and of volume, and the propeller."""
    s = hull.shape
    below = hull.file.mass.cg_below_axis if view == "side" else 0.0
    for words, x, z, style in (("G", s.x_G, -below, "centre"), ("V", s.centroid, 0.0, "volume")):
        at = paper.along.at(x), paper.up.at(z)
        yield f'<circle class="{style}" cx="{at[0]:.1f}" cy="{at[1]:.1f}" r="4"/>'
        side = 8.0 if (words == "G") == (s.x_G >= s.centroid) else -16.0
        yield text("name", at[0] + side, at[1] - 6.0, words)
    propeller = hull.file.propeller
    if propeller is not None:
        half = propeller.diameter / 2.0
        x = paper.along.at(s.length)
        yield rule("propeller", x, paper.up.at(half), x, paper.up.at(-half))


def draw_bands(bands: tuple[EstimateBand, ...]) -> Markup:
    """Return the bands of figures of one unit as bars, the estimate marked."""
    shown = [band for band in bands if band.value is not None and None not in band.bands.values()]
    if not shown:
        return Markup()
    ends = [x for band in shown for pair in band.bands.values() if pair for x in pair]
    values = [band.value for band in shown if band.value is not None]
    low, high = min(*ends, *values, 0.0), max(*ends, *values)
    across = Axis(low, high, BARS_LEFT, BARS_LEFT + BARS_WIDTH)
    parts: list[str] = []
    for i, band in enumerate(shown):
        y = 8.0 + BAR_ROW_PX * i
        parts.append(text("tick end", BARS_LEFT - 8.0, y + 12.0, band.name))
        for style, room, pair in zip(
            ("core", "outer"), (3.0, 6.0), band.bands.values(), strict=True
        ):
            if pair:
                x, end = map(across.at, pair)
                parts.append(rect(style, x, y + room - 3.0, end - x, 20.0 - 2.0 * room))
        x = across.at(band.value or 0.0)
        parts.append(rule("estimate", x, y - 3.0, x, y + 17.0))
    return _bar_chart("Bands of the figures", parts, len(shown), across, shown[0].unit)


def _bar_chart(title: str, parts: list[str], rows: int, across: Axis, unit: str) -> Markup:
    """Return rows of bars with an axis below, in a division that is small on a narrow screen."""
    bottom = 8.0 + BAR_ROW_PX * rows
    parts += scale_axis(across, bottom, 6)
    if unit != "-":
        parts.append(text("tick", across.end + 8.0, bottom + 16.0, unit))
    drawn = svg_element(title, (BARS_LEFT + BARS_WIDTH + BARS_EDGE, bottom + 24.0), parts)
    return Markup('<div class="bars">{}</div>').format(drawn)


def draw_influences(found: tuple[Influence, ...]) -> Markup:
    """Return the effects of inputs on the turn as bars, lower input and higher."""
    most = 100.0 * max(one.size for one in found) or 1.0
    chart_left = BARS_LEFT + 20.0
    across = Axis(-most, most, chart_left, chart_left + BARS_WIDTH - 20.0)
    parts: list[str] = []
    for i, one in enumerate(found):
        y = 8.0 + BAR_ROW_PX * i
        parts.append(text("tick end", chart_left - 8.0, y + 12.0, one.key))
        for style, effect, at in (("lower", one.down, y), ("higher", one.up, y + 8.0)):
            ends = sorted((across.at(0.0), across.at(100.0 * (effect or 0.0))))
            parts.append(rect(style, ends[0], at, ends[1] - ends[0], 8.0))
    parts.append(rule("axis", across.at(0.0), 4.0, across.at(0.0), 8.0 + BAR_ROW_PX * len(found)))
    return _bar_chart("What moves the turn most", parts, len(found), across, "%")


def render(found: Survey, written: WrittenBoat) -> str:
    """Return the page for a terminal, 79 columns."""
    lines = [ascii_text(f"ESTIMATE: {found.vessel}"), ""]
    lines += [f"  {name}: {words}" for name, words in facts(found)]
    lines += ["", "STABILITY (above 0: stable by itself)"]
    lines += text_table(BAND_HEADS, (band_row(band) for band in found.margins))
    lines += ["", turn_title(found).upper()]
    lines += text_table(BAND_HEADS, (band_row(band) for band in found.turn))
    lines += [*wrap(BAND_NOTE, "  ", "  "), "", "WHAT MOVES THE STEADY DIAMETER MOST [%]"]
    typed, flies = as_typed(written.file.path), bool(found.influences)
    rows = text_table(INFLUENCE_HEADS, map(influence_row, found.influences))
    lines += rows if flies else ["  nothing: the boat does not fly this turn"]
    lines += ["", "DEFAULTED", *wrap(", ".join(found.defaulted) or "nothing")]
    if found.warnings:
        lines += ["", "WARNINGS"]
        lines += [line for each in found.warnings for line in wrap(each)]
    lines += ["", f"next: trainer boat check {typed}"]
    lines += [f"      trainer boat manoeuvre turning-circle {typed}"] * flies
    return "\n".join([*lines, f"      trainer run --vessel {typed}"])


def facts(found: Survey) -> list[tuple[str, str]]:
    """Return what there is to know about the boat, each with its name."""
    critical = found.critical_speed_kn.items()
    speeds = [f"{plane} planes {speed:.2g} kn" for plane, speed in critical if speed is not None]
    period = format_number(found.roll_period_s, ".3g")
    return [
        ("mass", f"{found.mass_kg:.6g} kg; the hull displaces {found.displaced_kg:.6g} kg"),
        ("step", f"{found.step_s:g} s, the longest that is stable and that the gains hold"),
        ("limits", f"rudder and planes {found.limit_deg:g} deg, {found.rate_deg_s:.3g} deg/s"),
        ("depth control reverses at", ", ".join(speeds) or "none"),
        ("roll period", f"{period} s at {found.speed_kn:g} kn"),
    ]


def turn_title(found: Survey) -> str:
    """Return what turn was flown, and how many draws its bands rest on."""
    flown = f"{found.flown} of {found.draws} draws flew it" if found.draws else "no draws, no bands"
    few = ": few, the bands are rough" if 0 < found.flown < MIN_BAND_DRAWS else ""
    return f"Turn, rudder {found.rudder_deg:g} deg, {found.speed_kn:g} kn ({flown}{few})"


def band_row(band: EstimateBand) -> tuple[str, ...]:
    """Return a figure with its bands as cells."""
    name = band.name if band.unit == "-" else f"{band.name} [{band.unit}]"
    pairs = band.bands.values()
    ends = ("-" if pair is None else f"{pair[0]:.3g} to {pair[1]:.3g}" for pair in pairs)
    return (name, format_number(band.value, ".3g"), *ends)


def influence_row(one: Influence) -> tuple[str, ...]:
    """Return one input's effect as cells."""
    down, up = ("-" if x is None else f"{100.0 * x:+.1f}" for x in (one.down, one.up))
    unit = "" if one.unit == "-" else f" {one.unit}"
    return (one.key, f"{one.value:.4g}{unit}", one.change, down, up)


def html_page(found: Survey, written: WrittenBoat) -> str:
    """Return the page with the hull drawn, every coefficient, the bands and what moves them."""
    drawn = Markup('<div class="wide drawing">{}</div>').format(draw_hull(written.made.hull))
    warned = [paragraph(each, "bad") for each in found.warnings] or [paragraph("None.")]
    margins = "Margins of stability; above 0 the boat is stable by itself."
    figures = [table((), facts(found), "facts"), *_banded(margins, found.margins)]
    chapters = {
        "hull": ("The hull", [drawn, _hull_words(written)]),
        "warnings": ("Warnings", warned),
        "figures": ("Stability", figures),
        "turn": ("The turn", _banded(turn_title(found), found.turn)),
        "inputs": ("What moves the turn", [*_inputs(found)]),
        "coefficients": ("Coefficients", [*_coefficients(written)]),
        "defaulted": ("Defaulted", [paragraph(", ".join(found.defaulted))]),
    }
    return fill_page(
        "estimate.html",
        "guide.css",
        title=found.vessel,
        heading=f"Estimated from its drawing by trainer boat estimate, version {__version__}",
        contents=[(name, title) for name, (title, _) in chapters.items()],
        parts=[section(name, title, *parts) for name, (title, parts) in chapters.items()],
        data=embed_json(asdict(found)),
    )


def _hull_words(written: WrittenBoat) -> Markup:
    """Return what the drawing shows."""
    shape = written.made.hull.shape
    return paragraph(
        f"To scale, from the file. G: centre of gravity; V: centre of volume. Length "
        f"{shape.length:.4g} m, breadth {shape.breadth.max():.4g} m, height "
        f"{shape.height.max():.4g} m, volume {shape.volume:.5g} m3, wetted {shape.wetted:.4g} m2. "
        "Filled surfaces move. Is this your boat? A wrong drawing gives a wrong boat, and no band "
        "says so."
    )


def _banded(words: str, bands: tuple[EstimateBand, ...]) -> list[Markup]:
    """Return figures with their bands, those of the first one's unit drawn."""
    drawn = tuple(band for band in bands if band.unit == bands[0].unit)
    rows = table(BAND_HEADS, map(band_row, bands))
    return [paragraph(words), rows, draw_bands(drawn), paragraph(BAND_LEGEND, "soft")]


def _inputs(found: Survey) -> Iterator[Markup]:
    """Yield the inputs that move the turn most."""
    if not found.influences:
        yield paragraph("The boat does not fly this turn.")
        return
    yield paragraph("Change of the steady diameter [%] when one input alone is changed.")
    yield table(INFLUENCE_HEADS, map(influence_row, found.influences))
    yield draw_influences(found.influences)
    yield paragraph("Upper bar: the input lower; bar under it: higher.", "soft")


def _coefficients(written: WrittenBoat) -> Iterator[Markup]:
    """Yield every coefficient with its deviation and what it rests on."""
    made = written.made
    rows = []
    for term in TERM_TABLE:
        numbers = (f"{made.values[term.key]:.4g}", f"{made.sd[term.key]:.2g}")
        multiplies = f"L^{term.power} {term.multiplies}"
        rows.append((term.key, *numbers, multiplies, coefficient_origins()[term.key]))
    yield paragraph(
        "All 131, in the prime system. sd: standard deviation. Doubled where the hull is outside "
        "the range of the method."
    )
    yield table(("coefficient", "estimate", "sd", "multiplies", "rests on"), rows)
