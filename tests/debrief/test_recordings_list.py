"""Recordings as they are listed, trainees and their history, names forgotten, marks changed."""

import contextlib
import json
import re
import shutil
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import platformdirs
import pytest
from helpers.altered import alter
from helpers.recorded import record

from trainer.cli.main import main
from trainer.config.exercise.outcome import Outcome
from trainer.config.files import ConfigError
from trainer.debrief.marks.changes import (
    change_of,
    changes_path,
    read_changes,
    without_changes,
    write_changes,
)
from trainer.debrief.page.data import debrief_figures, find_branch
from trainer.debrief.page.page import (
    DebriefRequest,
    as_text,
    debrief_file,
    opinions_as_asked,
    read_compared,
    read_dossier,
    render,
)
from trainer.debrief.trainees import history as history_module
from trainer.debrief.trainees.forgetting import files_of, forget_trainee, print_forgotten
from trainer.debrief.trainees.history import (
    ListedRecording,
    RecordedResult,
    history_lines,
    latest_recording,
    list_lines,
    list_recording,
    marks_path,
    of_trainee,
    print_list,
    recordings_in,
    trainee_history,
)
from trainer.io.paths import recordings_folder
from trainer.io.recording.facts import OVER_WORDS
from trainer.io.recording.recording import Recording, erase_texts
from trainer.session.past.header import names_of, open_whole_recording, plan_of, trainees_of
from trainer.session.past.options import RunOptions
from trainer.session.run import run_boat

pytestmark = [
    pytest.mark.filterwarnings("ignore::RuntimeWarning"),
    pytest.mark.usefixtures("few_points"),
]
ANN, MARKUP = "Ann O Briain", "<b>Bób<b> & sons"


@pytest.fixture(scope="module")
def flown(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a recording of two trainees, of whom one is remarked upon."""
    remarks = {
        20.0: f"mark {ANN} was slow",
        25.0: f"tell {ANN} has the helm",
        30.0: f"mark {ANN}son was not",
    }
    names = (ANN, MARKUP)
    path = tmp_path_factory.mktemp("flown") / "steady.trainer"
    return record(path, "steady-course", remarks, "instructor at a desk", trainee=names)


@pytest.fixture
def kept(flown: Path, tmp_path: Path) -> Path:
    """Return a copy of it for a test."""
    return Path(shutil.copy(flown, tmp_path / flown.name))


def change_marks(path: Path, *texts: str, back: str = "", branch: int | None = None) -> None:
    """Change marks of a recording as is asked on the command line."""
    asked = DebriefRequest(branch, change=texts, change_back=(back,) if back else ())
    write_changes(path, opinions_as_asked(path, asked).changes)


# Names


def test_names_are_kept_in_the_header_and_shown_as_text(kept: Path) -> None:
    debrief = read_dossier(kept, None)
    assert debrief.trainees == (ANN, MARKUP)
    assert debrief_figures(debrief)["trainees"] == [ANN, MARKUP]
    told = render(debrief)
    assert "<b>Bób" not in told
    assert "&lt;b&gt;Bób&lt;b&gt; &amp; sons" in told


@pytest.mark.parametrize("name", ["", "  ", "a\x1b[31mb", "x" * 61])
def test_what_is_no_name_is_refused(name: str) -> None:
    with pytest.raises(ConfigError, match=r"--trainee .*: a name has 1 to 60 printable characters"):
        names_of([name])


def test_a_name_is_kept_once_and_with_single_blanks() -> None:
    assert names_of(["A.  Jones", "A. Jones", "7"]) == ["A. Jones", "7"]


def test_a_run_that_is_not_recorded_keeps_no_names() -> None:
    options = RunOptions(headless=True, duration=1.0, trainee=("Ann",))
    with pytest.raises(ConfigError, match="--trainee: this run is not recorded"):
        run_boat(options)


def test_a_header_with_damaged_names_has_none() -> None:
    assert trainees_of({"trainees": '["a", 3]'}) == ()
    assert trainees_of({"trainees": "["}) == ()
    assert trainees_of({}) == ()


# The list


def test_a_recording_is_judged_once_for_the_list(
    kept: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    first = list_recording(kept)
    assert first.came
    assert (first.came.exercise, first.came.outcome) == ("Steering, first steps", "not reached")

    def never(*_: object) -> None:
        raise AssertionError("judged again")

    monkeypatch.setattr(history_module, "gather_debrief", never)
    assert list_recording(kept) == first
    (line,) = list_lines([first])
    assert line.startswith(first.started[:10])
    assert f"not reached     0   {ANN}, {MARKUP}  steady.trainer" in line


def test_a_changed_mark_and_another_state_are_judged_anew(kept: Path) -> None:
    before = list_recording(kept)
    change_marks(kept, "outcome: won, the repeater was off")
    after = list_recording(kept)
    assert before.came
    assert after.came
    assert (before.came.outcome, after.came.outcome) == ("not reached", "won")
    assert after.came.changed
    assert "*" in next(list_lines([after]))
    marks_path(kept).write_text('{"of": 3}')
    assert list_recording(kept) == after


def test_the_list_goes_on_past_what_cannot_be_read(
    kept: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (kept.parent / "bad.trainer").write_text("no recording")
    print_list([kept.parent], as_json=False)
    told = capsys.readouterr().out
    assert "bad.trainer: cannot be read" in told
    assert "steady.trainer" in told
    print_list([kept.parent], as_json=True)
    figures_of = json.loads(capsys.readouterr().out)
    assert {each["file"] for each in figures_of} == {
        str(kept),
        str(kept.parent / "bad.trainer"),
    }


LONG = RecordedResult(
    "Periscope depth in a seaway, at night",
    3,
    "basic",
    Outcome.NOT_REACHED,
    0.0,
    counts=False,
    changed=True,
)
LONG_FILE = Path("periscope-depth-20261121-222343.trainer")
LONG_ROWS = (
    ListedRecording(
        LONG_FILE, "2026-11-21T22:23:43", ("Ann O Briain", "Ann O Briain the younger"), LONG
    ),
    ListedRecording(LONG_FILE, "2026-11-21T22:23:43", ("Bob",), replace(LONG, counts=True)),
    ListedRecording(
        LONG_FILE, "2026-11-21T22:23:43", (), None, "it is damaged: " + "a page is cut " * 9
    ),
    ListedRecording(
        Path("a.trainer"), "2026-11-21T22:23:43", ("A\x1b",), replace(LONG, exercise="Mine")
    ),
)


def test_whatever_one_recording_does_the_others_are_listed_and_forgotten(
    kept: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    odd = tmp_path / "odd.trainer"
    shutil.copy(kept, odd)
    marks_of, texts_of = history_module.kept_result, erase_texts

    def unforeseen(path: Path) -> RecordedResult | None:
        if path == odd:
            raise RecursionError("x" * 5000)
        return marks_of(path)

    def unforeseen_texts(path: Path, *how: Any) -> None:
        if path == odd:
            unforeseen(path)
        texts_of(path, *how)

    monkeypatch.setattr(history_module, "kept_result", unforeseen)
    monkeypatch.setattr("trainer.debrief.trainees.forgetting.erase_texts", unforeseen_texts)

    found = {each.path: each.trouble for each in map(list_recording, (odd, kept))}
    assert found[kept] == ""
    assert found[odd].startswith(f"{odd}: cannot be read: RecursionError: ")
    assert len(found[odd]) < len(str(odd)) + 120

    left: list[str] = []
    assert list(forget_trainee(ANN, (odd, kept), left)) == [f"{kept}: the name is removed"]
    assert left[0].startswith(f"{odd}: the name is still in it: {odd}: cannot be read: Recursion")
    with contextlib.closing(Recording.look(kept)) as recording:
        assert ANN not in trainees_of(recording.header())


@pytest.mark.parametrize("columns", [60, 79, 80, 100])
def test_a_list_fits_the_terminal_and_shortens_only_what_is_too_long(columns: int) -> None:
    lines = list(list_lines(LONG_ROWS, columns))

    assert max(map(len, lines)) <= columns
    assert lines[0].count("…") >= 2
    assert "not reached     0*" in lines[0]
    assert "  Bob  p" in lines[1]
    assert " ".join(" ".join(lines).split()).count("a page is cut") == 9
    assert "Mine " in lines[-1]


@pytest.mark.parametrize(("kind", "branch"), [("time", 1), ("mark", 2)])
def test_the_branch_that_reached_the_end_is_judged_not_one_begun_after_it(
    kept: Path, kind: str, branch: int
) -> None:
    recording = Recording.reopen(kept)
    recording.event(recording.latest().tick, kind, "", f"{OVER_WORDS}time is up at 600 s")
    start = recording.moment(1, 0)
    assert start is not None
    recording.fork(start, "again")
    recording.close()
    told, line = (
        as_text(read_compared(kept, DebriefRequest())),
        next(list_lines([list_recording(kept)])),
    )
    command = f"trainer debrief {kept.name} --branch {'2' if branch == 1 else 'N'}"
    assert f"This is branch {branch} of 2; {command} shows" in " ".join(told.split())
    assert line.endswith(" (branch 1 of 2)") is (branch == 1)
    assert find_branch(Recording.look(kept), kept, None).id == branch


def test_a_list_for_a_program_shortens_nothing() -> None:
    assert "…" not in "".join(list_lines(LONG_ROWS))


def test_a_terminal_gets_a_list_of_its_own_width(
    kept: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    named = kept.rename(kept.with_name(f"{'long-name-' * 6}.trainer"))
    monkeypatch.setattr(sys.stdout, "isatty", lambda: True)
    monkeypatch.setenv("COLUMNS", "79")
    print_list([named.parent], as_json=False)
    (line,) = capsys.readouterr().out.splitlines()
    assert len(line) <= 79
    assert "long-" in line
    assert line.endswith("…")


def test_a_list_sends_no_control_characters(kept: Path, capsys: pytest.CaptureFixture[str]) -> None:
    names = json.dumps(["\x07\x1b[31mred"])
    alter(kept, "UPDATE header SET value = ? WHERE key = 'trainees'", names)
    print_list([kept.parent], as_json=False)
    told = capsys.readouterr().out
    assert "\x07" not in told
    assert "\\x1b[31mred" in told


def test_without_recordings_the_next_step_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    print_list([], as_json=False)
    assert "trainer run EXERCISE makes one" in capsys.readouterr().out
    with pytest.raises(ConfigError, match=r"--last: no recording is in .*: trainer run EXERCISE"):
        latest_recording()
    with pytest.raises(ConfigError, match="nowhere"):
        list(recordings_in([tmp_path / "nowhere"]))


def test_the_last_recording_is_that_written_last(
    kept: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    folder = recordings_folder()
    folder.mkdir(parents=True)
    for name in ("b", "a"):
        (folder / f"{name}.trainer").write_bytes(kept.read_bytes())
    assert latest_recording().name == "a.trainer"


def test_recordings_are_where_the_system_keeps_them_and_stay_where_they_were(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    ours, mac = "submarine-trainer", tmp_path / "Library"
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "named"))
    assert recordings_folder() == tmp_path / "named" / ours / "recordings"
    monkeypatch.delenv("XDG_STATE_HOME")
    usual = tmp_path / ".local" / "state" / ours / "recordings"
    if sys.platform == "linux":
        assert recordings_folder() == usual

    monkeypatch.setattr(platformdirs, "user_state_path", lambda name, **_: mac / name)
    assert recordings_folder() == mac / ours / "recordings"
    usual.mkdir(parents=True)
    assert recordings_folder() == usual


# History


def run_of(
    total: float | None, seed: int = 1, width: str = "qualified", **of: object
) -> ListedRecording:
    came = RecordedResult("Depth", seed, width, Outcome.WON, total, counts=True, changed=False)
    return ListedRecording(Path("x.trainer"), "", (ANN,), replace(came, **of))  # type: ignore[arg-type]


def test_the_history_has_a_line_for_each_exercise_and_width_and_the_mean_of_the_last_three() -> (
    None
):
    newest_first = [
        run_of(90.0, seed=3),
        run_of(99.0, counts=False),
        run_of(60.0, width="basic"),
        run_of(80.0, seed=2),
        run_of(40.0),
        run_of(0.0),
    ]
    basic, qualified = trainee_history(newest_first)
    assert (qualified.attempts, qualified.seeds, qualified.mean) == (5, (1, 2, 3), 70.0)
    assert (basic.width, basic.attempts, basic.mean) == ("basic", 1, 60.0)
    assert len(list(history_lines([basic, qualified]))) == 3


def test_a_trainee_is_found_however_the_name_is_written_and_else_the_nearest() -> None:
    found = [run_of(90.0)]
    assert of_trainee(found, "  ann  o BRIAIN ") == found
    with pytest.raises(ConfigError, match=f"nearest is {ANN}"):
        of_trainee(found, "Ann O Brian")


# Forgotten


@pytest.mark.long
def test_a_forgotten_name_is_nowhere_any_more(kept: Path) -> None:
    change_marks(kept, f"outcome: won, {ANN} steered well")
    debrief_file(kept, None, None, DebriefRequest())
    list_recording(kept)
    before = read_dossier(kept, None).trajectory
    left: list[str] = []
    told = list(forget_trainee(ANN.upper(), files_of([kept], left), left))

    assert [Path(line.split(":")[0]).name for line in told] == [
        *("steady.trainer", "steady.changes.toml", "steady.html"),
    ]
    assert not left
    for path in kept.parent.iterdir():
        assert ANN.encode() not in path.read_bytes().replace(ANN.encode() + b"son", b""), path
    debrief = read_dossier(kept, None)
    assert debrief.trainees == (MARKUP,)
    assert [each.text for each in debrief.of_kind("mark")] == [
        "(name removed) was slow",
        f"{ANN}son was not",
    ]
    assert (debrief.trajectory.columns["z"] == before.columns["z"]).all()
    assert read_changes(kept)[0].reason == "(name removed) steered well"


def test_a_name_that_is_nowhere_or_in_use_is_told(
    kept: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(ConfigError, match=r"no recording has that name; nearest is Ann"):
        print_forgotten([kept], "Ann Briain")
    recording = Recording.reopen(kept)
    assert print_forgotten([kept], ANN) == 1
    assert re.search(r"the name is still in it: .*is in use", capsys.readouterr().err)
    recording.close()
    assert print_forgotten([kept], ANN) == 0


# Marks changed by the instructor


@pytest.mark.slow
def test_a_struck_measure_and_a_weight_change_the_total_and_both_are_shown(tmp_path: Path) -> None:
    path = record(tmp_path / "turn.trainer", "steady-course", {62.0: "rudder right 3"})
    plain = read_compared(path, DebriefRequest())
    names = [each.name for each in plain.card.scores]
    texts = [f"{names[0]}: strike, a squall", f"{names[1].upper()}:  weight  2 , it matters, here"]
    change_marks(path, *texts)
    debrief = read_compared(path, DebriefRequest())

    assert [str(each) for each in debrief.changes] == [
        f"{names[0]}: strike (a squall)",
        f"{names[1]}: weight 2 (it matters, here)",
    ]
    assert debrief.changed
    kept_names = [each.name for each in debrief.changed.scores]
    assert kept_names == names[1:]
    assert debrief.changed.scores[0].rule.weight == 2.0
    assert debrief.card == plain.card
    told = render(debrief)
    assert "Changed by the instructor; before: not reached" in told
    assert f"<td>{names[0]}</td><td>weight 1</td><td>strike</td><td>a squall</td>" in told


def test_an_outcome_and_a_width_can_be_changed_and_taken_back(kept: Path) -> None:
    change_marks(kept, "outcome: won, seen by me", "width: basic, a beginner")
    debrief = read_dossier(kept, None)
    assert debrief.final.verdict
    assert debrief.final.verdict.outcome == "won"
    assert debrief.final.scores[0].rule.score.zero != debrief.card.scores[0].rule.score.zero
    change_marks(kept, back="Outcome")
    assert [each.name for each in read_changes(kept)] == ["width"]
    change_marks(kept, back="all")
    assert not changes_path(kept).exists()


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("outcom: won, x", "nothing of that name; nearest is outcome; there are: "),
        ("outcome: wonn, x", 'no outcome "wonn"; nearest is won; say won, lost, not reached'),
        ("width: wide, x", 'no width "wide"; say qualified, basic'),
        ("outcome: won", "a reason is needed"),
        ("nothing", 'say it as "NAME: WHAT, REASON"'),
        ("Quiet rudder: weight much, x", 'say "weight" and a number of 0 to 1000, or "strike"'),
        ("Quiet rudder: weight -1, x", "a number of 0 to 1000"),
        ("Quiet rudder: wait 1, x", "say weight, or strike"),
        ("outcome: won, a\x1bb", "must be one line of text"),
    ],
)
def test_a_change_that_is_none_is_told_with_what_it_should_be(
    kept: Path, text: str, told: str
) -> None:
    with pytest.raises(ConfigError) as wrong:
        change_marks(kept, "outcome: lost, first", text)
    assert told in str(wrong.value)
    assert not changes_path(kept).exists()


def test_nothing_changed_cannot_be_taken_back(kept: Path) -> None:
    with open_whole_recording(kept) as recording:
        plan = plan_of(recording.header())
    change = change_of("outcome: won, well done", 1, plan)
    with pytest.raises(ConfigError, match="nearest is outcome"):
        without_changes([change], "outcomes", 1)
    with pytest.raises(ConfigError, match="nothing has been changed in this run"):
        without_changes([change], "outcome", 2)


def test_a_branch_that_is_none_is_not_changed(kept: Path) -> None:
    with pytest.raises(ConfigError, match="--branch 7: there are branches 1 only"):
        change_marks(kept, "outcome: won, well done", branch=7)
    assert not changes_path(kept).exists()


@pytest.mark.parametrize(
    ("name", "what"), [("outcome", "wonn"), ("width", "wide"), ("Quiet rudder", "weight x")]
)
def test_a_change_written_by_hand_is_checked(kept: Path, name: str, what: str) -> None:
    change_marks(kept, "outcome: won, well done")
    path = changes_path(kept)
    text = path.read_text().replace('"outcome"', f'"{name}"').replace('"won"', f'"{what}"')
    path.write_text(text)
    with pytest.raises(ConfigError, match=rf"steady\.changes\.toml: {name}: {what}: "):
        read_compared(kept, DebriefRequest())


@pytest.mark.parametrize(
    ("was", "text"), [('"total": 0.0', '"total": "all"'), ('"not reached"', '"nearly won"')]
)
def test_kept_marks_of_another_kind_are_made_anew(kept: Path, was: str, text: str) -> None:
    first = list_recording(kept)
    path = marks_path(kept)
    assert was in path.read_text()
    path.write_text(path.read_text().replace(was, text))
    assert list_recording(kept) == first


def test_a_damaged_file_of_changes_is_told(kept: Path) -> None:
    changes_path(kept).write_text('schema = "changes/1"\n[[changes]]\nbranch = 1\n')
    with pytest.raises(ConfigError, match=r"steady\.changes\.toml: .*lacks name"):
        read_compared(kept, DebriefRequest())


def test_the_commands_refuse_what_makes_no_sense(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))

    def ran(*words: str) -> tuple[object, str]:
        monkeypatch.setattr(sys, "argv", ["trainer", *words])
        with pytest.raises(SystemExit) as left:
            main()
        return left.value.code, capsys.readouterr().err

    folder = tmp_path / "submarine-trainer" / "recordings"
    todo = "trainer run EXERCISE makes one, or name a FILE"
    told = f"trainer: --last: no recording is in {folder}: {todo}\n"
    for command in ("debrief", "resume"):
        assert ran(command, "--last") == (2, told)
        assert "name a recording, or say --last" in ran(command)[1]
    assert "say one" in ran("recordings", "--trainee", "a", "--forget", "b")[1]
