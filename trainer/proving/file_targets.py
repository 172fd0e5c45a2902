"""What comes as files: vessels, seas, exercises, studies, tables, JSON lines."""

import functools
import re
from collections.abc import Callable, Mapping
from contextlib import suppress
from pathlib import Path
from types import SimpleNamespace
from typing import Any, Final

import numpy as np

from trainer.config import ConfigError, Place, read_text
from trainer.core.kernel import Record
from trainer.files.casualty_file import parse_casualties
from trainer.files.condition import compile_condition
from trainer.files.exercise_file import parse_exercise
from trainer.files.sea_file import parse_sea
from trainer.files.vessel_file import load_vessel, parse_vessel
from trainer.fitout import Method, Records, fit_out
from trainer.guide.baseline import load_earlier
from trainer.guide.trials import load_trials
from trainer.identify.checkpoint import resume
from trainer.identify.decca_file import load_decca, load_readings
from trainer.identify.nomoto_file import load_nomoto
from trainer.identify.sources import Column, load_record
from trainer.identify.study_file import load_study
from trainer.proving.examples import (
    BOAT,
    CHECKPOINT,
    CONDITIONS,
    DECCA,
    GUIDE,
    NOMOTO,
    READINGS,
    STATE,
    STUDY,
)
from trainer.proving.line_targets import GRAMMAR
from trainer.proving.target import (
    TABLE,
    Target,
    filed,
    only,
    pieces,
    shipped_seeds,
    shipped_texts,
    text_of,
)
from trainer.study.evaluate import answers
from trainer.study.series import load_series

Loader = Callable[[Path], Any]
FILE: Final = "proof.toml"
COLUMNS: Final = {
    "t": Column("t", 1.0),
    "rudder": Column("rudder", 1.0),
    "heading": Column("heading", 1.0),
}


BRIEFING: Final = re.compile(rb'^briefing = """.*?"""\n', re.DOTALL | re.MULTILINE)
SHORTER: Final = b'briefing = "Go."\n'


def text(parse: Callable[[str, Path], Any]) -> Callable[[bytes], None]:
    """Return the proof of a reader of a file's text, with nothing but shipped files beside it."""

    def take(data: bytes) -> None:
        with suppress(ConfigError), only(FILE, text_of(data)) as path:
            parse(read_text(path), path)

    return take


def loaded(load: Loader) -> Callable[[bytes], None]:
    """Return the proof of a reader of a TOML file."""
    return text(lambda _text, path: load(path))


def opened(load: Loader, name: str) -> Callable[[bytes], None]:
    """Return the proof of a reader that opens a file itself."""

    def take(data: bytes) -> None:
        with suppress(ConfigError):
            load(filed(name, data))

    return take


def exercise(text: str, path: Path) -> None:
    """Read an exercise, with the vessel that it names."""
    found = parse_exercise(text, path)
    if found.heading.vessel:
        _named_vessel(found.heading.vessel)


@functools.cache
def _named_vessel(name: str) -> Any:
    return load_vessel(name)


def vessel(text: str, path: Path) -> None:
    """Read a vessel and fit her out: what is accepted has to be computable."""
    records = fit_out(parse_vessel(text, path), Method("full", "lagged", "exact", "adams2", 0.5))
    for record in records:
        if np.isnan(record.view(np.float64)).any():
            raise AssertionError("something in her records is no number")


def condition(data: bytes) -> None:
    """Read a condition on the state."""
    with suppress(ConfigError):
        compile_condition(text_of(data), Place(FILE, ""))


def states(data: bytes) -> None:
    """Read states as `trainer evaluate` does, and compute what they lead to."""
    records, at_rest = _bb2()
    records.state[:] = at_rest
    with suppress(ConfigError):
        for answer in answers(records, text_of(data).splitlines()):
            if "nan" in answer or "inf" in answer:
                raise AssertionError(f"no number: {answer}")


@functools.cache
def _bb2() -> tuple[Records, Record]:
    """Return a boat's records, and her state at rest."""
    records = fit_out(load_vessel("bb2"), Method("modified", "lagged", "exact", "adams2", 0.5))
    return records, records.state.copy()


def lanes(path: Path) -> None:
    """Read the lanes of a Decca study."""
    load_readings(_decca(path))


@functools.cache
def _decca(readings: Path) -> Any:
    """Return a study of these readings."""
    study = filed("decca.toml", DECCA.replace(b"proof.csv", readings.name.encode()))
    return load_decca(study)


# What a checkpoint is asked about: a search for two parameters.
SEARCH: Final[Any] = SimpleNamespace(
    names=("K", "T"), scale=1.0, plant=SimpleNamespace(model=SimpleNamespace(name="nomoto"))
)


def vessels() -> list[bytes]:
    """Return a small boat by herself, and with each table of the shipped ones that she lacks."""
    found = [BOAT]
    for key, text in shipped_texts().items():
        if key.startswith("configs/vessels/"):
            tables = {TABLE.findall(piece)[0]: piece for piece in pieces(text)[1:]}
            found += [BOAT + _with_terms(name, tables) for name in tables if f"[{name}" not in BOAT]
    return [text.encode() for text in found]


def _with_terms(name: str, tables: Mapping[str, str]) -> str:
    """Return a table, one of compensation after the table of what a hull adds to the set."""
    return tables["compact"] * name.startswith("compensation.") + tables[name]


def cut(name: str) -> Callable[[], list[bytes]]:
    """Return a function that returns a shipped file in pieces, its heading before each."""

    def seeds() -> list[bytes]:
        heading, *tables = pieces(shipped_texts()[f"configs/{name}.toml"])
        return [(heading + table).encode() for table in tables]

    return seeds


def exercises() -> list[bytes]:
    """Return the shipped exercises, their briefings short: they are most of each."""
    return [BRIEFING.sub(SHORTER, seed) for seed in shipped_seeds("exercises")]


TARGETS: Final = (
    Target("vessel", "a vessel file, fitted out", text(vessel), vessels, 3000),
    Target("sea", "a sea file", text(parse_sea), lambda: shipped_seeds("seas"), spared=()),
    Target(
        "casualties",
        "a table of casualties",
        text(lambda text, path: parse_casualties(text, path, {})),
        cut("casualties/standard"),
        640,
    ),
    Target("exercise", "an exercise file", text(exercise), exercises, 1200, GRAMMAR),
    Target("trials", "published results of a boat", loaded(load_trials), cut("trials/bb2"), 1200),
    Target(
        "condition",
        "a condition on the state",
        condition,
        lambda: [c.encode() for c in CONDITIONS],
        64,
    ),
    Target("study", "a study of a ship from her record", loaded(load_study), lambda: [STUDY], 512),
    Target(
        "nomoto",
        "a ship of a few parameters",
        loaded(load_nomoto),
        lambda: [NOMOTO],
        spared=(),
    ),
    Target("decca", "a chain of Decca stations", loaded(load_decca), lambda: [DECCA], 512),
    Target("lanes", "readings of Decca lanes, CSV", opened(lanes, "lanes.csv"), lambda: [READINGS]),
    Target(
        "record",
        "a record of a ship, CSV",
        opened(lambda path: load_record(path, COLUMNS), "record.csv"),
        lambda: [READINGS],
    ),
    Target(
        "series", "a series to be fitted, CSV", opened(load_series, "t.csv"), lambda: [READINGS]
    ),
    Target("evaluate", "states to be evaluated, JSON lines", states, lambda: [STATE], 512),
    Target(
        "baseline",
        "an earlier guide, JSON or HTML",
        opened(lambda path: load_earlier(path, "bb2"), "guide.json"),
        lambda: [GUIDE],
        512,
    ),
    Target(
        "checkpoint",
        "a search that was left, JSON",
        opened(lambda path: resume(path, SEARCH), "search.json"),
        lambda: [CHECKPOINT],
    ),
)
