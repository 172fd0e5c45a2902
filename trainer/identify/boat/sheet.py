"""A fit of a boat as one HTML page, with bands, tracks and curves.

It needs no other file and no network. ``page`` has the same numbers as text.
"""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Final

import numpy as np
from markupsafe import Markup

from trainer import __version__
from trainer.core.kernel import Numbers
from trainer.identify.boat.figures import FigureBand
from trainer.identify.boat.filter import CHANNEL_NAMES
from trainer.identify.boat.motion import CONTROL_PLACES, STATE
from trainer.identify.boat.page import (
    BAND_NOTE,
    COEFFICIENT_HEADS,
    FIGURE_HEADS,
    coefficient_row,
    figure_row,
    render,
)
from trainer.identify.boat.report import FORETOLD_CHANNELS, VERDICT_WORDS, BoatFit, foretell
from trainer.identify.boat.search import SearchEnd
from trainer.identify.boat.trial import Trial
from trainer.identify.sheet import draw_screen, fill_sheet, listing, screens_of
from trainer.report import html
from trainer.report.plots import TRACK_TITLE, Curve, Panel
from trainer.report.svg import Axis, rect, rule, svg_element
from trainer.units import DEGREE

BAND_SIZE_PX: Final = (150.0, 16.0)
BAND_WORDS: Final = "Light: 95 % before the records. Dark: after. Each line has its own scale."
SURFACES: Final = {
    "rudder": CONTROL_PLACES.RUDDER,
    "stern planes": CONTROL_PLACES.STERN,
    "bow planes": CONTROL_PLACES.BOW,
}
SURE_LEVELS: Final = (-2.0, 0.0, 2.0)  # deviations of an innovation


def html_page(fit: SearchEnd, held_out: Sequence[Trial], report: BoatFit) -> str:
    """Return the page; the same fit gives the same bytes."""
    groups: dict[str, Iterator[Panel]] = {}
    for trial in held_out:
        groups[f"Foretold: {Path(trial.source).name}"] = _foretold_panels(fit, trial)
    for trial, found in zip(fit.trials, fit.passes, strict=True):
        name = f"Record: {Path(trial.source).name}"
        groups[name] = _record_panels(trial, found.states, found.innovations / found.variances**0.5)
    screens = [
        ("Figures", Markup().join(_figures(report))),
        *map(draw_screen, screens_of(groups)),
        ("Coefficients", Markup().join(_coefficients(report))),
        ("Numbers", listing(render(report).partition("\n")[2])),
    ]
    heading = f"Fitted to its trials by trainer boat fit, version {__version__}"
    return fill_sheet(report.vessel, heading, screens, report)


def _figures(report: BoatFit) -> Iterator[Markup]:
    """Yield figures of manoeuvres with their bands before and after, then warnings."""
    rows = []
    for pair in zip(report.before, report.after, strict=True):
        name, *numbers = figure_row(*pair)
        rows.append((name, draw_pair(*pair), *numbers))
    yield html.table(("figure", "bands", *FIGURE_HEADS[1:]), rows, "numbers figures")
    yield html.paragraph(f"{BAND_WORDS} {BAND_NOTE}", "soft")
    for each in report.warnings:
        yield html.paragraph(each, "bad")
    if not report.warnings:
        yield html.paragraph("Nothing to warn of.", "good")


def draw_pair(before: FigureBand, after: FigureBand) -> Markup:
    """Return both bands of a figure as bars on one scale."""
    bands = [(one.low, one.high) for one in (before, after)]
    ends = [x for band in bands for x in band if x is not None]
    if not ends or min(ends) == max(ends):
        return Markup()
    width, height = BAND_SIZE_PX
    across, parts = Axis(min(ends), max(ends), 1.0, width - 1.0), list[str]()
    for style, room, (low, high) in zip(("before", "after"), (1.0, 4.0), bands, strict=True):
        if low is not None and high is not None:
            x, end = across.at(low), across.at(high)
            parts.append(rect(style, x, room, max(end - x, 1.0), height - 2.0 * room))
    if after.value is not None:
        parts.append(rule("c0", across.at(after.value), 0.0, across.at(after.value), height))
    return svg_element(f"{after.name}: bands before and after", BAND_SIZE_PX, parts)


def _coefficients(report: BoatFit) -> Iterator[Markup]:
    """Yield the coefficients that records told of, the best known first, and name the others."""
    known = sorted(report.coefficients, key=lambda row: row.learned)
    yield html.paragraph("sd: standard deviation. left: its share that the records left.")
    for verdict in VERDICT_WORDS[:-1]:
        told = [coefficient_row(row) for row in known if row.verdict == verdict]
        rows = [(name, left, *numbers) for name, *numbers, left, _ in told]
        yield html.table((verdict, COEFFICIENT_HEADS[-2], *COEFFICIENT_HEADS[1:-2]), rows)
    rest = sorted(row.name for row in known if row.verdict == VERDICT_WORDS[-1])
    yield html.paragraph(f"Not learned, as they were before: {', '.join(rest)}")


def _record_panels(trial: Trial, states: Numbers, scaled: Numbers) -> Iterator[Panel]:
    """Yield where a boat went by the filter, what moved it, and how far each reading was off."""
    t = np.arange(len(states), dtype=float) * trial.interval
    yield Panel(TRACK_TITLE, "east [m]", "north [m]", (track_of("boat", states, trial.interval),))
    moved = (Curve(name, t, trial.inputs[:, at] / DEGREE) for name, at in SURFACES.items())
    yield Panel("surfaces", "time [s]", "[deg]", tuple(moved))
    depth = (Curve("depth", t, states[:, STATE.Z]),)
    yield Panel("depth", "time [s]", "[m]", depth, downwards=True)
    off = (
        Curve(name, t, scaled[:, i], points=True)
        for i, name in enumerate(CHANNEL_NAMES)
        if trial.has(name)
    )
    words = "[standard deviations]"
    yield Panel("readings less foretold", "time [s]", words, tuple(off), levels=SURE_LEVELS)


def _foretold_panels(fit: SearchEnd, trial: Trial) -> Iterator[Panel]:
    """Yield what a held-out record's controls alone foretell, before the fit and after."""
    one = foretell(fit, trial)
    names = {"the boat": one.followed, "fit": one.fit, "prior": one.prior}
    track = (track_of(name, states, trial.interval) for name, states in names.items())
    yield Panel(TRACK_TITLE, "east [m]", "north [m]", tuple(track))
    for title, (unit, at, _) in FORETOLD_CHANNELS.items():
        factor, y = 1.0 / DEGREE if "rad" in unit else 1.0, f"[{unit.replace('rad', 'deg')}]"
        curves = (Curve(name, one.t, factor * states[:, at]) for name, states in names.items())
        yield Panel(title, "time [s]", y, tuple(curves), downwards=title == "depth")


def track_of(name: str, states: Numbers, interval: float) -> Curve:
    """Return where states (n, 17) lead, in water at rest and without roll."""
    sine, cosine = np.sin(states[:, STATE.PSI]), np.cos(states[:, STATE.PSI])
    pitch, v = states[:, STATE.THETA], states[:, STATE.V]
    ahead = states[:, STATE.U] * np.cos(pitch) + states[:, STATE.W] * np.sin(pitch)
    east, north = ahead * sine + v * cosine, ahead * cosine - v * sine
    return Curve(name, interval * np.cumsum(east), interval * np.cumsum(north))
