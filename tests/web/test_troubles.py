"""A session with a page and a station open runs out of disk or descriptors, and gets them back."""

import contextlib
from collections.abc import Iterator
from pathlib import Path
from subprocess import Popen

import pytest
from helpers.pages import served
from helpers.waiting import eventually
from helpers.wire import ask, dialled

from trainer.io.recording.recording import Recording

resource = pytest.importorskip("resource")
PRLIMIT = getattr(resource, "prlimit", None)
pytestmark = [
    pytest.mark.process,
    pytest.mark.skipif(PRLIMIT is None, reason="limits of another process: Linux"),
]
ORDERS = [f"rudder right {angle}" for angle in range(3, 13)]
LARGEST_FILE = 200_000  # [bytes] where the disk is full


@contextlib.contextmanager
def limited(process: Popen[str], what: int, most: int) -> Iterator[None]:
    """Let a process have no more of something."""
    assert PRLIMIT
    before = PRLIMIT(process.pid, what)
    PRLIMIT(process.pid, what, (most, before[1]))
    yield
    PRLIMIT(process.pid, what, before)


def check_recorded(path: Path) -> None:
    """Check that all that was ordered and marked is in the recording."""
    with contextlib.closing(Recording.look(path)) as recording:
        given = [each.text for each in recording.orders(recording.branch)]
        assert [text for text in given if text in ORDERS] == ORDERS
        marks = [each.text for each in recording.events() if each.kind == "mark"]
        assert marks == [f"at {text}" for text in ORDERS]
        assert len(recording.branches()) == 1


def test_a_full_disk_stops_no_page_and_no_station_and_loses_nothing(tmp_path: Path) -> None:
    path = tmp_path / "run.trainer"
    ahead = path.with_name(path.name + "-wal")
    with served("depth-changes", "--record", str(path), frozen=False) as session:
        helm, instructor = session.attach("helm"), session.attach()
        assert instructor.ask("subscribe events")[0]
        with dialled(session.port) as page:
            assert ask(page, "role planes")[0] == "ok"
            while ahead.stat().st_size < LARGEST_FILE:
                assert helm.ask("rudder amidships")[0]
            with limited(session.process, resource.RLIMIT_FSIZE, LARGEST_FILE):
                for text in ORDERS:
                    obeyed, answer = helm.ask(text)
                    assert obeyed
                    assert answer.endswith("(not recorded)")
                    assert instructor.ask(f"mark at {text}")[0]
                assert ask(page, "stern planes rise 3")[0] == "ok"
                assert not instructor.ask("snapshot here")[0]

            def told() -> list[str]:
                """Return what was told of the recording, by anything that is asked."""
                instructor.ask("who")
                news = [each.fields for each in instructor.news]
                return [text for *_, kind, text in news if kind == "trouble"]

            assert eventually(lambda: "recorded again in branch 1; nothing is lost" in told())
            assert told()[0].startswith(f"NOT RECORDED: {path}: ")
            assert instructor.ask("snapshot here")[0]
    check_recorded(path)


def test_a_session_without_descriptors_records_on_and_takes_stations_again(tmp_path: Path) -> None:
    path = tmp_path / "run.trainer"
    with served("depth-changes", "--record", str(path), frozen=False) as session:
        helm, instructor = session.attach("helm"), session.attach()
        with dialled(session.port) as page:
            assert ask(page, "role planes")[0] == "ok"
            with limited(session.process, resource.RLIMIT_NOFILE, 3):
                for text in ORDERS:
                    assert helm.ask(text) == (True, f"{text}, by hand")  # and it is recorded
                    assert instructor.ask(f"mark at {text}")[0]
                assert ask(page, "stern planes rise 3")[0] == "ok"
                assert instructor.ask("snapshot here")[0]
            late = session.attach("observer")  # who comes once there are some
            assert late.ask("who")[0]
    check_recorded(path)
