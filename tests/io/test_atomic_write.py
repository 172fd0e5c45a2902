"""Files of the user's are replaced whole or not at all; recordings started at once find names."""

from concurrent.futures import ThreadPoolExecutor
from itertools import islice
from pathlib import Path
from threading import Barrier

import pytest

from trainer.io.atomic_write import replacing
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
