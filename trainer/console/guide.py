"""Windows with long texts: help, the briefing of an exercise, its end with the marks.

``app`` opens them over the screen. A text is broken into lines when it is drawn, because a window
may change its width while it is open.
"""

import math
import re
import textwrap
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final, NamedTuple

from trainer.config.exercise.course import AXIS_STATIONS
from trainer.config.exercise.loss_words import word_loss
from trainer.console.dialogs import NO_OUTCOME, DialogOutcome
from trainer.console.drawing.chart import plan
from trainer.console.exercise import LESSON_END
from trainer.console.journal import clock
from trainer.console.keys import KEYS
from trainer.console.model import SessionModel
from trainer.console.pane import Line, Lines, first_fitting, fit, length, line

Text = Callable[[], list[Line]]  # lines of any length; the window breaks them

INSTRUCTOR_HELP: Final = (
    "  To begin an exercise, type in a shell: trainer run periscope-depth",
    "  The line at the top says RUNNING or FROZEN; F2 changes it.",
    "",
    (
        "  1  Break something: F4, type stern-stuck, Enter. The planes stay where they are; "
        '"broken" shows it. The log shows the order that was sent. You can also type that order: '
        "casualty stern-stuck."
    ),
    (
        "  2  Give an order: type depth 30 and press Enter. Tab completes a word, Up and Down "
        "bring earlier orders back. help depth says more."
    ),
    "  3  Repair it: F4, Up to the casualty at the top of the list, then Delete.",
    (
        "  4  Go back two minutes: F6, then 2, then Enter. Time is stopped there. F2 starts it "
        "again: a new branch begins, and the recording keeps the old one."
    ),
    (
        "  5  Watch it again: F7, then 2, then Enter. The replay repeats all orders. Press F7 "
        "again: the replay ends, and you go on from that moment."
    ),
    (
        "  6  F9 marks this moment with a remark. F10, then Q, ends the run. The last lines name "
        "the recording;  trainer debrief FILE  makes a page from it."
    ),
    (
        "  7  To train alone, type `role trainee`: you work the whole boat, and see nothing that "
        "is to be found out. `role instructor` comes back here."
    ),
)
STATION_HELP: Final = (
    (
        "  Your keys move your controls. Every press sends an order; the log shows the order and "
        "its answer. Press Enter to type an order: help lists the orders. Your instruments may "
        "show wrong values: that is part of the exercise."
    ),
    "",
    (
        "  When you get an order, the bell rings. The order is shown in blue beside its "
        "instrument, with the change that is left. NEW ORDER stays below until you repeat it: "
        "press Enter, or type the order and aye. The repeat moves no control: you do."
    ),
)
TRAINEE_HELP: Final = (
    (
        "  You work the boat alone: keys move the controls, and you may type an order at any time. "
        "F12 shows what is to be done; Enter there begins. F2 stops time, and starts it again."
    ),
    "",
    (
        "  A lesson says each step above the panel, and lights up the instrument to look at. An "
        "order to the crew is yours to carry out: it stands in blue beside its instrument, NEW "
        "until you press Enter. again begins from the start, next is the next lesson or exercise."
    ),
    "",
    (
        "  Alone, you may take another chair: `role instructor` shows what is hidden, `role helm` "
        "has the helm only, and `role trainee` is this one. Your marks then say since when you "
        "saw what is hidden."
    ),
)
SIGN_MEANINGS: Final = (
    ">", "ordered",
    "R L", "right, left (rudder)",
    "R D", "rise, dive (planes)",
    "hand", "steered by hand; auto: by the autopilot",
    "-- dashed", "in a chart: what is ordered; the full line is the boat",
    "in the log", "> sent, ? refused, o ordered to the crew, ! called out, < gone back, * marked",
    "time line", "S snapshot, C casualty, M mark; the bar is now",
)  # fmt: skip
MOUSE_HELP: Final = (
    (
        "  Click a key in the last line, a row of a list, a place on the time line; turn the wheel "
        "over the log or a window. Hold Shift to select text for your terminal, as without a mouse."
    ),
)
LIMIT_TEXTS: Final = {
    "depth_m_max": "no deeper than {} m",
    "depth_m_min": "no shallower than {} m",
    "pitch_deg_max": "pitch {} deg at most",
    "heel_deg_max": "heel {} deg at most",
    "speed_kn_max": "no faster than {} kn",
    "speed_kn_min": "no slower than {} kn",
    "speed_over_ground_kn_max": "no faster than {} kn over the ground",
    "validity_level_max": "validity level {} at most",
    "cpa_m_min": "no nearer than {} m to a ship",
}
# of a greeting: what no briefing needs
PASSING_PATTERN: Final = re.compile("^by hand: | has come$")
PAGE_LETTERS: Final = 60  # [characters] from which a line was broken because the page ended
SCROLL_STEPS: Final = {
    "up": -1,
    "down": 1,
    "pageup": -12,
    "pagedown": 12,
    "space": 12,
    "home": -9999,
    "end": 9999,
}
CLOSE_KEYS: Final = ("escape", "f1", "q", "enter", "f10", "f12", "question_mark")
LABEL_COLUMNS: Final = 16  # [columns] of the label before an explanation
DEAF_TIME_S: Final = 1.0  # [s] that keys are ignored which were meant for what was there before


@dataclass
class TextView:
    """The text of a window, broken into lines of its width, from its top line."""

    title: str
    text: Text
    keys: Mapping[str, tuple[str, str]] = field(default_factory=dict)  # their orders, and words
    typing: bool = False  # a letter closes it, and begins the next order
    top: int = 0
    size: tuple[int, int] = (96, 60)
    _last: int = 0  # the largest top that still fills the window

    def press(self, key: str, _character: str | None) -> DialogOutcome | None:
        """Take a key; return how the window ends, None while it goes on."""
        if key in SCROLL_STEPS:
            self.top = min(max(self.top + SCROLL_STEPS[key], 0), self._last)
            return None
        if key.lower() in self.keys:
            return DialogOutcome((self.keys[key.lower()][0],))
        return NO_OUTCOME if key.lower() in CLOSE_KEYS else None

    def click(self, _column: int, row: int, _width: int) -> DialogOutcome | None:
        """Take a click on one of the keys, which stand at the top."""
        index = row - 1 + self.top
        return self.press(list(self.keys)[index], None) if 0 <= index < len(self.keys) else None

    def draw(self, width: int, height: int) -> Lines:
        """Return as much of the text as there is room for, and its lines' places."""
        lines = [row for each in self.text() for row in break_line(each, max(width - 2, 1))]
        room = max(height - 2, 1)
        self._last = max(len(lines) - room, 0)
        self.top = min(self.top, self._last)
        shown = lines[self.top : self.top + room]
        shown += [line()] * (room - len(shown))
        return [
            fit(drawn_row, width)
            for drawn_row in (
                line((f" {self.title}", "title")),
                *shown,
                self._foot(lines, room, width),
            )
        ][:height]

    def _foot(self, lines: Sequence[Line], room: int, width: int) -> Line:
        """Return what more there is, and the keys; where there is no room, in fewer words."""
        below = len(lines) - self.top - room
        more = f" {below} more lines below: Down or Page Down;" if below > 0 else ""
        back = " Up goes back;" if self.top else ""
        does = "".join(f"   {says}" for _, says in self.keys.values() if says)
        closes = " Esc closes; or type an order" if self.typing else " Esc closes"
        short = f" {below} more: Down;" if below > 0 else back
        return first_fitting(
            width,
            line((f"{more}{back}", "warning"), (closes, "dim"), (does, "title")),
            line((short, "warning"), (does, "title"), (f"  {closes}", "dim")),
        )


def break_line(drawn: Line, width: int) -> Lines:
    """Return a line in lines of at most ``width`` columns, broken between words.

    The later ones begin below the first word, or below the text that follows a label.
    """
    if length(drawn) <= width:
        return [drawn]
    text = "".join(part for part, _ in drawn)
    label = drawn[0] if len(drawn) > 1 else ("", "plain")
    rest, ink = text[len(label[0]) :], drawn[-1][1]
    start = len(label[0]) or len(text) - len(text.lstrip())
    hang = " " * min(start or 0, max(width - 8, 0))
    if not label[0] and rest.lstrip()[:1].isdigit():
        hang += "   "  # below the words of a numbered step
    room = max(width, len(hang) + 8)
    first, *others = textwrap.wrap(
        rest, room, initial_indent=" " * len(label[0]), subsequent_indent=hang, drop_whitespace=True
    ) or [""]
    if not label[0]:
        first = " " * start + first.lstrip()
    return [
        (*([label] if label[0] else []), (first[len(label[0]) :], ink)),
        *(line((each, ink)) for each in others),
    ]


@dataclass
class PlanView:
    """The track from above, in a window."""

    model: SessionModel
    size: tuple[int, int] = (300, 100)

    def press(self, key: str, _character: str | None) -> DialogOutcome | None:
        """Take a key; return how the window ends, None while it goes on."""
        return NO_OUTCOME if key in (*CLOSE_KEYS, "ctrl+t") else None

    def click(self, _column: int, _row: int, _width: int) -> DialogOutcome | None:
        """Take a click, which does nothing here."""
        return None

    def draw(self, width: int, height: int) -> Lines:
        """Return the track."""
        return plan(self.model, width, height)


def titled_rows(title: str, rows: Sequence[Line]) -> list[Line]:
    """Return rows below a heading, an empty line before it."""
    return [line(), line((f" {title}", "title")), line(), *rows]


def labelled_line(label: str, says: str) -> Line:
    """Return an explanation behind its label."""
    return line((f"   {label:<{LABEL_COLUMNS}}", "value"), (says, "plain"))


def plain_rows(texts: Sequence[str]) -> list[Line]:
    """Return rows of plain text."""
    return [line((text, "plain")) for text in texts]


def briefing_rows(model: SessionModel) -> list[Line]:
    """Return the exercise: its state, its conditions, its limits, and the crew's orders."""
    rows = [labelled_line(label, says) for label, says in exercise_lines(model) if says]
    exercise = model.exercise
    if exercise.marks:
        rows += titled_rows("Marks", [line((f"   {text}", "value")) for text in exercise.marks])
    task_lines = exercise.lists.get("line", [])
    known = (*task_lines, exercise.values.get("title"))
    said = [
        text for text in exercise.briefing if text not in known and not PASSING_PATTERN.search(text)
    ]
    rows += [line()] * bool(rows)
    rows += [line((f"   {text}", "plain")) for text in paragraphs(task_lines)]
    rows += [line()] * bool(task_lines)
    return [*rows, *(line((f"   {text}", "dim")) for text in said)]


def paragraphs(lines: Sequence[str]) -> list[str]:
    """Return a page's broken lines as paragraphs, ready to be broken for a window."""
    texts: list[str] = []
    going_on = False
    for text in lines:
        if going_on:
            texts[-1] += f" {text}"
        else:
            texts.append(text)
        going_on = len(text) >= PAGE_LETTERS
    return texts


def exercise_lines(model: SessionModel) -> list[tuple[str, str]]:
    """Return what an exercise asks for and how much time is left, label by label."""
    exercise, lists = model.exercise.values, model.exercise.lists
    left = model.exercise.left_at(model.picture.seconds)
    time_left = "" if left is None else f"{clock(left)[3:]} (minutes:seconds)"
    return [
        ("exercise", exercise.get("title", "")),
        ("its file", exercise.get("name", "")),
        ("it is over", model.exercise.outcome),
        ("time left", time_left),
        ("what wins", "; ".join(lists.get("wins", []))),
        ("limits", limits_said(exercise.get("limits", ""))),
        ("it is lost at", " or ".join(map(word_loss, lists.get("lost", [])))),
        ("by hand", by_hand(exercise.get("hand", ""), alone=model.trains)),
        ("automatic", exercise.get("allowed", "").replace(",", ", ")),
        ("a hint costs", f"{exercise['hint']} marks" if "hint" in exercise else ""),
        (
            "free",
            "no marks: the autopilot may steer what was by hand" if exercise.get("free") else "",
        ),
    ]


def by_hand(told: str, *, alone: bool = False) -> str:
    """Return what the crew works, and at which stations; "" for nothing."""
    axes = [axis for axis in told.split(",") if axis]
    if not axes:
        return ""
    if alone:
        return ", ".join(axes)
    stations = dict.fromkeys(AXIS_STATIONS[axis] for axis in axes if axis in AXIS_STATIONS)
    pilot = ", or one pilot" if {"helm", "planes"} == set(stations) else ""
    return f"{', '.join(axes)}; needs: {' and '.join(stations)}{pilot}"


def limits_said(told: str) -> str:
    """Return the limits of an exercise in words. One that is not known as it came."""
    texts = []
    for part in filter(None, told.split(",")):
        name, _, value = part.partition(":")
        texts.append(LIMIT_TEXTS[name].format(value) if name in LIMIT_TEXTS else part)
    return "; ".join(texts)


def guide(model: SessionModel) -> TextView:
    """Return the help of a role: first steps, the exercise, all keys, the signs."""

    def text() -> list[Line]:
        first: Sequence[str] = INSTRUCTOR_HELP if model.instructs else STATION_HELP
        first = TRAINEE_HELP if model.trains else first
        keys = [labelled_line(key.label, key.does) for key in KEYS[model.role]]
        signs = [
            labelled_line(*pair)
            for pair in zip(SIGN_MEANINGS[::2], SIGN_MEANINGS[1::2], strict=True)
        ]
        return [
            *plain_rows(first),
            *titled_rows("This session", briefing_rows(model)),
            *titled_rows("Keys", keys),
            *titled_rows("Mouse", plain_rows(MOUSE_HELP)),
            *titled_rows("Signs", signs),
        ]

    return TextView("A first exercise" if model.instructs else "Your station", text)


def briefing(model: SessionModel) -> TextView:
    """Return the window with the briefing; the time left goes on in it."""
    keys = {} if model.instructs or not model.exercise.values else {"r": ("ready", "R says ready")}
    if model.trains and model.picture.frozen and not model.exercise.outcome:
        keys = {"enter": ("run", "Enter begins"), "r": ("run", "")}
    return TextView("Briefing", lambda: briefing_rows(model), keys)


def answer(words: str, lines: Sequence[str]) -> TextView:
    """Return the window with a long answer."""
    rows = [line((f" {text}", "plain")) for text in lines if text]
    return TextView(words, lambda: rows, typing=True)


class NextStep(NamedTuple):
    """A step after an exercise: its order, its words, whether it is asked once more."""

    order: str
    does: str
    asked: bool = False


NEXT_STEPS: Final = {
    "r": NextStep("release marks", "show the marks to the crew"),
    "d": NextStep("debrief", "write the debrief"),
    "a": NextStep("again", "again, from the start", asked=True),
    "h": NextStep("again from 2 min", "again, from two minutes ago", asked=True),
    "n": NextStep("next", "choose another exercise"),
    "q": NextStep("quit", "end the run"),
}


STAYING_KEYS: Final = frozenset("rd")
LEADING_KEYS: Final = frozenset("nadhw")  # that lead on though the window was closed
WRONG_LEAD_S: Final = 15.0  # [s] before a moment that went wrong, from where it is flown again


def steps_after(model: SessionModel) -> dict[str, NextStep]:
    """Return what may follow an exercise at this screen, by its key."""
    if not model.trains:
        told = len(model.exercise.marks) > 1  # with reasons; else there are none to release
        return {key: step for key, step in NEXT_STEPS.items() if key != "r" or told}
    steps = {"n": NextStep("next", "the next lesson or exercise"), "a": NEXT_STEPS["a"]}
    if model.exercise.undone:  # who trains chooses: once more, or on all the same
        steps = {"a": NEXT_STEPS["a"]}
        if name := model.exercise.following:
            steps["n"] = NextStep(f"next {name}", f"on all the same: {name}", asked=True)
    if model.exercise.wrong_at is not None:
        begin = max(model.exercise.wrong_at - WRONG_LEAD_S, 0.0)
        back = max(model.picture.seconds - begin, 1.0)
        does = f"again, from where it went wrong ({clock(begin)[3:]})"
        steps["w"] = NextStep(f"again from {back:.0f} s", does, asked=True)
    steps["d"] = NextStep("debrief", "what each minute cost, and a page")
    return {**steps, "h": NEXT_STEPS["h"], "q": NextStep("quit", "leave")}


class EndView(TextView):
    """The window of an exercise that is over: what can follow, and the marks."""

    def __init__(self, model: SessionModel) -> None:
        super().__init__("Exercise over", self._rows, {})  # its keys follow from the marks
        self._model = model
        self._since = model.clock()
        self._chosen = ""

    def lead_on(self, key: str) -> DialogOutcome | None:
        """Take the key by which the window, closed before, is opened again."""
        self._since = -math.inf  # it hears at once
        self._rows()
        return self.press(key, key)

    def press(self, key: str, character: str | None) -> DialogOutcome | None:
        """Take a key; return how the window ends, None while it goes on."""
        key = key.lower()
        if self._model.clock() - self._since < DEAF_TIME_S:
            return None
        before, self._chosen = self._chosen, key
        steps = steps_after(self._model)
        if key in STAYING_KEYS and key in steps:  # what it asks for is shown here
            self._model.order(steps[key].order)
            return None
        if key in steps and steps[key].asked and before != key:
            return None
        return super().press(key, character)

    def _rows(self) -> list[Line]:
        steps = steps_after(self._model)
        self.keys = {key: (each.order, "") for key, each in steps.items()}
        rows = [labelled_line(key.upper(), self._says(key)) for key in steps]
        first = "; an instructor who is here has them first" if self._model.trains else ""
        marks = self._model.exercise.marks or [f"the marks are being calculated{first}"]
        if undone := self._model.exercise.undone:
            numbers = f"step{'' if len(undone) == 1 else 's'} {', '.join(undone)}"
            marks = [f"the lesson is not done: {numbers}; lessons have no marks"]
        elif self._model.exercise.step == LESSON_END:
            marks = ["the lesson is done, each step of it; lessons have no marks"]
        if self._model.exercise.debriefing:
            marks = [*marks, f"the debrief is being written: {self._model.exercise.debriefing}"]
        rows += [line(), line((f" {self._model.exercise.outcome}", "title")), line()]
        return rows + [line((f"   {told}", "plain")) for told in marks]

    def _says(self, key: str) -> str:
        """Return what a key does, or that it is to be pressed once more."""
        step = steps_after(self._model)[key]
        if step.order == "debrief" and self._model.exercise.page:
            return f"{step.does}: {self._model.exercise.page}"
        if key != self._chosen:
            return step.does
        once_more = f"{step.does}: press {key.upper()} once more"
        return once_more if step.asked else f"{step.does}: done"
