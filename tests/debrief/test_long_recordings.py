"""A recording that is made to hold readers up: it is read as far as a limit, which is told."""

import contextlib
import csv
import json
import shutil
import sqlite3
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from helpers.altered import alter
from helpers.recorded import record

from trainer.cli.main import main
from trainer.debrief.page import charts, sections
from trainer.debrief.page.data import gather_debrief
from trainer.debrief.passage.recording_export import read_recording
from trainer.debrief.trainees import history
from trainer.io.recording import queries
from trainer.io.recording.recording import Recording
from trainer.session.replay import replay_anyway

pytestmark = [
    pytest.mark.filterwarnings("ignore::RuntimeWarning"),
    pytest.mark.usefixtures("few_points"),
]
COUNTING = "WITH RECURSIVE n(v) AS (SELECT 1 UNION ALL SELECT v + 1 FROM n WHERE v < {}) "
Run = Callable[..., tuple[int, str, str]]
CHAINED = (
    "INSERT INTO branches SELECT v + 1, v, 0, 1, 0, 'reset', "
    "(SELECT state FROM branches WHERE id = 1), '', 'jump' FROM n"
)
NOTED = "INSERT INTO events SELECT v, 1, 3, 'mark', 'helm', 'mark ' || v, '', 'helm' FROM n"
HELD_UP_S = 250.0  # ten times what such a file held a list up for


@pytest.fixture(scope="module")
def good(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a recording of an exercise, and nothing beside it."""
    folder = tmp_path_factory.mktemp("recorded")
    return record(folder / "good.trainer", "steady-course", {20.0: "rudder left 5"})


@pytest.fixture
def folder(good: Path, tmp_path: Path) -> Path:
    """Return a folder with that recording in it."""
    shutil.copy(good, tmp_path / "good.trainer")
    return tmp_path


@pytest.fixture
def small(monkeypatch: pytest.MonkeyPatch) -> None:
    """Lower what is read of a file."""
    monkeypatch.setattr(queries, "MAX_BRANCHES_READ", 20)
    monkeypatch.setattr(queries, "MAX_EVENTS_READ", 30)


def lengthened(folder: Path, name: str, insert: str, count: int) -> Path:
    """Return a copy of the recording with so many rows more."""
    path = folder / f"{name}.trainer"
    shutil.copy(folder / "good.trainer", path)
    alter(path, COUNTING.format(count) + insert)
    return path


@pytest.fixture
def run(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Run:
    """Return what runs a command: its exit code, output and messages."""

    def run(*words: object) -> tuple[int, str, str]:
        monkeypatch.setattr(sys, "argv", ["trainer", *map(str, words)])
        code = 0
        try:
            main()
        except SystemExit as left:
            code = int(left.code or 0)
        ran = capsys.readouterr()
        return code, ran.out, ran.err

    return run


@pytest.mark.usefixtures("small")
@pytest.mark.parametrize(
    "command", [("export", "--csv", "out.csv"), ("debrief",), ("debrief", "--json"), ("replay",)]
)
def test_a_recording_of_too_many_branches_is_refused_in_one_line(
    folder: Path, run: Run, monkeypatch: pytest.MonkeyPatch, command: tuple[str, ...]
) -> None:
    monkeypatch.chdir(folder)
    path = lengthened(folder, "long", CHAINED, 40)
    code, told, wrong = run(command[0], path, *command[1:])
    assert (code, told) == (2, "")
    assert wrong == f"trainer: {path} is too long to be read: 41 branches, and 20 is the most\n"


@pytest.mark.slow
@pytest.mark.usefixtures("small")
def test_of_too_many_events_the_first_are_debriefed_and_the_rest_is_told(
    folder: Path, run: Run
) -> None:
    path = lengthened(folder, "long", NOTED, 100)
    told = f"trainer: {path}: of 100 events the first 30 are read\n"
    code, text, wrong = run("debrief", path, "--json")
    assert (code, wrong) == (0, told)
    figures = json.loads(text)
    assert [each["remark"] for each in figures["marks"]] == [f"mark {i}" for i in range(1, 31)]
    assert figures["left_out"] == [{"what": "events", "of": 100, "first": 30}]
    assert run("debrief", path)[2] == told
    page = path.with_suffix(".html").read_text(encoding="utf-8")
    assert "Of 100 events the first 30 are read." in page


@pytest.mark.usefixtures("small")
def test_of_too_many_events_the_first_are_exported_and_a_program_has_all(
    folder: Path, run: Run
) -> None:
    path = lengthened(folder, "long", NOTED, 100)
    code, _, wrong = run("export", path, "--csv", folder / "out.csv")
    assert (code, wrong) == (0, f"trainer: {path}: of 100 events the first 30 are read\n")
    with (folder / "out.events.csv").open(newline="", encoding="utf-8") as file:
        assert [row["text"] for row in csv.DictReader(file)] == [f"mark {i}" for i in range(1, 31)]
    assert len(read_recording(path).events) == 100


@pytest.mark.usefixtures("small")
def test_the_list_has_what_is_long_at_its_end_and_tells_what_it_left_out(
    folder: Path, run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(history, "MAX_QUICK_BYTES", (folder / "good.trainer").stat().st_size)
    branched = lengthened(folder, "branched", CHAINED, 400)
    noted = lengthened(folder, "noted", NOTED, 40_000)
    monkeypatch.setattr(queries, "MAX_ROWS_COUNTED", 1000)
    assert branched.stat().st_mtime > (folder / "good.trainer").stat().st_mtime  # by its day first

    code, text, _ = run("recordings", folder, "--json")
    rows = {Path(row["file"]).name: row for row in json.loads(text)}
    assert code == 0
    assert next(iter(rows)) == "good.trainer"
    assert rows["good.trainer"]["left_out"] == []
    assert rows["noted.trainer"]["left_out"] == [{"what": "events", "of": 1000, "first": 30}]
    assert rows["branched.trainer"]["left_out"] == [{"what": "branches", "of": 401, "first": 20}]
    assert "401 branches, and 20 is the most" in rows["branched.trainer"]["trouble"]
    assert "of 1000 or more events the first 30 are read" in run("recordings", noted)[1]


@pytest.mark.usefixtures("small")
def test_a_name_is_forgotten_in_a_recording_that_is_too_long_to_be_read(
    folder: Path, run: Run
) -> None:
    path = lengthened(folder, "long", CHAINED, 40)
    alter(path, "INSERT INTO header VALUES ('trainees', '[\"Ann\"]')")
    code, text, _ = run("recordings", path, "--forget", "Ann")
    assert (code, text) == (0, f"{path}: the name is removed\n")
    left = [each for each in folder.iterdir() if b"Ann" in each.read_bytes()]
    assert left == []
    with contextlib.closing(sqlite3.connect(path)) as connection:
        assert connection.execute("SELECT count(*) FROM branches").fetchone() == (41,)


def test_a_page_shows_so_many_marks_and_branches_and_tells_how_many_more(
    folder: Path, run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sections, "MAX_TABLE_ROWS", 10)
    monkeypatch.setattr(charts, "MAX_MARKS_DRAWN", 10)
    path = lengthened(folder, "long", NOTED, 25)
    assert run("debrief", path)[0] == 0
    page = path.with_suffix(".html").read_text(encoding="utf-8")
    assert "15 more are in the record: trainer debrief --json has all." in page
    assert "M10" in page
    assert "M11" not in page


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> Callable[[], int]:
    """Return how many questions a recording was asked since the last time."""
    count = 0
    rows = queries.Past._rows  # noqa: SLF001  what all of them go through

    def counting(self: queries.Past, question: str, *values: int) -> Iterator[queries.Row]:
        nonlocal count
        count += 1
        return rows(self, question, *values)

    def taken() -> int:
        nonlocal count
        taken, count = count, 0
        return taken

    monkeypatch.setattr(queries.Past, "_rows", counting)
    return taken


@pytest.mark.parametrize(
    "read",
    [
        lambda recording, _: replay_anyway(recording),
        lambda recording, path: gather_debrief(recording, path, None),
    ],
    ids=["replay", "debrief"],
)
def test_twice_as_many_branches_are_twice_the_work(
    folder: Path, asked: Callable[[], int], read: Callable[[Recording, Path], object]
) -> None:
    counts = []
    for count in (50, 100):
        path = lengthened(folder, f"chain{count}", CHAINED, count)
        with contextlib.closing(Recording.look(path)) as recording, np.errstate(all="ignore"):
            asked()
            read(recording, path)
        counts.append(asked())
    assert counts[1] < 2.2 * counts[0]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("insert", "count"),
    [(CHAINED, 20_000), (CHAINED, queries.MAX_BRANCHES_READ - 1), (NOTED, 1_000_000)],
    ids=["chained", "nearly too many", "events"],
)
def test_a_recording_made_to_hold_up_holds_up_none(
    folder: Path, run: Run, insert: str, count: int
) -> None:
    path = lengthened(folder, "long", insert, count)
    began = time.monotonic()
    assert run("recordings", folder)[1].splitlines()[0].find("good.trainer") > 0
    for command in (("export", path, "--csv", folder / "out.csv"), ("debrief", path)):
        assert run(*command)[0] in (0, 2)
    assert run("replay", path)[0] in (0, 2)
    assert time.monotonic() - began < HELD_UP_S
