"""A study by the command line: a file's own, or one of a plain record."""

from dataclasses import replace
from pathlib import Path
from typing import Any, Final

from trainer.config.files import ConfigError, beside
from trainer.config.vessel import load_vessel
from trainer.identify.models import MODELS
from trainer.identify.study import Study, load_study, plain_study
from trainer.identify.study_records import ArmaxTable, Heading, ModelTable, Ship

USUAL: Final = ("sway", "yaw_rate", "heading")


def study_of(file: Path, options: dict[str, Any]) -> Study:
    """Return the study, what the options say taken instead of what it says. ConfigError if wrong.

    ``options`` are those of ``trainer identify``.
    """
    study = load_study(file) if file.suffix == ".toml" else plain_study(file)
    study = replace(study, heading=_heading(study.heading, options))
    if options["exact"]:
        study = replace(study, sensors=None)
    ship = _ship(study, options)
    if options["armax"]:
        return replace(study, ship=ship, armax=_armax(study, options))
    return replace(study, ship=ship, model=_model(study, options))


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
    kind: str = options["model"] or (study.model.kind if study.model else "")
    if not kind:
        raise ConfigError(
            f"{study.path.name}: lacks [model]: say --model 1, 2, 3, nomoto1 or nomoto2"
        )
    if kind not in MODELS:
        raise ConfigError(
            f"model {kind}: is fitted by the command: trainer identify RECORD --model {kind} "
            "--ship FILE"
        )
    outputs = tuple(options["channels"]) or (study.model.outputs if study.model else ())
    outputs = outputs or tuple(name for name in USUAL if name in study.channels)
    kept = tuple(name for name in outputs if name in MODELS[kind].outputs)
    if not kept:
        raise ConfigError(f"model {kind} has outputs {', '.join(MODELS[kind].outputs)}")
    base = study.model or ModelTable(kind=kind, outputs=kept)
    given = {"noise": options["noise"], "method": options["method"]}
    told = {key: value for key, value in given.items() if value is not None}
    return replace(base, kind=kind, outputs=kept, **told)


def _armax(study: Study, options: dict[str, Any]) -> ArmaxTable:
    """Return the ARMAX table."""
    channels = options["channels"]
    base = study.armax or ArmaxTable(output=channels[0] if channels else "yaw_rate")
    if channels:
        base = replace(base, output=channels[0])
    return base if options["most"] is None else replace(base, most=float(options["most"]))
