"""The first command of the README in a browser, typed at a terminal as it is printed."""

import contextlib
import functools
import os
import re
import shlex
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest
from helpers.browser import Look
from helpers.nursery import start_trainer
from helpers.pages import SIZES, Served
from helpers.places import ROOT, environment
from helpers.waiting import PATIENCE, await_that
from playwright.sync_api import Page, expect

from trainer.config.exercise.course import course, lessons
from trainer.config.exercise.outcome import Outcome
from trainer.config.exercise.progress import ProgressRun, add_run
from trainer.web.pages import PAGES, render

pty = pytest.importorskip("pty")

README_COMMAND = re.compile(r"`\.venv/bin/(trainer\s+run\s+--web)`")
STANDS = 1.5  # [s] in which a boat that sails would have taken three ticks
Door = Callable[..., "Terminal"]


@dataclass
class Terminal(Served):
    """The command at a terminal of its own, in a folder in which nothing was ever done."""

    keys: int = -1
    said: str = ""

    @property
    def url(self) -> str:
        """Return the address that was printed."""
        found = re.search(r"pages at (http://\S+)/", self.said)
        return found[1] if found else ""

    def listen(self) -> None:
        """Take what is printed, until the terminal is closed."""
        with contextlib.suppress(OSError):
            while said := os.read(self.keys, 4096):
                self.said += said.decode(errors="replace")

    def type(self, words: str, answer: str) -> None:
        """Type a line, and wait for its answer."""
        before = len(self.said)
        os.write(self.keys, f"{words}\n".encode())
        await_that(lambda: answer in self.said[before:])

    @property
    def recordings(self) -> list[str]:
        """Return the names of the exercises that were recorded."""
        found = self.folder.glob("submarine-trainer/recordings/*.trainer")
        return sorted(each.name.rsplit("-", 2)[0] for each in found)

    def end(self) -> None:
        """End the command as its user does, and see that it ends well."""
        self.process.send_signal(signal.SIGINT)
        assert self.process.wait(PATIENCE) == 0, self.said


@pytest.fixture
def home() -> Iterator[Path]:
    """Return a fresh folder with a path that is short enough for a socket."""
    with tempfile.TemporaryDirectory(prefix="door") as name:
        yield Path(name)


@pytest.fixture
def door(home: Path) -> Iterator[Door]:
    """Return a function that types a command at a terminal: ``door("trainer run --web")``."""
    with contextlib.ExitStack() as stack:
        yield lambda command: stack.enter_context(typed(command, home))


@contextlib.contextmanager
def typed(command: str, folder: Path) -> Iterator[Terminal]:
    """Run a command at a terminal while the block lasts, once it has told where its pages are."""
    own = {"XDG_RUNTIME_DIR": str(folder), "XDG_STATE_HOME": str(folder)}
    own |= {"BROWSER": "true", "LOGNAME": "ann"}
    keys, terminal = pty.openpty()
    streams = dict.fromkeys(("stdin", "stdout", "stderr"), terminal)
    words = shlex.split(command)[1:]
    process = start_trainer(*words, env={**environment(), **own}, cwd=folder, **streams)
    os.close(terminal)
    session = Terminal(process, 0, folder, keys=keys)
    threading.Thread(target=session.listen, daemon=True).start()
    try:
        await_that(lambda: session.url, lambda: session.said)
        yield session
    finally:
        process.kill()
        process.wait(PATIENCE)
        os.close(keys)


@functools.cache
def printed() -> str:
    """Return the command for a browser as the README prints it."""
    (command,) = README_COMMAND.findall((ROOT / "README.md").read_text(encoding="utf-8"))
    return " ".join(command.split())


def stands(page: Page) -> None:
    """See that no time passes."""
    expect(page.locator("#time")).to_have_text(re.compile("^00:00"))
    time.sleep(STANDS)
    expect(page.locator("#time")).to_have_text(re.compile("^00:00"))


def test_the_command_of_the_readme_stands_until_a_lesson_is_chosen_and_begun(
    door: Door, look: Look
) -> None:
    session = door(printed())
    page, other = look(session), look(session, size="phone")
    expect(page.locator("#title")).to_have_text("It stands until somebody chooses")
    stands(page)

    page.get_by_text("I train").click()
    offered = page.locator("#lessons [data-name]")
    expect(offered.locator("b")).to_have_text([each.title for each in (*lessons(), *course())])
    first = page.locator("#lessons [aria-current=step]")
    expect(first).to_contain_text(lessons()[0].title)
    expect(first).to_be_focused()
    page.keyboard.press("Enter")
    expect(page.locator("#briefing-title")).to_have_text(lessons()[0].title)
    expect(page.locator("#begin")).to_be_focused()
    expect(page.locator("#state")).to_have_text("FROZEN")
    page.keyboard.press("Enter")
    expect(page.locator("#time")).to_have_text(re.compile("00:0[1-9]"))

    expect(other.locator("#title")).to_have_text(lessons()[0].title)  # chosen there counts here
    expect(other.locator("#scenarios")).to_be_hidden()
    session.end()
    assert session.recordings == [lessons()[0].name]  # a choice alone leaves none
    await_that((session.folder / "submarine-trainer/trainees/ann.json").exists)


def test_i_train_shows_what_is_passed_and_chooses_the_next(
    door: Door, look: Look, home: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_STATE_HOME", str(home))
    run = ProgressRun("a", 0, lessons()[0].name, "t", "2026", 60.0, Outcome.DONE, None)
    add_run("ann", run)
    for branch, outcome in enumerate((Outcome.WON, Outcome.LOST)):
        name = course()[branch].name
        add_run("ann", ProgressRun("b", branch, name, "t", "2026", 60.0, outcome, 71.0 - branch))

    page = look(door(printed()), "trainee")

    shown = page.locator("#lessons small")
    expect(shown.nth(0)).to_have_text(f"{lessons()[0].steps} steps, done")
    expect(shown.nth(len(lessons()))).to_contain_text(", passed, 71 marks of 100")
    expect(shown.nth(len(lessons()) + 1)).to_have_text(re.compile(", 70 marks of 100$"))
    expect(page.locator("#lessons [aria-current=step]")).to_contain_text(lessons()[1].title)
    told = f"2 of {len(lessons()) + len(course())} passed; the next is chosen"
    expect(page.locator("#lessons summary")).to_have_text(told)


@pytest.mark.parametrize("size", ["phone", "tablet", "laptop"])
def test_scenarios_with_a_picture_and_a_line_stand_before_the_stations(
    door: Door, look: Look, size: str
) -> None:
    page = look(door(printed()), size=size)
    cards = page.locator("#scenarios a")
    expect(cards).to_have_count(5)
    tops = page.locator("#ask, #scenarios, #others").evaluate_all(
        "(parts) => parts.map((each) => each.getBoundingClientRect().top)"
    )
    assert tops == sorted(tops)
    width = SIZES[size][0]
    for card in cards.all():
        boxes = [card.locator(part).bounding_box() for part in ("svg", "b", "span")]
        assert all(box and box["width"] > 60 and box["x"] + box["width"] < width for box in boxes)

    cards.first.click()
    expect(page.locator("#briefing-title")).to_have_text("Deep, then shallow")
    expect(page.locator("#begin")).to_be_focused()


def test_each_scenario_has_the_title_of_its_exercise_and_no_name_of_a_file() -> None:
    (html,) = (render(page) for page in PAGES if page.name == "")
    titles = {each.word: each.title for each in course()}

    cards = re.findall(r'begin=([\w-]+)".*?<b>(.*?)</b>', html, re.DOTALL)

    assert cards
    assert [title for _, title in cards] == [titles[word] for word, _ in cards]
    assert not [each.name for each in course() if f"={each.name}" in html]


def test_the_first_to_choose_counts_at_the_terminal_too(door: Door, look: Look) -> None:
    session = door(printed())
    page = look(session)
    expect(page.locator("#scenarios")).to_be_visible()

    session.type("depth 80", "or type here: next")
    session.type("next exercise-3", "next: exercise-3")

    expect(page.locator("#title")).to_have_text("Deep, then shallow")
    expect(page.locator("#says")).to_have_text("It has not begun yet.")
    session.type("next exercise-5", "this exercise is not over")
    session.type("run", "running")
    expect(page.locator("#says")).to_have_text("Time runs.")


def test_a_named_exercise_stands_with_its_briefing_and_one_for_visitors_sails(
    door: Door, look: Look
) -> None:
    page = look(door("trainer run periscope-depth --web"))
    expect(page.locator("#title")).to_have_text("Up in a rough sea")
    expect(page.locator("#about")).not_to_be_empty()
    stands(page)

    visited = look(door("trainer run visitor-dive --web"))
    expect(visited.locator("#says")).to_have_text("Time runs.")


@pytest.mark.process
def test_a_command_in_the_background_of_a_shell_is_not_stopped_for_its_terminal(
    home: Path,
) -> None:
    own = environment(XDG_RUNTIME_DIR=str(home), XDG_STATE_HOME=str(home), BROWSER="true")
    keys, terminal = pty.openpty()
    begun = f"set -m; {sys.executable} -m trainer run --web 2>said &"
    line = f"{begun} until grep -q 'pages at' said; do sleep 0.1; done; jobs >how; kill %1"
    words = ["setsid", "--ctty", "sh", "-c", line]
    subprocess.run(
        words, stdin=terminal, stdout=terminal, env=own, cwd=home, timeout=PATIENCE, check=False
    )
    os.close(terminal)
    os.close(keys)
    assert "Running" in (home / "how").read_text()
