"""An estimated boat told: as text for the terminal, and as one HTML page."""

from collections.abc import Iterator
from dataclasses import asdict
from typing import Final

from markupsafe import Markup

from trainer import __version__
from trainer.analysis.estimate.boat_file import Written
from trainer.analysis.estimate.drawing import draw_bands, draw_hull, draw_influences
from trainer.analysis.estimate.survey import Band, Influence, Survey
from trainer.analysis.estimate.uncertainty import rests
from trainer.analysis.report.html import embed, page, paragraph, section, table
from trainer.analysis.report.text import figure, plain, wrap
from trainer.analysis.report.text import table as text_table
from trainer.config.files import as_typed
from trainer.core.terms import TABLE

HEADS: Final = ("", "estimate", "68 %", "95 %")
NOTE: Final = (
    "Bands are of draws of the whole set: first the constants of the method, then each "
    "coefficient. They know nothing of a wrong drawing."
)


def render(found: Survey, written: Written) -> str:
    """Return the page for a terminal, 79 columns."""
    lines = [plain(f"ESTIMATE: {found.vessel}"), ""]
    lines += [f"  {name}: {words}" for name, words in facts(found)]
    lines += ["", "STABILITY (above 0: stable by itself)"]
    lines += text_table(HEADS, (band_row(band) for band in found.margins))
    lines += ["", turn_title(found).upper()]
    lines += text_table(HEADS, (band_row(band) for band in found.turn))
    lines += wrap(NOTE, "  ", "  ")
    lines += ["", *_influence_lines(found)]
    lines += ["", "DEFAULTED", *wrap(", ".join(found.defaulted) or "nothing")]
    if found.warnings:
        lines += ["", "WARNINGS"]
        lines += [line for each in found.warnings for line in wrap(each)]
    lines += ["", *_next_lines(written)]
    return "\n".join(lines)


def facts(found: Survey) -> list[tuple[str, str]]:
    """Return what there is to know about the boat, each with its name."""
    critical = {
        "stern planes": found.critical_speed_kn["stern"],
        "bow planes": found.critical_speed_kn["bow"],
    }
    told = [f"{name} {speed:.2g} kn" for name, speed in critical.items() if speed is not None] or [
        "none"
    ]
    period = figure(found.roll_period_s, ".3g")
    return [
        ("mass", f"{found.mass_kg:.6g} kg; the hull displaces {found.displaced_kg:.6g} kg"),
        ("step", f"{found.step_s:g} s, the longest that is stable and that the gains hold"),
        ("limits", f"rudder and planes {found.limit_deg:g} deg, {found.rate_deg_s:.3g} deg/s"),
        ("depth control reverses at", ", ".join(told)),
        ("roll period", f"{period} s at {found.speed_kn:g} kn"),
    ]


def turn_title(found: Survey) -> str:
    """Return what turn was flown."""
    return (
        f"Turn, rudder {found.rudder_deg:g} deg, {found.speed_kn:g} kn "
        f"({found.flown} of {found.draws} draws flew it)"
    )


def band_row(band: Band) -> tuple[str, ...]:
    """Return a figure with its bands as cells."""
    name = band.name if band.unit == "-" else f"{band.name} [{band.unit}]"
    ends = (
        "-" if pair is None else f"{pair[0]:.3g} to {pair[1]:.3g}" for pair in band.bands.values()
    )
    return (name, figure(band.value, ".3g"), *ends)


def influence_row(one: Influence) -> tuple[str, ...]:
    """Return one input's effect as cells."""
    down, up = ("-" if x is None else f"{100.0 * x:+.1f}" for x in (one.down, one.up))
    unit = "" if one.unit == "-" else f" {one.unit}"
    return (one.key, f"{one.value:.4g}{unit}", one.change, down, up)


def _influence_lines(found: Survey) -> Iterator[str]:
    """Yield the inputs that move the turn most."""
    yield "WHAT MOVES THE STEADY DIAMETER MOST [%]"
    if not found.influences:
        yield "  nothing: the boat does not fly this turn"
        return
    heads = ("input", "value", "changed by", "lower", "higher")
    yield from text_table(heads, map(influence_row, found.influences))


def _next_lines(written: Written) -> Iterator[str]:
    """Yield what to type next."""
    typed = as_typed(written.file.path)
    yield f"next: trainer check {typed}"
    yield f"      trainer manoeuvre turning-circle {typed}"
    yield f"      trainer run --vessel {typed}"


def html_page(found: Survey, written: Written) -> str:
    """Return the page with the hull drawn, every coefficient, the bands and what moves them."""
    hull = written.made.hull
    return page(
        "estimate.html",
        "guide.css",
        title=found.vessel,
        heading=f"Estimated from its drawing by trainer estimate, version {__version__}",
        contents=CONTENTS.items(),
        parts=[
            section("hull", CONTENTS["hull"], _scrolled(draw_hull(hull)), _hull_words(written)),
            section("warnings", CONTENTS["warnings"], _warnings(found)),
            section(
                "figures", CONTENTS["figures"], table((), facts(found), "facts"), _margins(found)
            ),
            section("turn", CONTENTS["turn"], *_turn(found)),
            section("inputs", CONTENTS["inputs"], *_inputs(found)),
            section("coefficients", CONTENTS["coefficients"], *_coefficients(written)),
            section("defaulted", CONTENTS["defaulted"], paragraph(", ".join(found.defaulted))),
        ],
        data=embed(asdict(found)),
    )


CONTENTS: Final = {
    "hull": "The hull",
    "warnings": "Warnings",
    "figures": "Stability",
    "turn": "The turn",
    "inputs": "What moves the turn",
    "coefficients": "Coefficients",
    "defaulted": "Defaulted",
}


def _scrolled(drawn: Markup) -> Markup:
    """Return a drawing that a narrow screen scrolls instead of shrinking it."""
    return Markup('<div class="wide drawing">{}</div>').format(drawn)


def _bars(drawn: Markup) -> Markup:
    """Return a bar chart, which is small enough for a narrow screen."""
    return Markup('<div class="bars">{}</div>').format(drawn)


def _hull_words(written: Written) -> Markup:
    """Return what the drawing shows."""
    shape = written.made.hull.shape
    return paragraph(
        f"To scale, from the file. G: centre of gravity; V: centre of volume. Length "
        f"{shape.length:.4g} m, breadth {shape.breadth.max():.4g} m, height "
        f"{shape.height.max():.4g} m, volume {shape.volume:.5g} m3, wetted {shape.wetted:.4g} m2. "
        "Filled surfaces move. Is this your boat? A wrong drawing gives a wrong boat, and no band "
        "says so."
    )


def _warnings(found: Survey) -> Markup:
    """Return the warnings as a list of paragraphs."""
    told = [paragraph(each, "bad") for each in found.warnings]
    return Markup().join(told or [paragraph("None.")])


def _margins(found: Survey) -> Markup:
    """Return the margins of stability with their bands."""
    words = "Margins of stability; above 0 the boat is stable by itself."
    drawn = _bars(draw_bands(found.margins))
    return Markup().join(
        [paragraph(words), table(HEADS, map(band_row, found.margins)), drawn, _legend()]
    )


def _legend() -> Markup:
    """Return what bars and lines of the bands mean."""
    return paragraph("Thick: 68 of 100 draws; thin: 95 of 100; line: the estimate. " + NOTE, "soft")


def _turn(found: Survey) -> Iterator[Markup]:
    """Yield the turn with its bands."""
    yield paragraph(turn_title(found))
    yield table(HEADS, map(band_row, found.turn))
    yield _bars(draw_bands(tuple(band for band in found.turn if band.unit == "m")))
    yield _legend()


def _inputs(found: Survey) -> Iterator[Markup]:
    """Yield the inputs that move the turn most."""
    if not found.influences:
        yield paragraph("The boat does not fly this turn.")
        return
    yield paragraph("Change of the steady diameter [%] when one input alone is changed.")
    heads = ("input", "value", "changed by", "lower", "higher")
    yield table(heads, map(influence_row, found.influences))
    yield _bars(draw_influences(found.influences))
    yield paragraph("Upper bar: the input lower; bar under it: higher.", "soft")


def _coefficients(written: Written) -> Iterator[Markup]:
    """Yield every coefficient with its deviation and what it rests on."""
    made = written.made
    rows = [
        (
            term.key,
            f"{made.values[term.key]:.4g}",
            f"{made.sd[term.key]:.2g}",
            f"L^{term.power} {term.multiplies}",
            rests()[term.key],
        )
        for term in TABLE
    ]
    yield paragraph(
        "All 131, in the prime system. sd: standard deviation. Doubled where the hull is outside "
        "the range of the method."
    )
    yield table(("coefficient", "estimate", "sd", "multiplies", "rests on"), rows)
