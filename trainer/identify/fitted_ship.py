"""The Python face of identification: a ship fitted to arrays or a file.

``trainer.identify.fit`` is this module's ``fit``, for notebooks and scripts. It turns arrays or a
file into the same study that ``trainer identify`` carries out, and returns an object with the
results: ``FittedShip`` of a linear model, ``ManoeuvringShip`` of one that is not linear.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Literal, TypedDict, Unpack, cast, overload

import numpy as np

from trainer.boat.ship.models import MODELS as MANOEUVRING_MODELS
from trainer.config.extras import require_library
from trainer.config.files import ConfigError, Position, offer_known, path_named, write_over
from trainer.config.ship.fit_options import FIT_KINDS
from trainer.config.ship.ship import ShipFile, load_ship, ship_text
from trainer.core.kernel import Numbers
from trainer.identify.fitting.minimise import ignore_news
from trainer.identify.judge import fitted as fitting
from trainer.identify.judge.validation import other_problem, other_record, predict_alone
from trainer.identify.model.models import OUTPUT_UNITS
from trainer.identify.options import IdentifyOptions, as_asked, study_of
from trainer.identify.pages.identify import render, screens
from trainer.identify.pages.results import Identification, ShipNumber, describe_fit
from trainer.identify.pages.series import matrices_of, series_of
from trainer.identify.pages.ship_files import nomoto_text, vessel_text
from trainer.identify.record.frames import arrays_of, columns_of, names_of, record_of
from trainer.identify.record.measurements import SHIP_CHANNEL_UNITS, Record
from trainer.identify.record.sources import factor
from trainer.identify.record.study import observe_record, plain_study
from trainer.identify.record.study_records import ParameterRow
from trainer.identify.ships import page as ships_page
from trainer.identify.ships.records import (
    READING_CHANNELS,
    ROLL_CHANNELS,
    load_trial,
    trial_of,
    with_path,
)
from trainer.identify.ships.results import ShipIdentification as IdentifiedShip
from trainer.identify.ships.results import fit_trials
from trainer.report.plots import Panel, Screen, draw_plot, figure_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Frame = Mapping[str, Any] | str | Path
FRAME_PATH: Final = Path("frame")  # what messages call a record of arrays
MANOEUVRING_FIT_OPTIONS: Final = ("ship", "prior_strength")  # not taken by linear ships
OPTION_NAMES: Final = {"speed": "knots", "outputs": "channels"}  # of IdentifyOptions, where others
# fmt: off
LINEAR_FIT_OPTIONS: Final = (  # not taken by ships that are not linear
    "length", "speed", "vessel", "outputs", "noise", "method", "start", "fixed",
)
# fmt: on
ManoeuvringModel = Literal["linear", "mavmm", "abkowitz", "mmg"]


class FitOptions(TypedDict, total=False):
    """The keywords of ``fit``."""

    length: float | None
    speed: float | None
    vessel: str | Path | None
    outputs: Sequence[str]
    columns: Mapping[str, str]
    units: Mapping[str, str]
    positive_rudder: Literal["port", "starboard"]
    noise: Literal["covariance", "innovations", "output-error"] | None
    method: Literal["scoring", "bfgs", "direct"] | None
    start: Mapping[str, float]
    fixed: Mapping[str, float]
    between_readings: Literal["straight", "step"] | None
    every: int | None
    begin: float | None
    end: float | None
    ship: str | Path | None
    prior_strength: float


@overload
def fit(
    frame: Frame | Sequence[Frame], model: ManoeuvringModel, **keywords: Unpack[FitOptions]
) -> "ManoeuvringShip": ...


@overload
def fit(
    frame: Frame,
    model: Literal["1", "2", "3", "nomoto1", "nomoto2"] | None = None,
    **keywords: Unpack[FitOptions],
) -> "FittedShip": ...


def fit(
    frame: Frame | Sequence[Frame], model: Any = None, **keywords: Unpack[FitOptions]
) -> "FittedShip | ManoeuvringShip":
    """Fit a ship to a record of rudder and motion by maximum likelihood.

    It is what ``trainer identify`` does.

    ``frame`` is a mapping of arrays of one length (n,), a pandas frame, or the path of a CSV file,
    a recording or a study. Arrays are ``t`` [s] rising, ``rudder`` and what was read: ``yaw_rate``,
    ``heading``, ``sway``, ``bow_sway``, ``stern_sway``, ``speed``; NaN is a missing reading. They
    are SI and radians, unless ``units`` says otherwise (``{"rudder": "deg"}``), under these names
    or those of a recording (``delta_r``, ``r``, ``psi``, ``v``, ``u``), unless ``columns`` does
    (``{"rudder": "helm"}``). A positive rudder turns to port, or as ``positive_rudder`` says.

    ``model``: 1 is sway and yaw, 2 sway, 3 yaw, ``nomoto1`` K/(1 + T s), ``nomoto2`` K(1 + T3 s)/
    ((1 + T1 s)(1 + T2 s)). ``length`` [m] and ``speed`` [kn] scale it; a ``vessel`` has a length,
    and Model 1's start; without a speed it is the record's mean. ``outputs`` are what is fitted,
    else all that the model has. ``noise``, ``method`` and ``between_readings`` (of the rudder,
    ``straight`` or ``step``) are those of a study. ``start`` and ``fixed`` are numbers of
    parameters to begin from and to hold. One sample of ``every`` is taken, from ``begin`` to
    ``end`` [s].

    ``linear``, ``mavmm``, ``abkowitz`` and ``mmg`` are of ships that are not linear, by the file
    ``ship`` of their dimensions; ``prior_strength`` times the width of what books say. They need
    ``speed``, ``sway`` and ``revolutions`` [1/s] (``n``) too, may have ``wind_ahead`` and
    ``wind_starboard`` [m/s], and take a sequence of frames of one ship. ``every`` is then a mean of
    so many samples. Columns of a CSV file are as the ship's file says.

    TrainerError naming what is wrong: a column that lacks, times that do not rise, a rudder that
    never moves, parameters that the record cannot separate. Look at ``converged`` and ``doubt``.
    Source: Astrom, Kallstrom, Norrbin and Bystrom, Lund 7431 (1974), with exact derivatives.
    """
    require_library("scipy", "identify")
    for name in keywords:
        if name not in FitOptions.__annotations__:
            known = offer_known(name, FitOptions.__annotations__)
            raise ConfigError(f"no keyword {name!r}{known}")
    given = cast("FitOptions", {name: x for name, x in keywords.items() if x is not None})
    _check_keywords({**given, "model": model})
    unfit = LINEAR_FIT_OPTIONS if model in MANOEUVRING_MODELS else MANOEUVRING_FIT_OPTIONS
    if strange := [name for name in unfit if name in keywords]:
        raise ConfigError(f"{', '.join(strange)}: not with model {model}")
    if model in MANOEUVRING_MODELS:
        return _fit_manoeuvring(frame, model, given)
    if not isinstance(frame, str | Path | Mapping) and not hasattr(frame, "keys"):
        raise ConfigError(f"model {model}: takes one frame")
    return _fit_steering(cast("Frame", frame), model, given)


def _check_keywords(given: Mapping[str, Any]) -> None:
    """Check the values of keywords by their kinds; ConfigError if one cannot be."""
    for name, kind in FIT_KINDS.items():
        value = given.get(name)
        if value is not None:  # numpy's numbers are taken as Python's own
            value = [*value] if name == "outputs" else value
            kind.read(name, value.item() if hasattr(value, "item") else value, Position("fit", ""))
    for name in ("start", "fixed"):
        numbers = given.get(name, {})
        if not isinstance(numbers, Mapping):
            raise ConfigError(f"fit: {name}: must be numbers by name, such as {{'T': 20.0}}")
        for key, value in numbers.items():
            if not (isinstance(value, int | float | np.number) and np.isfinite(value)):
                raise ConfigError(f"fit: {name}: {key} = {value!r}: must be a finite number")


def _options_of(model: str | None, given: FitOptions) -> IdentifyOptions:
    """Return what the command would be asked for the same fit."""
    wishes: dict[str, Any] = {OPTION_NAMES.get(name, name): x for name, x in given.items()}
    wishes |= {"vessel": str(given["vessel"])} if "vessel" in given else {}
    known = IdentifyOptions.__dataclass_fields__
    return IdentifyOptions(model=model, **{name: wishes[name] for name in wishes if name in known})


def _fit_steering(frame: Frame, model: str | None, given: FitOptions) -> "FittedShip":
    """Return a linear or Nomoto ship fitted to a record."""
    options, units = _options_of(model, given), given.get("units", {})
    if isinstance(frame, str | Path):
        study, loaded = study_of(Path(frame), options), None
    else:
        plain = plain_study(FRAME_PATH)
        heading = replace(plain.heading, positive_rudder=given.get("positive_rudder", "port"))
        columns = columns_of(frame, given.get("columns", {}), units, ())
        study = replace(plain, path=FRAME_PATH, heading=heading, columns=columns)
        loaded = record_of(arrays_of(frame, study.columns), study.columns)
        study = as_asked(study, options)
    rows = [ParameterRow(name=name, start=x) for name, x in given.get("start", {}).items()]
    fixed = given.get("fixed", {}).items()
    rows += [ParameterRow(name=name, start=x, free="no") for name, x in fixed]
    study = replace(study, parameters=(*study.parameters, *rows))
    fitted = fitting.fit_study(study, observe_record(study, loaded), ignore_news)
    return FittedShip(describe_fit(fitted), units)


def _fit_manoeuvring(
    frame: Frame | Sequence[Frame], model: str, given: FitOptions
) -> "ManoeuvringShip":
    """Return a ship that is not linear, fitted to its records."""
    if "ship" not in given:
        raise ConfigError(f"model {model}: lacks ship, the file of the ship's dimensions")
    ship = load_ship(path_named(str(given["ship"]), "ships"))
    ship = with_path(ship, given.get("between_readings"))
    sign = given.get("positive_rudder", ship.records.positive_rudder)
    ship = replace(ship, records=replace(ship.records, positive_rudder=sign))
    one = isinstance(frame, str | Path) or hasattr(frame, "keys")  # mappings and pandas frames
    frames = cast("Sequence[Frame]", [frame] if one else frame)
    trials = tuple(_trial_of(each, ship, given, given.get("every") or 1) for each in frames)
    if not trials:
        raise ConfigError(f"model {model}: needs a frame")
    options = _options_of(model, given)
    return ManoeuvringShip(fit_trials(ship, trials, (), options, lambda *_: None), given, ship)


def _trial_of(frame: Frame, ship: ShipFile, given: FitOptions, every: int) -> Record:
    """Return a record of a ship that is not linear.

    Arrays are taken as read by instruments, so no errors of sensors are added to them.
    """
    if isinstance(frame, str | Path):
        return load_trial(Path(frame), ship, every)
    columns = columns_of(
        frame, given.get("columns", {}), given.get("units", {}), SHIP_CHANNEL_UNITS
    )
    record = record_of(arrays_of(frame, columns), columns)
    return trial_of(record, replace(ship, sensors=None), every)


class _ShipDisplay:
    """What every fitted ship shows of itself; ``print`` shows the page of ``trainer identify``."""

    _page: Callable[[], str]
    _figures: Callable[[], Sequence[Panel | Screen]]

    def summary(self) -> str:
        """Return the page of ``trainer identify``."""
        return self._page()

    def __repr__(self) -> str:
        return self.summary()

    def plot(self, path: str | Path | None = None) -> "Figure | None":
        """Return matplotlib's figure of all plots, or draw them to a file.

        The file is .png, .svg or .pdf. TrainerError without the extra ``plot``.
        """
        if path is not None:
            draw_plot(self._figures(), Path(path))
            return None
        require_library("matplotlib", "plot")
        return figure_of(self._figures())


class FittedShip(_ShipDisplay):
    """A ship fitted to a record; ``print`` shows the page of ``trainer identify``.

    Gains and time constants are attributes, SI: ``K`` [1/s], ``T1``, ``T2``, ``T3``, ``T`` [s],
    ``K_v`` [m/s] and others of ``numbers``, as far as the model has them.
    """

    def __init__(self, found: Identification, units: Mapping[str, str]) -> None:
        """Take what was identified, and the units of arrays by channel."""
        self._found = found
        self._units = dict(units)
        self._page, self._figures = lambda: render(found.report), lambda: screens(found)

    @property
    def converged(self) -> bool:
        """Return whether the fit has settled; ``doubt`` says why not."""
        return self._found.report.converged

    @property
    def doubt(self) -> str:
        """Return why the fit did not settle, "" if it did."""
        return self._found.report.doubt

    @property
    def parameters(self) -> dict[str, float]:
        """Return the estimates by name, in the model's units: knots, degrees, prime or bis."""
        return {one.name: one.value for one in self._found.report.parameters}

    @property
    def deviations(self) -> dict[str, float]:
        """Return the standard deviations of ``parameters``; NaN where the record gives none."""
        return dict(zip(self.parameters, np.sqrt(np.diag(self.covariance)), strict=True))

    @property
    def covariance(self) -> Numbers:
        """Return the covariance (f, f) of ``parameters``, in their order."""
        scale = self._found.fitted.problem.scale
        return np.asarray(self._found.fitted.known.covariance * np.outer(scale, scale))

    @property
    def numbers(self) -> dict[str, ShipNumber]:
        """Return gains and time constants, SI: ``value``, ``deviation``, ``low`` and ``high``.

        Between ``low`` and ``high`` lie 95 % of the ships that the record allows.
        """
        return {one.name: one for one in self._found.report.ship}

    def __getattr__(self, name: str) -> float:
        """Return a gain or time constant [SI] by its name."""
        # Python asks for _found too, before it is set (copy, pickle): numbers would ask without end
        numbers = {} if name.startswith("_") else self.numbers
        if name not in numbers:
            raise AttributeError(f"this ship has no {name!r}; it has {', '.join(numbers)}")
        return numbers[name].value

    @property
    def log_likelihood(self) -> float:
        """Return log L [-]."""
        return self._found.report.log_likelihood

    @property
    def residuals(self) -> dict[str, Numbers]:
        """Return the one-step errors of each output (n,), in the units of ``fit``."""
        return self._in_units(self._found.run.errors)

    def predict(self, frame: Frame) -> dict[str, Numbers]:
        """Return each output (n,) under the rudder of a record, in the units of ``fit``.

        ``frame`` is as for ``fit``, of the same columns. The model runs by the rudder alone, from
        the initial state that fits the frame's readings best, or from rest where the frame has no
        readings.
        """
        fitted = self._found.fitted
        if isinstance(frame, str | Path):
            record = other_record(fitted, Path(frame))
        else:
            own_columns = fitted.study.columns
            columns = {
                channel: own_columns[channel]
                for channel in own_columns
                if own_columns[channel].name in names_of(frame)
            }
            whole = replace(fitted.study.heading, every=1.0, from_s=None, to_s=None)
            study = replace(fitted.study, heading=whole, sensors=None)
            record = observe_record(study, record_of(arrays_of(frame, columns), columns))
        problem = other_problem(fitted, record)
        return {"t": record.t, **self._in_units(predict_alone(problem, problem.start))}

    def _in_units(self, outputs: Numbers) -> dict[str, Numbers]:
        """Return outputs (n, y) of the models by channel, in the user's units."""
        series = {}
        for i, name in enumerate(self._found.report.outputs):
            unit_factor = factor(name, self._units.get(name))
            series[name] = outputs[:, i] / (OUTPUT_UNITS[name][1] * unit_factor)
        return series

    def series(self) -> dict[str, Numbers]:
        """Return the columns (n,) of ``trainer identify --csv``, with units in their names."""
        return series_of(self._found.fitted)

    def matrices(self) -> dict[str, dict[str, Any]]:
        """Return the system and covariance matrices, at the start values and at the estimate."""
        return {one.of: asdict(one) for one in matrices_of(self._found.fitted)}

    def write(self, path: str | Path) -> None:
        """Write the ship as a Nomoto file, which ``trainer boat manoeuvre`` sails.

        Where Model 1 was fitted to a ``vessel`` it is that vessel's file with the new numbers.
        """
        fitted = self._found.fitted
        whole = fitted.study.ship is not None and fitted.study.ship.vessel is not None
        as_study = fitted.problem.plant.model.name == "1" and whole
        text = vessel_text(fitted) if as_study else nomoto_text(fitted, self._found.report.bend)
        write_over(Path(path), text)


class ManoeuvringShip(_ShipDisplay):
    """A ship that is not linear, fitted to records; ``print`` shows its page.

    It has surge, sway, yaw and heading. Coefficients are accelerations in prime units, after
    docs/nonlinear-ships.md.
    """

    def __init__(self, found: IdentifiedShip, given: FitOptions, ship: ShipFile) -> None:
        """Take what was identified, the keywords of ``fit``, and the ship's file as used."""
        self._found = found
        self._given = given
        self._ship = ship
        self._page = lambda: ships_page.render(found.report)
        self._figures = lambda: ships_page.panels(found)

    @property
    def converged(self) -> bool:
        """Return whether the fit has settled."""
        return self._found.report.settled

    @property
    def parameters(self) -> dict[str, float]:
        """Return the estimated coefficients by name."""
        return {one.name: one.value for one in self._found.report.coefficients}

    @property
    def deviations(self) -> dict[str, float]:
        """Return the standard deviations of ``parameters``."""
        return {one.name: one.deviation for one in self._found.report.coefficients}

    @property
    def covariance(self) -> Numbers:
        """Return the covariance (p, p) of ``parameters``, in their order."""
        p = len(self._found.report.coefficients)
        return self._found.fit.covariance[:p, :p].copy()

    @property
    def prior_share(self) -> dict[str, float]:
        """Return the share of each coefficient's precision that books gave, 0 to 1."""
        return {one.name: one.prior_share for one in self._found.report.coefficients}

    @property
    def untold(self) -> list[dict[str, float]]:
        """Return the combinations that the records do not determine, the worst first."""
        return [one.parts for one in self._found.report.untold]

    @property
    def log_likelihood(self) -> float:
        """Return log L [-], without the prior."""
        fitted = self._found.fit
        return fitted.problem.penalty(fitted.found.theta) - fitted.found.cost  # cost has the prior

    def predict(self, frame: Frame) -> dict[str, Numbers]:
        """Return speed, sway, yaw rate, heading and any roll (n,) by inputs alone.

        ``frame`` and units are as for ``fit``. The ship starts at the first readings of the frame;
        then only rudder, revolutions and wind drive it. Values are NaN from the row on in which the
        state is no longer that of a ship under way.
        """
        trial = _trial_of(frame, self._ship, self._given, 1)  # all rows: the fit alone thins
        sailed = self._found.fit.problem.sail(self._found.fit.found.theta, trial)
        units = self._given.get("units", {})
        names = (*READING_CHANNELS, *ROLL_CHANNELS)
        series = {
            name: values / factor(name, units.get(name))
            for name, values in zip(names, sailed.T, strict=False)
        }
        return {"t": trial.t, **series}

    def write(self, path: str | Path) -> None:
        """Write the ship with its covariance, as a file that ``trainer boat manoeuvre`` sails."""
        source = "trainer.identify.fit, " + ", ".join(self._found.report.sources)
        write_over(Path(path), ship_text(self._found.ship, source))
