"""A study by the command line: a file's own, or one of a plain record."""

import os
from dataclasses import replace
from pathlib import Path
from typing import Any, Final

from trainer.config.files import ConfigError, beside, quote
from trainer.config.vessel import load_vessel
from trainer.identify.model.models import MODELS
from trainer.identify.model.system_files import load_system
from trainer.identify.record.sources import PLAIN, Column
from trainer.identify.record.study import Study, load_study, plain_study
from trainer.identify.record.study_records import ArmaxTable, Heading, ModelTable, RunRow, Ship

USUAL: Final = ("sway", "yaw_rate", "heading")


def study_of(file: Path, options: dict[str, Any]) -> Study:
    """Return the study of a file, changed as the options say; ConfigError."""
    if file.suffix == ".toml":
        return as_asked(load_study(file), options)
    if not file.exists():
        raise ConfigError(f"{file}: there is no such file")
    return as_asked(plain_study(file), options)


def as_asked(study: Study, options: dict[str, Any]) -> Study:
    """Return the study, changed as ``trainer identify``'s options say; ConfigError if wrong."""
    study = replace(study, heading=_heading(study.heading, options))
    further = tuple(_run(study, path) for path in options.get("further", ()))
    study = _with_system(replace(study, runs=(*study.runs, *further)), options)
    if options["exact"]:
        study = replace(study, sensors=None)
    ship = _ship(study, options)
    if options["armax"]:
        return replace(study, ship=ship, armax=_armax(study, options))
    if options.get("data_only"):
        return study
    return replace(study, ship=ship, model=_model(study, options))


def _run(study: Study, path: Path) -> RunRow:
    """Return a further record; ConfigError if it is none."""
    if path.suffix == ".toml":
        raise ConfigError(f"{path}: is a study: one study, and further records beside its own")
    return RunRow(data=os.path.relpath(path, study.path.parent))


def _with_system(study: Study, options: dict[str, Any]) -> Study:
    """Return the study with the system of the user's own that it or an option names.

    A program is run only where the option names it: a study may come from anybody.
    """
    named: Path | None = options.get("system")
    file = study.model.file if study.model and study.model.kind == "own" else None
    if named is None and (file is None or options["model"]):
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
    plain = {name: Column(name, PLAIN) for name in (*system.inputs, *system.outputs)}
    return replace(study, system=system, columns={**times, **plain}, sensors=None)


def _heading(heading: Heading, options: dict[str, Any]) -> Heading:
    """Return the heading with the part of the record that is asked for."""
    given = {"every": options["every"], "from_s": options["begin"], "to_s": options["end"]}
    return replace(heading, **{key: value for key, value in given.items() if value is not None})


def _ship(study: Study, options: dict[str, Any]) -> Ship | None:
    """Return the ship; None if neither study nor options tell of one."""
    vessel, length, knots = options["vessel"], options["length"], options["knots"]
    ship = study.ship
    if vessel is None and ship is not None and ship.vessel is not None:
        vessel = beside(study.path, ship.vessel)
    if vessel is not None and length is None and (ship is None or options["vessel"] is not None):
        length = load_vessel(vessel).hull.length
    if ship is None and length is None:
        return None
    given = {"vessel": vessel, "length_m": length, "speed_kn": knots}
    told = {key: value for key, value in given.items() if value is not None}
    return replace(ship, **told) if ship is not None else Ship(**told)


def _model(study: Study, options: dict[str, Any]) -> ModelTable:
    """Return the model; ConfigError if none is said."""
    if study.system is not None:
        base = study.model or ModelTable(kind="own")
        return replace(base, kind="own", outputs=study.system.outputs, **_fitting(options))
    kind: str = options["model"] or (study.model.kind if study.model else "")
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
    outputs = tuple(options["channels"]) or (study.model.outputs if study.model else ())
    outputs = outputs or tuple(name for name in USUAL if name in study.channels)
    kept = tuple(name for name in outputs if name in MODELS[kind].outputs)
    if not kept:
        raise ConfigError(f"model {kind} has outputs {', '.join(MODELS[kind].outputs)}")
    base = study.model or ModelTable(kind=kind, outputs=kept)
    return replace(base, kind=kind, outputs=kept, **_fitting(options))


def _fitting(options: dict[str, Any]) -> dict[str, Any]:
    """Return what options say of how to fit."""
    names = ("noise", "method", "reject")
    return {name: options[name] for name in names if options.get(name) is not None}


def _armax(study: Study, options: dict[str, Any]) -> ArmaxTable:
    """Return the ARMAX table."""
    channels = options["channels"]
    base = study.armax or ArmaxTable(output=channels[0] if channels else "yaw_rate")
    if channels:
        base = replace(base, output=channels[0])
    return base if options["most"] is None else replace(base, most=float(options["most"]))
