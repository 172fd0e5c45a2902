"""The vessel file of a fitted boat: its prior's, with what records told."""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, Final

import numpy as np

from trainer import __version__
from trainer.analysis.estimate.boat_file import stable_steps, table_lines
from trainer.analysis.gains import design_gains
from trainer.config.boat.coefficients import FORCE_AXES
from trainer.config.boat.vessel import parse_vessel
from trainer.config.files import ConfigError, toml_value
from trainer.core.terms import COEFFICIENTS
from trainer.identify.boat.regressors import HEIGHT_KEY, PARAMETER_NAMES
from trainer.identify.boat.report import BoatFit
from trainer.identify.boat.search import SearchEnd
from trainer.identify.boat.vessel import joined_row

# tables of the prior that are of its own coefficients: a compact set is found anew
OUTDATED_TABLES: Final = ("compact", "compensation", "reduction", "fit", "covariance", "autopilot")
FILE_HEAD: Final = """\
# {name}: fitted to {count} of its trials by `trainer boat fit`, version {version}.
# Before the fit it was {prior}. Each coefficient has its standard deviation (sd) before and after,
# and whether the records told it. [covariance] has what they know of each other."""


def fitted_text(fit: SearchEnd, report: BoatFit, path: Path) -> tuple[str, str]:
    """Return the text of a fitted boat's file, and why it lacks gains, if so.

    As an estimated boat it has the longest step that is stable and that gains hold, no longer than
    its prior's.
    """
    tables = fitted_tables(fit, report)
    text = _text(tables, report)
    file, problem = parse_vessel(text, path), ""
    own = file.run.step_s
    for step in (own, *(step for step in stable_steps(file) if step < own)):
        stepped = {**tables, "run": {**tables["run"], "step_s": step}}
        try:
            gains = design_gains(parse_vessel(_text(stepped, report), path))
        except ConfigError as wrong:
            problem = problem or wrong.problems[0]
        else:
            return _text({**stepped, "autopilot": gains}, report), ""
    return text, problem


def fitted_tables(fit: SearchEnd, report: BoatFit) -> dict[str, Any]:
    """Return the tables of a fitted boat, without gains."""
    vessel = fit.prior.vessel
    kept = {key: one for key, one in fit.prior.tables.items() if key not in OUTDATED_TABLES}
    found = {row.name: _round(row.value) for row in report.coefficients}
    rows = [joined_row(row, vessel.thrust, found) for row in kept["propulsion"]["sets"]]
    body = kept["vessel"]
    return {
        **kept,
        "vessel": {**body, "cb": [*body["cb"][:2], found[HEIGHT_KEY]]},
        "propulsion": {**kept["propulsion"], "sets": rows},
        "coefficients": {term.key: found[term.key] for term in COEFFICIENTS},
        "covariance": covariance_rows(fit),
        "fit": _documentation(report),
    }


def covariance_rows(fit: SearchEnd) -> dict[str, list[float]]:
    """Return the covariance of the parameters that have a deviation, a row each."""
    root = fit.posterior.root
    moving = np.flatnonzero(fit.posterior.sd > 0.0)
    matrix = np.einsum("ik,jk->ij", root[moving], root[moving])
    return {PARAMETER_NAMES[i]: row.tolist() for i, row in zip(moving, matrix, strict=True)}


def _round(value: float) -> float:
    """Return a number to ten digits: rounding is then far below what a record tells."""
    return float(f"{value:.10g}") + 0.0


def _documentation(report: BoatFit) -> dict[str, Any]:
    """Return the table [fit]: what was fitted to what, and how well."""
    return {
        "by": f"trainer boat fit, version {__version__}",
        "prior": report.prior,
        "settled": report.settled,
        "doubt": report.doubt,
        "steps": report.steps,
        "minus_log_likelihood": _round(report.cost),
        "conflict": _round(report.conflict),
        "disturbance": [_round(x) for x in report.disturbance],
        "errors": {name: _round(x) for name, x in report.errors.items()},
        "learned": {row.name: float(f"{row.learned:.4g}") for row in report.coefficients},
        "prior_mean": {row.name: _round(row.prior) for row in report.coefficients},
        "prior_sd": {row.name: _round(row.prior_sd) for row in report.coefficients},
        "records": [
            {
                "source": Path(one.source).name,
                "sha256": one.digest,
                "readings": sum(channel.readings for channel in one.channels),
                "slow": {slow.name: [_round(slow.value), _round(slow.sd)] for slow in one.slow},
                "seen": {name: [_round(x) for x in ends] for name, ends in one.seen.items()},
            }
            for one in report.records
        ],
    }


def _text(tables: Mapping[str, Any], report: BoatFit) -> str:
    """Return tables as a vessel file, coefficients with what the records told of each."""
    head = {"name": report.vessel, "count": len(report.records), "prior": report.prior}
    lines = FILE_HEAD.format(version=__version__, **head).splitlines()
    plain = {key: one for key, one in tables.items() if not isinstance(one, Mapping)}
    lines += [f"{key} = {toml_value(one)}" for key, one in plain.items()]
    for key, table in tables.items():
        if key == "coefficients":
            lines += _coefficient_lines(report)
        elif key == "covariance":  # products of small numbers, which are not to count as zero
            rows = (
                (name, ", ".join(format(x, ".10g") for x in row)) for name, row in table.items()
            )
            lines += ["", "[covariance]", *(f"{name} = [{row}]" for name, row in rows)]
        elif key not in plain:
            lines += table_lines(key, table)
    return "\n".join(lines) + "\n"


def _coefficient_lines(report: BoatFit) -> Iterator[str]:
    """Yield the coefficients by axis, each with its deviations and whether it was told."""
    rows = {row.name: row for row in report.coefficients}
    for axis in FORCE_AXES:
        yield from ("", f"[coefficients.{axis}]")
        for term in COEFFICIENTS:
            if term.equation == axis:
                row = rows[term.key]
                note = f"sd {row.sd:.2g}, before {row.prior:.4g} sd {row.prior_sd:.2g}"
                yield f"{term.key} = {toml_value(_round(row.value))}   # {note}; {row.verdict}"
