"""BB2 fitted to four made trials, from an estimate that has not seen it."""

from dataclasses import replace
from functools import cache
from pathlib import Path

from helpers.bb2_trials import estimated_bb2, four_trials
from trainer.config.boat.vessel import load_vessel
from trainer.identify.boat import search
from trainer.identify.boat.fitted_file import fitted_text
from trainer.identify.boat.prior import read_prior
from trainer.identify.boat.report import report_fit
from trainer.identify.boat.trial import without_unflown
from trainer.identify.boat.vessel import FittedVessel


@cache
def true_bb2(folder: Path) -> FittedVessel:
    """Return the shipped boat, with the time step of its estimate."""
    step = load_vessel(str(estimated_bb2(folder))).run.step_s
    file = load_vessel("bb2")
    return FittedVessel(replace(file, run=replace(file.run, step_s=step)))


@cache
def fitted_bb2(folder: Path, seed: int) -> Path:
    """Return the file of BB2 fitted to four trials."""
    truth, path = true_bb2(folder), folder / f"fitted-{seed}.toml"
    trials = map(without_unflown, four_trials(truth.numbers(truth.values), seed))
    found = search.fit_trials(read_prior(str(folder / "own.toml")), [*trials])
    path.write_text(fitted_text(found, report_fit(found, [], draws=0), path)[0], encoding="utf-8")
    return path
