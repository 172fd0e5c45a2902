"""Simpler models beside a fit, by the likelihood ratio (MI 8.3).

``trainer identify --against`` and ``--without`` ask whether a simpler model would do: twice the
difference of the log-likelihoods is compared with chi-square of the parameters that are fewer.
``pages/results`` calls it; MI is the model document.
"""

from dataclasses import dataclass, replace
from typing import Final

from trainer.config.files import ConfigError
from trainer.identify.fitting.minimise import ignore_news
from trainer.identify.fitting.study_problem import table_of
from trainer.identify.judge.fitted import ModelFit, fit_study
from trainer.identify.judge.residuals import aic_of_likelihood, ratio_test
from trainer.identify.model.models import MODELS
from trainer.identify.record.study import Study
from trainer.identify.record.study_records import ParameterRow

ZERO_PARAMETERS: Final = {"T3": "b1"}  # what is nothing where a number that follows from it is


@dataclass(frozen=True)
class RivalModel:
    """A simpler model, and the likelihood-ratio test of the larger one against it."""

    name: str
    parameters: int
    log_likelihood: float
    aic: float
    ratio: float  # 2 (log L of the larger - log L)
    freedom: int
    probability: float  # [-] of so large a ratio by chance: small, and the larger is worth it


def compare_without(fitted: ModelFit, names: tuple[str, ...]) -> RivalModel:
    """Return the test against the same model with the parameters ``names`` at zero.

    ConfigError if one of them was not estimated.
    """
    model, study = fitted.problem.plant.model, fitted.study
    wanted = [model.names[model.index(ZERO_PARAMETERS.get(name, name))] for name in names]
    shown_names = [
        name if name in ZERO_PARAMETERS else one for name, one in zip(names, wanted, strict=True)
    ]
    held = [name for name in wanted if name not in fitted.problem.names]
    if held:
        raise ConfigError(f"--without {held[0]}: it was not estimated, so there is nothing to test")
    rows = tuple(
        row
        for row in study.parameters
        if row.name in model.given or model.names[model.index(row.name)] not in wanted
    )
    nothing = tuple(ParameterRow(name=name, start=0.0, free="no") for name in wanted)
    smaller = replace(study, parameters=(*rows, *nothing))
    return _test_smaller(fitted, smaller, "without " + ", ".join(shown_names))


def compare_models(fitted: ModelFit, kind: str) -> RivalModel:
    """Return the test against another model of the same outputs; ConfigError if it lacks one."""
    table = table_of(fitted.study)
    lacking = [name for name in table.outputs if name not in MODELS[kind].outputs]
    if lacking:
        raise ConfigError(f"--against {kind}: it has no {lacking[0]}, which this fit has")
    smaller = replace(fitted.study, model=replace(table, kind=kind), parameters=())
    return _test_smaller(fitted, smaller, f"model {kind}")


def _test_smaller(fitted: ModelFit, smaller: Study, name: str) -> RivalModel:
    """Return the fit of a smaller study, and the test against it."""
    table = table_of(smaller)
    if (table.predict_from, table.predict_to) != (1.0, 1.0):
        raise ConfigError("order tests need the likelihood: predict one step, not more")
    other = fit_study(smaller, fitted.record, ignore_news, others=fitted.others)
    count, full_count = len(other.problem.names), len(fitted.problem.names)
    test = ratio_test((other.log_likelihood, count), (fitted.log_likelihood, full_count))
    return RivalModel(
        name=name,
        parameters=count,
        log_likelihood=other.log_likelihood,
        aic=aic_of_likelihood(other.log_likelihood, count),
        ratio=test.statistic,
        freedom=test.freedom,
        probability=test.probability,
    )
