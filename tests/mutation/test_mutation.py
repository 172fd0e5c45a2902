"""Faults of one place are found in a module, drawn by a seed, and tried in a copy alone."""

import ast
import json
from collections.abc import Iterable, Iterator
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Final

import pytest
from click.testing import CliRunner
from helpers.places import ROOT

from mutation.__main__ import DAYS, mutation, report
from mutation.places import FaultKind, Place, files_of, places_in, with_fault_at
from mutation.table import in_words
from mutation.trials import (
    Copy,
    Drawn,
    NotGreenError,
    Trial,
    attempt,
    copied_tree,
    draw,
    is_told,
    near_tests,
    read_told,
)

MODULE: Final = '''"""A module."""

LIMIT = 3


class Valve:
    name: str = "é" if LIMIT > 2 else ""

    def turn(self, angle: float = 1.0) -> int:
        """Turn it by 90 deg."""
        assert angle > 0.0
        if angle is None or self.shut == 2:
            self.stop("é", angle)
        return 1 if angle < 2.5 else f"{angle + 1}"
'''


def test_the_places_of_a_module_are_in_its_functions(tmp_path: Path) -> None:
    path = tmp_path / "valve.py"
    path.write_text(MODULE, encoding="utf-8")

    found = [(p.kind, p.before, p.after) for p in places_in(tmp_path, path)]

    assert found == [
        (
            FaultKind.BRANCH,
            "angle is None or self.shut == 2",
            "(not (angle is None or self.shut == 2))",
        ),
        (FaultKind.COMPARISON, "angle is None", "(angle is not None)"),
        (FaultKind.COMPARISON, "self.shut == 2", "(self.shut != 2)"),
        (FaultKind.NUMBER, "2", "3"),
        (FaultKind.CALL, 'self.stop("é", angle)', "pass"),
        (FaultKind.BRANCH, "angle < 2.5", "(not (angle < 2.5))"),
        (FaultKind.COMPARISON, "angle < 2.5", "(angle <= 2.5)"),
        (FaultKind.NUMBER, "2.5", "3.5"),
        (FaultKind.NUMBER, "1", "2"),
    ]


def test_a_module_with_any_of_its_faults_is_read_and_is_another() -> None:
    (path,) = (p for p in files_of(ROOT, "session") if p.name == "agenda.py")
    source = path.read_bytes()
    whole = ast.dump(ast.parse(source))

    places = places_in(ROOT, path)

    assert {place.kind for place in places} == set(FaultKind)
    assert [p for p in places if ast.dump(ast.parse(with_fault_at(source, p))) == whole] == []


class EvenLines(Copy):
    """A copy in which sessions execute every second line of what they are asked of."""

    def lines(self, _seeds: int, _seconds: float, files: Iterable[str]) -> dict[str, set[int]]:
        return {file: set(range(0, 5000, 2)) for file in files}


def test_a_seed_draws_the_same_places_again_and_only_where_sessions_come() -> None:
    copy = EvenLines(ROOT)

    drawn = draw(copy, 5, "7", 1, 1.0)

    assert drawn == draw(copy, 5, "7", 1, 1.0)
    assert drawn.chosen != draw(copy, 5, "8", 1, 1.0).chosen
    assert len(drawn.chosen) == 5
    assert not any(each.line % 2 for each in drawn.chosen)
    assert 5 <= drawn.executed < drawn.places == 40


def test_the_tests_near_a_module_are_those_that_import_it() -> None:
    place = places_in(ROOT, ROOT / "trainer/io/mcap.py")[0]

    assert near_tests(ROOT, place) == ["tests/io/test_mcap.py"]


def test_a_fault_that_is_told_is_still_in_its_module() -> None:
    for told in read_told():
        places = places_in(ROOT, ROOT / told.file)
        assert any(is_told(told, place) for place in places), told
        assert told.why


def trial(**given: str) -> Trial:
    """Return a trial of a dropped call in a room."""
    found = {"sessions": "", "tests": "", "equivalent": ""} | given
    return Trial("trainer/io/line.py", 7, "Line.end", "call dropped", "self.end()", "pass", **found)


def test_the_table_counts_each_fault_once_and_names_what_nothing_finds() -> None:
    trials = [
        trial(sessions="seed 1: L8"),
        trial(tests="tests/io/test_server.py::test_it"),
        trial(equivalent="it has ended"),
        trial(),
    ]

    table = list(in_words(Drawn([], 60, 100), trials))

    assert "40 % are not" in table[0]
    rows = {line.rsplit(None, 5)[0].strip(): line.split()[-5:] for line in table[2:-1]}
    assert rows["all"] == rows["io"] == rows["call dropped"] == ["4", "1", "1", "1", "1"]
    assert rows["boat"] == ["0", "0", "0", "0", "0"]
    assert table[-1] == "NOTHING FINDS trainer/io/line.py:7 Line.end: `self.end()` -> `pass`"


def test_it_is_red_where_nothing_finds_more_than_half(capsys: pytest.CaptureFixture[str]) -> None:
    found, unfound, drawn = trial(sessions="seed 1: L8"), trial(), Drawn([], 60, 100)

    codes = []
    for trials in ([found, unfound], [found, unfound, unfound]):
        with pytest.raises(SystemExit) as left:
            report(drawn, trials, json=True)
        codes.append(left.value.code)
        told = json.loads(capsys.readouterr().out)

    assert codes == [0, 1]
    assert [fault["sessions"] for fault in told["faults"]] == ["seed 1: L8", "", ""]


def test_on_another_day_nothing_is_tried() -> None:
    later = DAYS[(datetime.now(UTC) + timedelta(days=2)).weekday()]

    answer = CliRunner().invoke(mutation, ["--on", later])

    assert answer.exit_code == 0
    assert answer.output == f"not today: on {later.capitalize()}\n"


@pytest.fixture(scope="module")
def copy() -> Iterator[Copy]:
    with copied_tree() as tree:
        yield tree


def place_of(file: str, before: str, kind: FaultKind) -> Place:
    """Return the first fault of a kind at some words of a module."""
    places = places_in(ROOT, ROOT / file)
    return next(each for each in places if each.before == before and each.kind is kind)


@pytest.mark.process
def test_a_fault_is_seen_by_sessions_of_a_copy_and_is_gone_afterwards(copy: Copy) -> None:
    file = "trainer/session/session.py"
    place = place_of(file, "self._after_tick(tick)", FaultKind.CALL)
    source = (ROOT / file).read_bytes()

    tried = attempt(copy, place, 1, 1.0)

    assert tried.sessions.startswith("seed 1: L")
    assert tried.tests == ""
    assert not tried.unfound
    assert (ROOT / file).read_bytes() == (copy.root / file).read_bytes() == source
    assert copy.hunt(1, 1.0) == ""


@pytest.mark.process
def test_a_fault_that_no_session_sees_is_looked_for_by_tests_of_its_room(
    copy: Copy, monkeypatch: pytest.MonkeyPatch
) -> None:
    place = places_in(ROOT, ROOT / "trainer/io/lines.py")[0]
    monkeypatch.setattr(Copy, "hunt", lambda *_: "")
    monkeypatch.setattr(Copy, "test", lambda _, room, **__: f"{room}/test_paths.py")

    tried = attempt(copy, place, 1, 3.0)

    assert tried.tests == "tests/io/test_paths.py"
    with pytest.raises(NotGreenError):
        copy.check_green("tests/io/test_paths.py::test_that_there_is_none")


@pytest.mark.process
def test_lines_that_sessions_execute_are_of_the_modules_that_are_asked_for(copy: Copy) -> None:
    asked = ("trainer/session/dispatch.py", "trainer/session/session.py")

    lines = copy.lines(1, 1.0, asked)

    assert len(lines[asked[0]]) > 50
    assert lines.keys() == set(asked)
