"""Outputs are whole or not at all, and cost no input; recordings started at once find names."""

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from itertools import islice
from pathlib import Path
from threading import Barrier

import pytest

from trainer.io.outputs import (
    SameFileError,
    note_input,
    open_new,
    open_output,
    promising,
    renew_whole,
    replacing,
    write_whole,
)
from trainer.io.paths import recording_paths
from trainer.session.run import create_recording


def fail_half_way(path: Path) -> None:
    with replacing(path) as made:
        made.write_text("ne")
        raise KeyboardInterrupt


def test_a_file_that_fails_half_way_leaves_the_old_one_and_no_debris(tmp_path: Path) -> None:
    path = tmp_path / "out.csv"
    path.write_text("old")
    with pytest.raises(KeyboardInterrupt):
        fail_half_way(path)
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_a_whole_file_replaces_the_old_one_and_keeps_its_rights(tmp_path: Path) -> None:
    path, link = tmp_path / "out.csv", tmp_path / "link.csv"
    path.write_text("old")
    path.chmod(0o640)
    link.symlink_to(path)
    with replacing(link) as made:
        made.write_text("new")
    assert path.read_text() == "new"
    assert link.is_symlink()
    assert path.stat().st_mode & 0o777 == 0o640


Write = Callable[[Path], object]
WAYS: list[Write] = [open_output, lambda path: write_whole(path, "new")]


@pytest.mark.parametrize("write", WAYS)
def test_no_way_to_write_costs_an_input(
    write: Write, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path, hard, soft = (tmp_path / name for name in ("in.csv", "hard.csv", "soft.csv"))
    path.write_text("measured")
    hard.hardlink_to(path)
    soft.symlink_to(path)
    monkeypatch.chdir(tmp_path)
    note_input(Path("in.csv"))
    for name in (path, hard, soft, Path("in.csv"), tmp_path / ".." / tmp_path.name / "in.csv"):
        with pytest.raises(SameFileError, match="is an input here; give another name"):
            write(name)
    assert path.read_text() == "measured"
    assert sorted(tmp_path.iterdir()) == sorted((path, hard, soft))


def test_what_this_program_made_it_may_read_and_make_again(tmp_path: Path) -> None:
    """A notebook's cell writes a ship, another sails it, and the first is run again."""
    path, streamed, new = (tmp_path / name for name in ("ship.toml", "out.csv", "new.nmea"))
    open_new(new).close()
    for text in ("first = 1", "second = 2"):
        write_whole(path, text)
        open_output(streamed).close()
        for each in (path, streamed, new):
            note_input(each)
    write_whole(new, "third")
    assert path.read_text() == "second = 2"


@pytest.mark.parametrize("there", ['schema = "ship/1"\n', 'schema = "gert', "# notes\n"])
def test_settings_take_the_place_of_their_own_kind_alone(tmp_path: Path, there: str) -> None:
    path = tmp_path / "ship.toml"
    path.write_text(there)
    with pytest.raises(SameFileError, match="a file of another kind is there; give another name"):
        write_whole(path, 'schema = "study/1"\n')
    assert path.read_text() == there
    path.write_text('schema = "study/1"\n')
    write_whole(path, 'schema = "study/1"\nruns = 2\n')
    assert "runs" in path.read_text()


def test_an_exercise_takes_the_place_of_one_with_the_same_briefing_alone(tmp_path: Path) -> None:
    path, designed = tmp_path / "trial.toml", 'schema = "exercise/1"\nbriefing = "Hands off."\n'
    path.write_text('schema = "exercise/1"\nbriefing = "Dive."\n')
    with pytest.raises(SameFileError, match="an exercise of your own is there; give another name"):
        write_whole(path, designed)
    path.write_text(designed)
    write_whole(path, f"{designed}duration_s = 9\n")
    assert "duration_s" in path.read_text()


def test_a_file_may_be_renewed_by_what_has_read_it(tmp_path: Path) -> None:
    path = tmp_path / "boat.toml"
    path.write_text("old")
    note_input(path)
    renew_whole(path, "new")
    assert path.read_text() == "new"


def test_the_number_of_an_input_that_is_gone_bars_no_other_file(tmp_path: Path) -> None:
    """Disks give such a number to the next file."""
    path, other = tmp_path / "in.csv", tmp_path / "other.csv"
    path.write_text("measured")
    note_input(path)
    path.rename(other)  # the same number as a reused one would be
    write_whole(other, "new")
    assert other.read_text() == "new"


def test_a_promise_ends_with_its_block(tmp_path: Path) -> None:
    path = tmp_path / "out.csv"
    path.write_text("old")
    with promising(path, "--csv"):
        with pytest.raises(SameFileError, match="--csv would write over it; give --csv another"):
            note_input(path)
        with (
            pytest.raises(SameFileError, match="--csv writes this file; give another name"),
            promising(path, "--plot"),
        ):
            pass
        write_whole(path, "new")
        note_input(path)  # it is the program's own now
    with promising(path, "--plot"):
        pass
    with promising(path, "--html"):
        pass
    note_input(path)


def test_what_is_no_file_is_neither_input_nor_output(tmp_path: Path) -> None:
    fifo = tmp_path / "pipe"
    os.mkfifo(fifo)
    for path in (Path(os.devnull), fifo, tmp_path, tmp_path / "a\0b"):
        note_input(path)
        with promising(path, "--csv"), promising(path, "--plot"):
            note_input(path)
    write_whole(Path(os.devnull), "text")
    assert sorted(tmp_path.iterdir()) == [fifo]


def test_six_recordings_begun_at_once_all_find_a_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    names = tuple(islice(recording_paths("drill"), 8))
    at_once = Barrier(6)

    def begin(_: int) -> Path | None:
        at_once.wait()
        path, recording = create_recording(names, {}, b"state")
        recording.close()
        return path

    with ThreadPoolExecutor(6) as pool:
        begun = list(pool.map(begin, range(6)))
    assert len(set(begun)) == 6
