"""The kernels of a fit compiled for later: ``python -m trainer.identify.compiling``."""

import os
import resource
from typing import Final

import numpy as np

from trainer.identify import first_fit
from trainer.identify.likelihood import Likelihood
from trainer.identify.models import MODELS, Plant
from trainer.identify.predictor import Innovations, MultiStep, settled_gain
from trainer.identify.rehearsal import TANKER, TANKER_RUDDER
from trainer.identify.shown import shown, unlimited
from trainer.identify.simulate import deterministic

LONGEST: Final = 600  # [s] of processor time: whatever happens, it ends
POLITE: Final = 5  # an interpreted fit beside it goes first


def compile_fits() -> None:
    """Use all that a fit by covariances needs, of every model."""
    problem = TANKER.problem(TANKER_RUDDER[:20], missing=0.2)
    cost = Likelihood(problem)
    cost.value(problem.start)
    cost.slope(problem.start)
    cost.information(problem.start)
    shown(problem, problem.start, unlimited(len(problem.plant.outputs)))
    deterministic(problem, problem.start)
    for model in MODELS.values():
        plant = Plant(model, TANKER.ship, model.outputs[-1:], 1.0)
        theta = np.arange(1.0, 1.0 + len(model.parameters))[None]
        plant.blocks(theta)
        plant.blocks(theta.astype(complex))


def compile_predictors() -> None:
    """Use what the other noise models and longer predictions need."""
    problem = TANKER.problem(TANKER_RUDDER[:20])
    Innovations(problem, settled_gain).value(problem.start)
    MultiStep(problem, 1, 2).value(problem.start)


def main() -> None:
    """Compile what fits need, unless that has been done."""
    os.nice(POLITE)
    resource.setrlimit(resource.RLIMIT_CPU, (LONGEST, LONGEST))
    with first_fit.alone():
        if not first_fit.kept():
            compile_fits()
            first_fit.keep()
            compile_predictors()


if __name__ == "__main__":
    main()
