"""Help: a first exercise step by step, then the keys and what the signs mean."""

from dataclasses import dataclass
from typing import Final

from trainer.console.choice import NOTHING, Done
from trainer.console.keys import KEYS
from trainer.console.model import SessionModel
from trainer.console.pane import Line, Lines, fit, line

FIRST: Final = """
A first exercise

  In a shell: trainer run periscope-depth   (trainer exercises lists others)
  The line at the top says RUNNING or FROZEN; F2 changes it.

  1  Break something: F4, type stern-stuck, Enter. The planes stay where
     they are; "broken" shows it. What was sent stands in the log as an
     order: you could have typed casualty stern-stuck at the bottom.
  2  Give an order: type depth 30 and press Enter. Tab completes a word,
     Up and Down bring earlier orders back. help depth says more.
  3  Put it right: F4, then Delete on the casualty, which is at the top.
  4  Go back two minutes: F6, then 2, then Enter. Time stands still there;
     F2 lets it go on, on a new branch. The old one stays in the recording.
  5  Watch it again: F7, then 2, then Enter: the orders are given again as
     they were. F7 once more ends the replay and you go on from there.
  6  F9 marks a moment with a remark. F10, then Q ends the run; the summary
     names its recording, from which  trainer debrief FILE  makes a page.
"""
STATION: Final = """
Your keys move your controls; every press is sent as an order, which the log
shows with its answer. Enter lets you type orders: help lists them. What your
instruments show may be wrong: that is part of the exercise.
"""
SIGNS: Final = """
Signs

  >   ordered       R L   right, left      R D   rise, dive (planes)
  hand              steered by hand; auto: by the autopilot
  --  dashed        ordered, in a chart; the drawn line is the boat
  In the log: > sent, ? refused, ! called out, < gone back, * marked
  On the time line: S snapshot, C casualty, M mark, the bar is now
"""


@dataclass
class Guide:
    """The help of a role, from the line on that is at the top."""

    model: SessionModel
    top: int = 0
    size: tuple[int, int] = (80, 60)

    def press(self, key: str, _character: str | None) -> Done | None:
        """Take a key; return how the dialog ends, None while it goes on."""
        moves = {"up": -1, "down": 1, "pageup": -12, "pagedown": 12, "home": -999, "end": 999}
        if key in moves:
            self.top = min(max(self.top + moves[key], 0), max(len(self._lines()) - 4, 0))
            return None
        return NOTHING if key in ("escape", "f1", "q", "enter", "f10", "question_mark") else None

    def draw(self, width: int, height: int) -> Lines:
        """Return the page, as much of it as there is room for."""
        lines = self._lines()[self.top :]
        foot = line((" Up, Down, Page Up, Page Down: more    Esc: back", "dim"))
        shown = lines[: height - 1]
        shown += [line()] * (height - 1 - len(shown))
        return [fit(each, width) for each in (*shown, foot)][:height]

    def _lines(self) -> list[Line]:
        """Return the whole page."""
        text = FIRST if self.model.role == "instructor" else STATION
        keys = [(key.label, key.does) for key in KEYS[self.model.role]]
        found = [title_line(row) for row in text.strip("\n").splitlines()]
        found += [line(), line((" This session", "title")), line()]
        found += [line(f"   {said}") for said in self.model.briefing]
        found += [line(), line((" Keys", "title")), line()]
        found += [line((f"   {label:<14}", "value"), does) for label, does in keys]
        found += [line(), *(title_line(row) for row in SIGNS.strip("\n").splitlines())]
        return found


def title_line(text: str) -> Line:
    """Return a line of the page, a heading in its ink."""
    heading = bool(text) and not text.startswith(" ") and len(text.split()) < 4
    return line((f" {text}", "title" if heading else "plain"))
