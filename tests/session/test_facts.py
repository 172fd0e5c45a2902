"""Facts: what programs are told in fields, so that every text of the session may be reworded."""

import contextlib
import re
import subprocess
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from helpers.nursery import run_trainer, start_trainer
from helpers.places import ROOT
from helpers.rewording import OTHER, Rewording
from helpers.waiting import await_that

from trainer.console.client import Client
from trainer.console.layouts import LAYOUTS, wishes
from trainer.console.model import SessionModel
from trainer.io.orders import sentences

pytestmark = pytest.mark.process


@pytest.fixture
def port(tmp_path: Path) -> Iterator[Rewording]:
    """Return a session of BB2, and a port at which all that it says is in other words."""
    where = tmp_path / "s"
    words = ["serve", "--socket", str(where), "--listen", "none", "--no-record", "--speed", "20"]
    with start_trainer(*words, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL) as session:
        for line in session.stderr or ():
            if "listening" in line:
                break
        yield Rewording(where)
        session.terminate()
        session.communicate()


def until(sight: SessionModel, true: Callable[[], object]) -> None:
    """Let a screen hear until something is true of it."""

    def is_true() -> object:
        sight.hear()
        return true()

    await_that(is_true)


def test_a_screen_works_when_every_text_of_the_session_is_reworded(port: Rewording) -> None:
    role = "instructor"
    client = Client(lambda: f"tcp://127.0.0.1:{port.port}", role, wishes(LAYOUTS[role]))
    sight = SessionModel(client, role, LAYOUTS[role].charts)
    client.start()
    try:
        until(sight, lambda: sight.vessel.casualties)
        names = {broken.name for broken in sight.vessel.casualties}
        assert {"stern-stuck", "flooding-aft"} <= names
        assert all(broken.says for broken in sight.vessel.casualties)

        sight.order("snapshot before-jam")
        until(sight, lambda: sight.timeline.snapshots)
        assert [kept.text for kept in sight.timeline.snapshots] == ["before-jam"]

        sight.order("casualty stern-stuck")
        sight.order("mark here we go")
        until(sight, lambda: len(sight.timeline.marks) == 2)
        assert [(kept.sign, kept.text) for kept in sight.timeline.marks] == [
            ("C", "casualty stern-stuck"),
            ("M", "here we go"),
        ]
        assert OTHER in {entry.text for entry in sight.journal.entries}

        sight.order("restore before-jam")
        until(sight, lambda: not sight.timeline.marks)
        assert sight.timeline.furthest == sight.timeline.snapshots[0].seconds

        sight.order("rudder left 80")  # beyond the boat's limit
        until(sight, lambda: sight.sent.refused)
        sight.order("quit")
        until(sight, lambda: sight.over)
        assert sight.ended
    finally:
        client.close(1.0)


@pytest.mark.parametrize("words", ["detach\n", "quit\n", ""])
def test_attach_leaves_properly_when_every_text_of_the_session_is_reworded(
    port: Rewording, words: str
) -> None:
    attach = ["attach", "--connect", f"tcp://127.0.0.1:{port.port}"]
    done = run_trainer(*attach, typed=f"depth 80\nmark naïve\n{words}", timeout=60)
    assert done.returncode == 0, done.stderr
    assert '? "?" (U+00EF) cannot be sent; type plain letters' in done.stdout
    assert re.search(OTHER, done.stdout)


def test_attach_tells_a_session_that_was_killed_from_one_that_ended(tmp_path: Path) -> None:
    where = tmp_path / "s"
    words = ["serve", "--socket", str(where), "--listen", "none", "--no-record"]
    with (
        start_trainer(*words, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL) as session,
        contextlib.ExitStack() as stack,
    ):
        for line in session.stderr or ():
            if "listening" in line:
                break
        attach = stack.enter_context(
            start_trainer(
                "attach",
                "--connect",
                str(where),
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
            )
        )
        for line in attach.stdout or ():
            if "you are an instructor" in line:
                break
        session.kill()
        _, told = attach.communicate(timeout=60)
        assert attach.returncode == 1
        assert "the session is gone" in told
        session.communicate()


def test_every_fact_has_its_meaning_in_the_document() -> None:
    page = (ROOT / "docs/station-tables.md").read_text(encoding="utf-8")
    for what, subject in sentences.FACTS.items():
        assert f"| `{what}` | {subject} |" in page
