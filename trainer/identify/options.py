"""The options of ``trainer identify``, and how they change a study file.

An option overrides the file. Without a file, the columns of the trainer's own recordings are known
and a plain study is made. The command line and ``trainer.identify.fit`` both pass through here.
"""

import os
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

from trainer.config.boat.vessel import load_vessel
from trainer.config.files import ConfigError, quote, relative_name
from trainer.config.ship.fit_options import USUAL_PRIOR_STRENGTH
from trainer.identify.model.models import MODELS
from trainer.identify.model.system_files import load_system
from trainer.identify.record.sources import NO_UNIT, Column
from trainer.identify.record.study import Study, load_study, plain_study
from trainer.identify.record.study_records import ArmaxTable, ModelTable, RunRow, Ship

USUAL_OUTPUTS: Final = ("sway", "yaw_rate", "heading")


@dataclass(frozen=True, kw_only=True)
class IdentifyOptions:
    """A user's wishes beside the study; None means as the study has it.

    ``ship``, ``prior_strength`` and ``predict`` are for ships that are not linear. Of the others
    these ships take ``model``, ``between_readings``, ``every``, ``begin``, ``end`` and ``without``.
    """

    model: str | None = None
    vessel: str | None = None
    length: float | None = None  # [m]
    knots: float | None = None
    channels: tuple[str, ...] = ()  # outputs that are fitted; () is all that the model has
    noise: str | None = None
    method: str | None = None
    exact: bool = False  # a recording is read without errors of instruments
    system: Path | None = None  # of the user's own
    reject: float | None = None  # [-] probability below which a sample is an outlier
    between_readings: str | None = None  # one of INPUT_PATHS, of the rudder
    every: int | None = None
    begin: float | None = None  # [s]
    end: float | None = None  # [s]
    further: tuple[Path, ...] = ()  # records of the same ship
    simulate: bool = False
    data_only: bool = False
    anyway: bool = False  # what its own channels contradict is fitted
    armax: bool = False
    most: int | None = None  # highest ARMAX order
    against: str | None = None  # a simpler model
    without: tuple[str, ...] = ()  # parameters
    check: Path | None = None  # a record to predict
    kappa: Path | None = None  # a record of large manoeuvres
    bech: Path | None = None  # likewise
    spiral: Path | None = None  # steady turns
    joint: bool = False
    matrices: bool = False
    checkpoint: Path | None = None
    ship: Path | None = None  # file of its dimensions
    prior_strength: float = USUAL_PRIOR_STRENGTH  # [-] times the width of what books say
    predict: tuple[Path, ...] = ()  # records held back


def study_of(file: Path, options: IdentifyOptions) -> Study:
    """Return the study of a file, changed as the options say; ConfigError."""
    if file.suffix == ".toml":
        return as_asked(load_study(file), options)
    if not file.exists():
        raise ConfigError(f"{file}: there is no such file")
    return as_asked(plain_study(file), options)


def as_asked(study: Study, options: IdentifyOptions) -> Study:
    """Return the study, changed as ``trainer identify``'s options say; ConfigError if wrong."""
    times = {"every": options.every, "from_s": options.begin, "to_s": options.end}
    taken = "yes" if options.anyway else None
    heading = replace(
        study.heading,
        **_given(**times, between_readings=options.between_readings, anyway=taken),
    )
    runs = list(study.runs)
    for path in options.further:
        if path.suffix == ".toml":
            raise ConfigError(f"{path}: is a study: one study, and further records beside its own")
        runs.append(RunRow(data=os.path.relpath(path, study.path.parent)))
    study = _with_system(replace(study, heading=heading, runs=tuple(runs)), options)
    if options.exact:
        study = replace(study, sensors=None)
    ship = _ship(study, options)
    if options.armax:
        base = study.armax or ArmaxTable(output="yaw_rate")
        most = None if options.most is None else float(options.most)
        armax_options = _given(output=next(iter(options.channels), None), most=most)
        return replace(study, ship=ship, armax=replace(base, **armax_options), model=None)
    if options.data_only:
        return study
    return replace(study, ship=ship, model=_model(study, options))


def _given(**values: Any) -> dict[str, Any]:
    """Return the values that an option gives: those that are not None."""
    return {name: value for name, value in values.items() if value is not None}


def _with_system(study: Study, options: IdentifyOptions) -> Study:
    """Return the study with the user's own system that it or an option names.

    A program is run only where the option names it, because a study may come from anybody.
    """
    named = options.system
    file = study.model.file if study.model and study.model.kind == "own" else None
    if named is None and (file is None or options.model):
        return study
    path = named or study.path.parent / str(file)
    if path.suffix == ".py" and named is None:
        raise ConfigError(
            f"{study.path.name}: [model] file = {quote(str(file))}: is a program, and is run only "
            f"where the command names it: read it, then say --system {path}"
        )
    system = load_system(path)
    if "t" in (*system.inputs, *system.outputs):
        raise ConfigError(f"{path}: t is the time, not what acts or is read: rename the column")
    clock = study.columns.get("t", Column("t", "s"))
    times = {} if study.heading.interval_s and "t" not in study.columns else {"t": clock}
    plain = {name: Column(name, NO_UNIT) for name in (*system.inputs, *system.outputs)}
    return replace(study, system=system, columns={**times, **plain}, sensors=None)


def _ship(study: Study, options: IdentifyOptions) -> Ship | None:
    """Return the ship; None if neither study nor options have one."""
    vessel, length, knots = options.vessel, options.length, options.knots
    ship = study.ship
    if vessel is None and ship is not None and ship.vessel is not None:
        vessel = relative_name(study.path, ship.vessel)
    if vessel is not None and length is None and (ship is None or options.vessel is not None):
        length = load_vessel(vessel).hull.length
    if ship is None and length is None:
        return None
    ship_values = _given(vessel=vessel, length_m=length, speed_kn=knots)
    return replace(ship, **ship_values) if ship is not None else Ship(**ship_values)


def _model(study: Study, options: IdentifyOptions) -> ModelTable:
    """Return the model; ConfigError if neither study nor options name one."""
    fitting = _given(noise=options.noise, method=options.method, reject=options.reject)
    if study.system is not None:
        base = study.model or ModelTable(kind="own")
        return replace(base, kind="own", outputs=study.system.outputs, **fitting)
    kind: str = options.model or (study.model.kind if study.model else "")
    if not kind:
        raise ConfigError(
            f"{study.path.name}: lacks [model]: say --model 1, 2, 3, nomoto1 or nomoto2; "
            "with --ship FILE a ship that is not linear: linear, abkowitz, mavmm or mmg"
        )
    if kind not in MODELS:
        raise ConfigError(
            f"model {kind}: is fitted by the command: trainer identify RECORD --model {kind} "
            "--ship FILE, or trainer.identify.fit"
        )
    outputs = options.channels or (study.model.outputs if study.model else ())
    outputs = outputs or tuple(name for name in USUAL_OUTPUTS if name in study.channels)
    model_outputs = tuple(name for name in outputs if name in MODELS[kind].outputs)
    if not model_outputs:
        raise ConfigError(f"model {kind} has outputs {', '.join(MODELS[kind].outputs)}")
    base = study.model or ModelTable(kind=kind, outputs=model_outputs)
    return replace(base, kind=kind, outputs=model_outputs, **fitting)
