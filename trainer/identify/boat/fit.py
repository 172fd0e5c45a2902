"""A fit from its files to its report, for command and Python face."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from trainer.config.files import ConfigError
from trainer.identify.boat.figures import BAND_DRAWS
from trainer.identify.boat.fitted_file import fitted_text
from trainer.identify.boat.prior import Prior, read_prior
from trainer.identify.boat.report import BoatFit, report_fit, turned_controls
from trainer.identify.boat.search import MOST_STEPS, STOPPED_TEXT, SearchEnd, find_flaws, fit_trials
from trainer.identify.boat.sheet import html_page
from trainer.identify.boat.trial import USUAL_INSTRUMENTS, Instruments, Trial, read_trial
from trainer.identify.fitting.minimise import Progress, SearchOptions, ignore_news


@dataclass(frozen=True, eq=False)
class Trials:
    """A prior with its records, all read and found fit for use."""

    prior: Prior
    fitted: tuple[Trial, ...]
    held_out: tuple[Trial, ...]


@dataclass(frozen=True, eq=False)
class BoatFound:
    """A fitted boat: the report, and the text of its vessel file."""

    report: BoatFit
    text: str
    html: str  # its page
    lacks: str  # why it has no gains; "" where it has them

    @property
    def is_whole(self) -> bool:
        """Return whether the search settled, or its user ended it."""
        return self.report.settled or self.report.doubt == STOPPED_TEXT


def open_trials(
    prior: str,
    records: Sequence[Path],
    held_out: Sequence[Path],
    instruments: Instruments = USUAL_INSTRUMENTS,
) -> Trials:
    """Return what a fit needs; ConfigError with what is wrong with a file."""
    known = read_prior(prior)
    fitted, aside = (
        tuple(read_trial(path, known.vessel, instruments) for path in paths)
        for paths in (records, held_out)
    )
    return Trials(known, fitted, aside)


def search_boat(trials: Trials, progress: Progress = ignore_news) -> SearchEnd:
    """Return the likeliest boat, and whether its surfaces are logged late.

    ConfigError where the prior's boat does not fly a record. A KeyboardInterrupt ends the search.
    """
    found = fit_trials(trials.prior, trials.fitted, SearchOptions(MOST_STEPS, progress))
    if found.found.doubt == STOPPED_TEXT:
        return found
    try:
        return find_flaws(found, progress)
    except KeyboardInterrupt:
        return found


def check_controls(found: SearchEnd) -> None:
    """Check signs that only a fit tells; ConfigError with those that no boat has."""
    if turned := found.turned or turned_controls(found):
        raise ConfigError(f"{turned}; nothing is written; --anyway writes it")


def judge_boat(
    trials: Trials,
    found: SearchEnd,
    path: Path,
    draws: int = BAND_DRAWS,
    heard: Callable[[int], object] = lambda _: None,
) -> BoatFound:
    """Return report and file of a boat; ``heard`` is told of each boat sailed."""
    report = report_fit(found, trials.held_out, draws, heard)
    text, lacks = fitted_text(found, report, path)
    return BoatFound(report, text, html_page(found, trials.held_out, report), lacks)
