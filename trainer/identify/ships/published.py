"""Published figures of a ship beside those of its model.

The guide of a ship prints them. The uncertainty of its coefficients is that of ships drawn from the
covariance of their fit; without one, from the deviations that the file of figures tells.
"""

from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any, Final

import numpy as np

from trainer.analysis.guide.trials import STEP_SHARE, Published, Trial
from trainer.analysis.guide.uncertainty import spread_of
from trainer.analysis.guide.validation import (
    STEP_MULTIPLES,
    FigureRow,
    InputTable,
    TrialComparison,
    compare_readings,
    count_lines,
    manoeuvre_command,
)
from trainer.analysis.guide.verdicts import Validity
from trainer.analysis.manoeuvres.flight import Flight, fly_manoeuvre
from trainer.config.files import (
    ConfigError,
    Position,
    nearest,
    number_problems,
    raise_problems,
    shipped_names,
    shipped_path,
)
from trainer.config.ship.ship import ShipFile
from trainer.identify.ships.vehicle import IdentifiedShip, draw_ships
from trainer.report.text import ascii_text, table, wrap

DRAWN_SHIPS: Final = 50
ROW_HEADS: Final = ("", "D", "E", "u_val", "", "")
SHORT_VERDICTS: Final = {
    Validity.NOISE: "noise",
    Validity.MODEL_ERROR: "error",
    Validity.ABSENT: "error",
    Validity.UNCERTAIN: "uncertain",
    Validity.NOT_JUDGED: "-",
}


def figures_path(ship: ShipFile) -> Path:
    """Return where the published figures of a ship are; ConfigError if there are none."""
    beside, name = ship.path.with_suffix(".trials.toml"), ship.path.stem
    if beside.is_file():
        return beside
    if name in shipped_names("ships") and shipped_path("ships", name) == ship.path:
        return shipped_path("trials", name)
    raise ConfigError(f"{ship.path.name}: has no published figures beside it, in {beside.name}")


def compare_ship(ship: ShipFile, published: Published) -> tuple[TrialComparison, ...]:
    """Return all figures beside ours. ConfigError for one that is none of its manoeuvre's."""
    _refuse_unknown(ship, published)
    inputs = _spreads(_deviating(ship, published), published)
    step = STEP_SHARE * IdentifiedShip(ship).step
    compared = []
    for trial in published.trials:
        flights = [_sail(ship, trial, each * step) for each in STEP_MULTIPLES]
        readings = [trial.read_flight(published, flight) for flight in flights]
        lost = flights[0] if isinstance(flights[0], str) else flights[0].lost
        speed = trial.heading.speed_m_s
        command = manoeuvre_command(ship.path.stem, trial.name, trial.manoeuvre, speed)
        command += f" --step {step:.4g}"
        compared.append(compare_readings(trial, readings, command, lost, inputs))
    return tuple(compared)


def _refuse_unknown(ship: ShipFile, published: Published) -> None:
    """Raise ConfigError for a coefficient that the ship has not, and for waves."""
    named = {
        **{
            f"fits[{i}]": ("coefficients", one.coefficients) for i, one in enumerate(published.fits)
        },
        **{
            f"deviations[{i}]": ("inputs", one.inputs) for i, one in enumerate(published.deviations)
        },
    }
    problems = [
        Position(published.file, table).wrong(
            key, name, f"no coefficient of {ship.path.name}{nearest(name, ship.coefficients)}"
        )
        for table, (key, names) in named.items()
        for name in names
        if name not in ship.coefficients
    ]
    if published.waves:
        problems.append(Position(published.file, "waves[0]").problem("is for boats, not for ships"))
    raise_problems(number_problems(problems, published.text, published.file))


def _sail(ship: ShipFile, trial: Trial, step: float | None = None) -> Flight | str:
    """Return the flight of a trial, or why there is none."""
    try:
        return fly_manoeuvre(IdentifiedShip(ship, step), trial.manoeuvre, trial.heading.speed_m_s)
    except ConfigError as wrong:
        return str(wrong)


def _deviating(ship: ShipFile, published: Published) -> ShipFile:
    """Return a ship with a covariance: its own, or one of the file of figures."""
    if ship.covariance is not None or not published.deviations:
        return ship
    sizes = {
        name: one.size or (one.share or 0.0) * abs(ship.coefficients[name])
        for one in published.deviations
        for name in one.inputs
    }
    rows = np.diag([size**2 for size in sizes.values()])
    return replace(ship, uncertain=tuple(sizes), covariance=tuple(map(tuple, rows.tolist())))


def _spreads(ship: ShipFile, published: Published) -> InputTable:
    """Return u_input by title and quantity; none where nothing of the ship is uncertain."""
    values: dict[tuple[str, str], list[float]] = {}
    for drawn in draw_ships(ship, DRAWN_SHIPS):
        for trial in published.trials:
            with suppress(ConfigError):  # a ship that cannot sail
                read = trial.read_flight(published, _sail(drawn, trial))
                for figure, value in zip(trial.results, read, strict=True):
                    if value is not None:
                        values.setdefault((trial.heading.title, figure.quantity), []).append(value)
    return {key: spread_of(np.array(each)) for key, each in values.items() if len(each) > 1}


def render(ship: ShipFile, published: Published, compared: Sequence[TrialComparison]) -> str:
    """Return the figures as text of 79 columns."""
    lines = [ascii_text(f"PUBLISHED FIGURES: {ship.name}"), ""]
    lines += [line for text in count_lines(compared) for line in wrap(text)]
    for fit in published.fits:
        lines += wrap(ascii_text(f"Fitted to {fit.to}: {', '.join(fit.coefficients)}"))
    for each in compared:
        lines += ["", *wrap(ascii_text(f"{each.title}. {each.source}")), *wrap(each.command)]
        lines += table(ROW_HEADS, [_cells(row) for row in each.rows])
    return "\n".join(lines)


def _cells(row: FigureRow) -> tuple[str, ...]:
    """Return the cells of a figure."""
    one = row.figure
    texts = [f"{one.quantity} [{one.unit}]", f"{one.value:.4g}"]
    texts += ["-" if each is None else f"{each:.3g}" for each in (row.error, row.u_val)]
    return *texts, one.use, SHORT_VERDICTS[row.verdict]


def figures_of(compared: Sequence[TrialComparison]) -> Iterator[dict[str, Any]]:
    """Yield the same for programs."""
    for each in compared:
        rows = [
            asdict(row) | {"error": row.error, "u_val": row.u_val, "verdict": row.verdict}
            for row in each.rows
        ]
        yield asdict(each) | {"rows": rows}
