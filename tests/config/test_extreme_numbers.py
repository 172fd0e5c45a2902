"""Every number of every shipped file, made one that no boat has: refused by name, or flown."""

import json
import math
import re
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from helpers.lanes import sample_cases

from trainer.analysis.sweep.study import load_study
from trainer.boat.assemble import Method
from trainer.boat.boat import Boat
from trainer.config.boat.casualties import load_casualties
from trainer.config.boat.vessel import VesselFile, load_vessel
from trainer.config.exercise.exercise import load_exercise, read_exercise
from trainer.config.files import ConfigError, shipped_names, shipped_path
from trainer.config.world.sea import load_sea
from trainer.units import KNOT

EXTREME = ("nan", "inf", "-inf", "1e308", "-1e308", "1e-308", "5e-324", f"{2**63}", "9" * 400)
NUMBER = re.compile(r"(?<![\w.\"'-])[-+]?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?(?![\w.\"'-])")
TEXT = re.compile(r'"[^"]*"')
KEY = re.compile(r"\s*[\w.-]+\s*=")
TICKS = 20


def changed(text: str, extremes: tuple[str, ...] = EXTREME) -> Iterator[tuple[str, str]]:
    """Yield a file's text with one number replaced, for every number, and what was done."""
    lines = text.split("\n")
    inside = False  # a list of several lines
    for place, line in enumerate(lines):
        code = TEXT.sub(lambda found: " " * len(found[0]), line.partition("#")[0])
        if not (KEY.match(code) or inside):
            continue
        inside = (inside or "[" in code) and "]" not in code
        for turn, found in enumerate(NUMBER.finditer(code)):
            extreme = extremes[(place + turn) % len(extremes)]
            told = f"line {place + 1}: {line.strip()} with {extreme}"
            with_it = line[: found.start()] + extreme + line[found.end() :]
            yield told, "\n".join([*lines[:place], with_it, *lines[place + 1 :]])


def load_whole_study(path: str) -> object:
    """Load a study and what its members fly, which is read before they do."""
    study = load_study(path)
    if "exercise" in study.tables:
        filled = json.loads(json.dumps(study.tables["exercise"]).replace("{}", "5"))
        read_exercise(filled, study.path)
    return study


def taken_from(load: Callable[[str], object], path: Path, told: str) -> object:
    """Return what is read from a file, or None where it is refused, which is by its name."""
    try:
        return load(str(path))
    except ConfigError as error:
        problems = error.problems
    assert all(problem.startswith(path.name) for problem in problems), told
    return None


def check(load: Callable[[str], object], path: Path, text: str) -> Iterator[tuple[str, object]]:
    """Yield what is read in spite of an extreme number, with what was done; check what is not."""
    refused = 0
    for told, with_it in changed(text):
        path.write_text(with_it, encoding="utf-8")
        taken = taken_from(load, path, told)
        if taken is None:
            refused += 1
        else:
            yield told, taken
    assert refused > 0


@pytest.mark.long
@pytest.mark.parametrize("name", sample_cases(shipped_names("vessels"), "remus100"))
def test_no_key_of_a_vessel_takes_a_number_that_is_none(name: str, tmp_path: Path) -> None:
    text = shipped_path("vessels", name).read_text(encoding="utf-8")
    path = tmp_path / "boat.toml"
    for told, with_it in changed(text, ("nan", "-inf", "1e999")):
        path.write_text(with_it, encoding="utf-8")
        assert taken_from(load_vessel, path, told) is None, told


@pytest.mark.long
@pytest.mark.parametrize("name", sample_cases(shipped_names("vessels"), "remus100"))
def test_a_vessel_with_a_number_that_no_boat_has_is_refused_or_flies(
    name: str, tmp_path: Path
) -> None:
    text = shipped_path("vessels", name).read_text(encoding="utf-8")
    for told, vessel in check(load_vessel, tmp_path / "boat.toml", text):
        assert isinstance(vessel, VesselFile)
        boat = Boat(vessel, Method("full", "lagged", "exact", "adams2", vessel.run.step_s))
        boat.start(vessel.run.start_speed_kn * KNOT, vessel.run.start_depth_m, 0.0)
        with np.errstate(all="ignore"):
            assert not any(boat.tick() for _ in range(TICKS)), told
        assert np.isfinite(boat.records.state["whole"]).all(), told
        assert not math.isnan(boat.time)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "name", "load"),
    [
        *(("exercises", name, load_exercise) for name in shipped_names("exercises")),
        *(("seas", name, load_sea) for name in shipped_names("seas")),
        *(("studies", name, load_whole_study) for name in shipped_names("studies")),
    ],
)
def test_a_file_with_a_number_that_none_is_like_is_refused_by_name(
    kind: str, name: str, load: Callable[[str], object], tmp_path: Path
) -> None:
    text = shipped_path(kind, name).read_text(encoding="utf-8")
    taken = [told for told, _ in check(load, tmp_path / "own.toml", text)]
    assert taken == []


def test_a_table_of_casualties_with_such_a_number_is_refused_by_name(tmp_path: Path) -> None:
    path = tmp_path / "own.toml"
    text = (shipped_path("casualties", "standard")).read_text(encoding="utf-8")
    taken = [told for told, _ in check(partial(load_casualties), path, text)]
    assert taken == []
