"""The file in which a search keeps how far it has come."""

import json
import math
import os
from pathlib import Path

import numpy as np

from trainer.config.files import ConfigError, quote
from trainer.core.kernel import Numbers
from trainer.identify.fitting.minimise import Found, Progress, unheard
from trainer.identify.fitting.problem import Problem


def keep(path: Path, problem: Problem, heard: Progress = unheard) -> Progress:
    """Return what keeps each step of a search in ``path``, and tells it."""

    def write(found: Found) -> None:
        theta = problem.folded(found.theta) * problem.scale
        told = {
            "model": problem.plant.model.name,
            "cost": found.cost,
            "parameters": dict(zip(problem.names, map(float, theta), strict=True)),
        }
        part = path.with_name(path.name + ".part")
        part.write_text(json.dumps(told, indent=1) + "\n", encoding="utf-8")
        os.replace(part, path)  # noqa: PTH105 - one call that is atomic on every system
        heard(found)

    return write


def resume(path: Path, problem: Problem) -> Numbers:
    """Return where to start (f,), from a file that ``keep`` wrote.

    ConfigError if it is of another model or lacks a free parameter.
    """
    try:
        told = json.loads(path.read_text(encoding="utf-8"), parse_int=float)
        model, parameters = told["model"], dict(told["parameters"])
    except (OSError, ValueError, KeyError, TypeError, RecursionError) as error:
        raise ConfigError(f"{path.name}: is no checkpoint of a search ({error})") from None
    if model != problem.plant.model.name:
        raise ConfigError(f"{path.name}: is of model {model}, not {problem.plant.model.name}")
    lacking = [name for name in problem.names if name not in parameters]
    if lacking:
        raise ConfigError(f"{path.name}: lacks {', '.join(lacking)}, which are free here")
    for name in problem.names:
        value = parameters[name]
        if isinstance(value, bool) or not isinstance(value, float) or not math.isfinite(value):
            raise ConfigError(f"{path.name}: {name} = {quote(value)}: must be a number")
    return np.array([parameters[name] for name in problem.names]) / problem.scale
