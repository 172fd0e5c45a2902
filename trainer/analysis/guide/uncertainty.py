"""The uncertainty of our figures by that of the boat's coefficients and masses.

``trainer boat guide --uncertainty`` draws whole boats, flies every published manoeuvre with each,
and writes a table beside the file of figures; other guides read it. A coefficient has its standard
deviation from its source, else from the estimate's share of it. Those that were fitted to published
figures are drawn together, by the covariance of that fit: linear about the boat, the spread before
the fit as its prior, and residuals that are larger than the readings' uncertainty count as noise.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, partial
from pathlib import Path
from typing import Any, Final, NamedTuple

import numpy as np

from trainer.analysis.estimate.uncertainty import (
    FIXED_SIGN_COEFFICIENTS,
    MIN_REMAINING_SHARE,
    coefficient_origins,
    deviates,
    relative_deviation,
    root_of,
    tables,
)
from trainer.analysis.guide.programme import FlightTable, fly_boat
from trainer.analysis.guide.trials import (
    FITTED,
    Published,
    figures_digest,
    load_published,
    numbers_digest,
    trials_path,
)
from trainer.analysis.guide.validation import InputTable, wave_values
from trainer.config.boat.propulsion import ThrustRows
from trainer.config.boat.vessel import VesselFile, load_vessel
from trainer.config.boat.vessel_records import ThrustSet
from trainer.config.files import (
    ConfigError,
    Position,
    nearest,
    parse_toml,
    text_if_there,
    toml_value,
)
from trainer.core.kernel import Numbers
from trainer.workers import worker_pool

DRAWN_BOATS: Final = 200
NUDGE: Final = 0.1  # of a standard deviation, for slopes
CHUNK_BOATS: Final = 5  # handed to a process at once
MIDDLE_PERCENT: Final = (15.865, 84.135)  # [%] a standard deviation of a normal either way
CAUSE_COUNT: Final = 3  # of a figure's uncertainty, that are told
MIN_CAUSE_SHARE: Final = 0.05  # [-] of its variance
TABLE_NAME: Final = "{boat}.uncertainty.toml"
OWN_ESTIMATE: Final = "no source: the project's own estimate"
BODY_SHARES: Final = {"mass": 0.01, "Ix": 0.05, "Iy": 0.05, "Iz": 0.05, "BG": 0.05}  # estimates
THRUST_INPUT: Final = "thrust"  # a, b and c of the propeller together, over the file's


class InputDeviation(NamedTuple):
    """A number of the boat, and one standard deviation of it."""

    name: str
    value: float
    sd: float
    reason: str
    line: int = 0  # of the stored table


class Cause(NamedTuple):
    """A part of a figure's uncertainty."""

    name: str  # of the input
    share: float  # [-] of the variance


@dataclass(frozen=True)
class FigureSpread:
    """The spread of one of our figures by its inputs, in its source's unit."""

    title: str
    quantity: str
    members: int  # drawn boats that have it
    u_input: float
    causes: tuple[Cause, ...]
    line: int  # of the table


@dataclass(frozen=True)
class SpreadTable:
    """The stored table of a boat's spreads."""

    file: str
    text: str
    stale: str  # why it is not of this boat; "" where it is
    members: int
    inputs: tuple[InputDeviation, ...]
    spreads: tuple[FigureSpread, ...]

    def by_figure(self) -> InputTable:
        """Return u_input by title and quantity; none where the table is stale."""
        kept = () if self.stale else self.spreads
        return {(one.title, one.quantity): one.u_input for one in kept}


def changed_boat(file: VesselFile, values: Mapping[str, float]) -> VesselFile:
    """Return the boat with other coefficients [-], mass [kg], inertias [kg m2], BG [m], thrust."""
    hull, factor = file.hull, values.get(THRUST_INPUT, 1.0)
    ratio = values.get("mass", hull.mass) / hull.mass  # weight and buoyancy with it
    x, y, z = hull.cb
    hull = replace(
        hull,
        mass=hull.mass * ratio,
        weight=hull.weight * ratio,
        buoyancy=hull.buoyancy * ratio,
        cb=(x, y, hull.cg[2] - values["BG"] if "BG" in values else z),
        Ix=values.get("Ix", hull.Ix),
        Iy=values.get("Iy", hull.Iy),
        Iz=values.get("Iz", hull.Iz),
    )

    def scaled(row: ThrustSet) -> ThrustSet:
        return replace(row, a=factor * row.a, b=factor * row.b, c=factor * row.c)

    ahead, (first, second) = file.thrust
    thrust = ThrustRows(tuple(map(scaled, ahead)), (scaled(first), scaled(second)))
    changed = {name: value for name, value in values.items() if name in file.coefficients}
    return replace(file, hull=hull, thrust=thrust, coefficients={**file.coefficients, **changed})


def prior_deviations(file: VesselFile, published: Published) -> list[InputDeviation]:
    """Return the inputs that are not 0, each with its standard deviation before any fit.

    ConfigError where the file of figures has one of what there is not.
    """
    hull, c = file.hull, file.coefficients
    values = {name: value for name, value in c.items() if value}
    values |= {"mass": hull.mass, "Ix": hull.Ix, "Iy": hull.Iy, "Iz": hull.Iz}
    values |= {"BG": hull.cg[2] - hull.cb[2], THRUST_INPUT: 1.0}
    m_prime = 2.0 * hull.mass / (file.fluid.rho * hull.length**3)
    found = {}
    for name, value in values.items():
        if name in BODY_SHARES:
            sd, reason = BODY_SHARES[name] * abs(value), OWN_ESTIMATE
        elif name == THRUST_INPUT:
            sd, reason = tables()["unfitted"]["resistance"], "the estimate's, of the resistance"
        else:
            sd = relative_deviation(c, m_prime, name)
            reason = f"the estimate's: {sd / abs(value):.0%} ({coefficient_origins()[name]})"
        found[name] = InputDeviation(name, value, sd, reason)
    for i, one in enumerate(published.deviations):
        for name in one.inputs:
            if name not in found:
                advice = f"no number of the boat that is not 0{nearest(name, values)}"
                position = Position(published.file, f"deviations[{i}]")
                raise ConfigError(position.wrong("inputs", name, advice))
            sd = one.size if one.size is not None else (one.share or 0.0) * abs(values[name])
            found[name] = InputDeviation(name, values[name], sd, one.reason)
    return list(found.values())


def figure_values(file: VesselFile, published: Published) -> list[float]:
    """Return every figure of a boat, in the order of ``published.figures``; NaN for none."""
    flown: FlightTable = {}
    values: list[float | None] = []
    for trial in published.trials:
        task = trial.task(file)
        if task not in flown:
            flown[task] = fly_boat(file, task)
        values += trial.read_flight(published, flown[task])
    for waves in published.waves:
        found = wave_values(file, waves, waves.heading.speed_m_s)
        values += [None] * len(waves.results) if isinstance(found, str) else found
    return [math.nan if value is None else value for value in values]


@cache
def _boat_and_figures(path: Path) -> tuple[VesselFile, Published]:
    """Return a boat and its figures, read once in each process."""
    file = load_vessel(str(path))
    return file, load_published(trials_path(file) or path)


def _changed_values(path: Path, values: Mapping[str, float]) -> list[float]:
    """Return every figure of the boat of a file, changed; for a process of its own."""
    file, published = _boat_and_figures(path)
    return figure_values(changed_boat(file, values), published)


def fit_covariance(slopes: Numbers, errors: Numbers, u_data: Numbers, prior: Numbers) -> Numbers:
    """Return the covariance of fitted inputs.

    ``slopes`` has a row a figure and a column an input, ``errors`` and ``u_data`` one number a
    figure, ``prior`` the standard deviation of each input before the fit.
    """
    freedom = max(len(errors) - len(prior), 1)
    noise = max(1.0, float(np.sum((errors / u_data) ** 2)) / freedom)
    weighted = slopes / u_data[:, None]
    return np.asarray(np.linalg.inv(weighted.T @ weighted / noise + np.diag(1.0 / prior**2)))


def fly_uncertainty(
    file: VesselFile, published: Published, cores: int, step: Callable[[], None]
) -> str:
    """Return the text of the table of spreads; ``step`` is called after each drawn boat."""
    inputs = prior_deviations(file, published)
    fitted = _fitted_indices(published, inputs)
    with worker_pool(cores) as pool:
        fly = partial(_changed_values, file.path)

        def fly_all(boats: Sequence[Mapping[str, float]]) -> Numbers:
            rows = []
            for row in pool.map(fly, boats, chunksize=CHUNK_BOATS):
                rows.append(row)
                step()
            return np.array(rows)

        together = np.eye(len(inputs))  # correlations
        if fitted:
            joint = _joint(published, [inputs[index] for index in fitted], fly_all)
            sd = np.sqrt(np.diag(joint))
            together[np.ix_(fitted, fitted)] = joint / np.outer(sd, sd)
            for index, size in zip(fitted, sd, strict=True):
                reason = f"the fit's covariance; before it {inputs[index].reason}"
                inputs[index] = inputs[index]._replace(sd=float(size), reason=reason)
        root, drawn = root_of(together), []
        for number in range(1, DRAWN_BOATS + 1):
            pairs = zip(inputs, root @ deviates(number, len(inputs)), strict=True)
            drawn.append([_kept_sign(one, one.value + one.sd * float(z)) for one, z in pairs])
        names = [one.name for one in inputs]
        values = fly_all([dict(zip(names, row, strict=True)) for row in drawn])
    return _write_table(file, published, inputs, np.array(drawn), values)


def flight_count(published: Published) -> int:
    """Return how many boats ``fly_uncertainty`` flies."""
    fitted = sum(len(fit.coefficients) for fit in published.fits)
    return DRAWN_BOATS + (2 * fitted + 1) * bool(fitted)


def _fitted_indices(published: Published, inputs: Sequence[InputDeviation]) -> list[int]:
    """Return the indices of the inputs that were fitted; ConfigError for one that there is not."""
    names = [one.name for one in inputs]
    for i, fit in enumerate(published.fits):
        for name in fit.coefficients:
            if name not in names:
                position = Position(published.file, f"fits[{i}]")
                advice = f"no coefficient that is not 0{nearest(name, names)}"
                raise ConfigError(position.wrong("coefficients", name, advice))
    return [names.index(name) for fit in published.fits for name in fit.coefficients]


def _joint(
    published: Published,
    inputs: Sequence[InputDeviation],
    fly_all: Callable[[Sequence[Mapping[str, float]]], Numbers],
) -> Numbers:
    """Return the covariance of fitted inputs by the figures that they were fitted to."""
    ways = [(one, sign * NUDGE * one.sd) for one in inputs for sign in (1.0, -1.0)]
    values = fly_all([{}, *({one.name: one.value + change} for one, change in ways)])
    sd = np.array([one.sd for one in inputs])
    slopes = (values[1::2] - values[2::2]).T / (2.0 * NUDGE * sd)
    figures = [figure for _, figure in published.figures]
    used = np.array([figure.use == FITTED for figure in figures])
    used &= np.isfinite(slopes).all(axis=1) & np.isfinite(values[0])
    errors = values[0] - np.array([figure.value for figure in figures])
    u_data = np.array([figure.u for figure in figures])
    return fit_covariance(slopes[used], errors[used], u_data[used], sd)


def _kept_sign(one: InputDeviation, drawn: float) -> float:
    """Return a drawn value; what never changes its sign keeps a tenth of its own."""
    one_sided = one.name in FIXED_SIGN_COEFFICIENTS or one.name in (*BODY_SHARES, THRUST_INPUT)
    if one_sided and drawn * one.value < MIN_REMAINING_SHARE * one.value**2:
        return MIN_REMAINING_SHARE * one.value
    return drawn


def spread_of(values: Numbers) -> float:
    """Return half the range of the middle 68 % of values.

    It is a standard deviation without its tails. Few drawn boats are nearly unstable. Their swings
    would make the root of the mean square another number for each set of draws.
    """
    low, high = np.percentile(values, MIDDLE_PERCENT)
    return float(0.5 * (high - low))


def _causes(own: Sequence[InputDeviation], drawn: Numbers, values: Numbers) -> tuple[Cause, ...]:
    """Return the inputs that most of a figure's variance goes with, the largest first."""
    shares = [
        Cause(one.name, float(np.corrcoef(column, values)[0, 1] ** 2))
        for one, column in zip(own, drawn.T, strict=True)
        if column.std() > 0.0 and values.std() > 0.0
    ]
    shares.sort(key=lambda cause: -cause.share)
    return tuple(cause for cause in shares[:CAUSE_COUNT] if cause.share >= MIN_CAUSE_SHARE)


def _write_table(
    file: VesselFile,
    published: Published,
    own: Sequence[InputDeviation],
    drawn: Numbers,
    values: Numbers,
) -> str:
    """Return the table as TOML, a line for each input and figure."""
    lines = [
        f"# Written by `trainer boat guide {file.path.stem} --uncertainty`, for the guide to read.",
        "# inputs: name, value, one standard deviation, its reason",
        "# figures: title, quantity, drawn boats that have it, u_input, its largest causes",
        f"vessel = {toml_value(numbers_digest(file))}",
        f"figures_digest = {toml_value(figures_digest(published))}",
        f"members = {DRAWN_BOATS}",
        "inputs = [",
    ]
    for one in own:
        row = [one.name, float(f"{one.value:.6g}"), float(f"{one.sd:.3g}"), one.reason]
        lines.append(f"    {toml_value(row)},")
    lines += ["]", "figures = ["]
    for (title, figure), column in zip(published.figures, values.T, strict=True):
        there = np.isfinite(column)
        count = int(there.sum())
        u = spread_of(column[there]) if count > 1 else 0.0
        causes = _causes(own, drawn[there], column[there]) if count > 1 else ()
        cells = [text for one in causes for text in (one.name, round(one.share, 2))]
        row = [title, figure.quantity, count, float(f"{u:.3g}"), *cells]
        lines.append(f"    {toml_value(row)},")
    return "\n".join([*lines, "]", ""])


def table_path(published: Published) -> Path:
    """Return where the table of a file of figures is."""
    boat = published.path.name.removesuffix(".toml").removesuffix(".trials")
    return published.path.with_name(TABLE_NAME.format(boat=boat))


def load_spreads(file: VesselFile, published: Published) -> SpreadTable | None:
    """Return the stored table, None if there is none; ConfigError if it is damaged."""
    path = table_path(published)
    text = text_if_there(path)
    if text is None:
        return None
    table: Any = parse_toml(text, path.name)
    lines = {line.strip(" ,"): number for number, line in enumerate(text.split("\n"), start=1)}
    now = {"vessel": numbers_digest(file), "figures_digest": figures_digest(published)}
    try:
        inputs = tuple(_read_input(row, lines) for row in table["inputs"])
        spreads = tuple(_read_spread(row, lines) for row in table["figures"])
        then = {name: str(table[name]) for name in now}
        members = int(table["members"])
        sizes = [*(one.sd / one.value for one in inputs), *(one.u_input for one in spreads)]
        if not all(map(math.isfinite, sizes)):
            raise ValueError("a number that is not finite")  # noqa: TRY301  as the others are
    except (KeyError, TypeError, ValueError, ArithmeticError) as error:
        raise ConfigError(f"{path.name}: is no table of --uncertainty: {error!r}") from None
    stale = [f"{name} {then[name]}, now {now[name]}" for name in now if then[name] != now[name]]
    told = f"{path.name} was flown with {', '.join(stale)}" if stale else ""
    return SpreadTable(path.name, text, told, members, inputs, spreads)


def _read_input(row: Any, lines: Mapping[str, int]) -> InputDeviation:
    """Return an input's row of the table, with its line; TypeError or ValueError if it is none."""
    name, value, sd, reason = row
    line = lines.get(toml_value(row), 0)
    return InputDeviation(str(name), float(value), float(sd), str(reason), line)


def _read_spread(row: Any, lines: Mapping[str, int]) -> FigureSpread:
    """Return a figure's row likewise."""
    title, quantity, count, u, *causes = row
    pairs = zip(causes[::2], causes[1::2], strict=True)
    told = tuple(Cause(str(name), float(share)) for name, share in pairs)
    line = lines.get(toml_value(row), 0)
    return FigureSpread(str(title), str(quantity), int(count), float(u), told, line)
