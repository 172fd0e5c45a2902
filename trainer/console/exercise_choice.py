"""The list from which a user chooses an exercise before a session.

``trainer run`` on a terminal asks by ``choose_exercise`` when no exercise was given. It runs before
there is a session, because the session is made for what is chosen.
"""

import textwrap
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from typing import ClassVar, Final

from textual.app import App
from textual.binding import BindingType

from trainer.config.exercise.course import Lesson
from trainer.config.exercise.progress import Progress
from trainer.console.dialogs import HEAD_ROWS, NO_OUTCOME, Choice, ChoiceRow, Dialog, DialogOutcome
from trainer.console.pane import Lines, fit, line

FREE_SAILING: Final = "Sail freely"
TITLE_COLUMNS: Final = 38  # [columns] of a title
BRIEFING_ROWS: Final = 4  # [rows] of what is chosen
I_TRAIN: Final = "I train"
I_INSTRUCT: Final = "I instruct"
NO_TITLE: Final = "No title or name has these letters. Backspace deletes the last letter."


@dataclass
class ExerciseChoice(Choice):
    """The list of exercises by their titles, with the briefing of the chosen one.

    File names are not shown, because they tell what will go wrong; who knows one finds it by that.
    """

    @property
    def shown(self) -> list[ChoiceRow]:
        """Return the rows that what has been typed leaves, by title first, then by name."""
        found, typed = super().shown, self.typed.lower()
        named = [row for row in self.rows if typed in row.words and row not in found]
        return [*found, *named]

    def draw(self, width: int, height: int) -> Lines:
        """Return the dialog."""
        shown = self.shown
        index = min(self.index, max(len(shown) - 1, 0))
        room = max(height - HEAD_ROWS - BRIEFING_ROWS - 1 - len(self.advice), 1)
        first = min(max(index - room // 2, 0), max(len(shown) - room, 0))
        self._first, self._rows = first, room
        rows = [
            line((f" {'>' if first + i == index else ' '} {row.name}", "plain"))
            if first + i != index
            else line((f" > {row.name:<{max(width - 4, 0)}} ", "chosen"))
            for i, row in enumerate(shown[first : first + room])
        ]
        rows += [line()] * (room - len(rows))
        says = self.chosen.says if self.chosen else NO_TITLE
        briefing = textwrap.wrap(says, max(width - 4, 8))
        below = [line((f"   {text}", "ordered")) for text in briefing[:BRIEFING_ROWS]]
        below += [line()] * (BRIEFING_ROWS - len(below))
        hidden = len(shown) - first - room
        more = [f"{first} more above"] * (first > 0) + [f"{hidden} more below"] * (hidden > 0)
        lines = [
            line((f" {self.title}", "title")),
            line((" > ", "dim"), (self.typed, "value"), ("_", "dim")),
            *rows,
            line((f"   {', '.join(more)}", "warning")),
            *below,
            *(line((f" {text}", "dim")) for text in self.advice),
        ]
        return [fit(each, width) for each in lines[:height]]


def side_choice() -> ExerciseChoice:
    """Return the first question: who trains is told nothing that he is to find out."""
    rows = [
        ChoiceRow(
            I_TRAIN,
            I_TRAIN,
            "",
            "Lessons that lead step by step, then exercises with marks. You work the boat alone; "
            "nothing is told that you are to find out.",
        ),
        ChoiceRow(
            I_INSTRUCT,
            I_INSTRUCT,
            "",
            "The instructor's console: you see all, also what is hidden, break things, go back in "
            "time; others may join as the crew. Or sail freely.",
        ),
    ]
    advice = ("Press Up or Down; Enter goes on, Esc leaves",)
    return ExerciseChoice("What do you want?", rows, advice, size=(76, 14))


def exercise_choice(
    offered: Sequence[Lesson], *, trains: bool = False, progress: Progress | None = None
) -> ExerciseChoice:
    """Return the list. Sailing freely comes first, but last for who trains.

    With a trainee's progress what is weakest and longest ago is chosen, and its reason is told.
    """
    suggestion = progress.suggest(offered, datetime.now(UTC).date()) if progress else None
    reasons = {suggestion.lesson: f"Next: {suggestion.reason}. "} if suggestion else {}
    rows = [
        ChoiceRow(
            FREE_SAILING, FREE_SAILING, "", "No exercise: go to sea at once and do as you like."
        )
    ]
    lessons = [
        ChoiceRow(
            (f"{progress.best(each.name):>5}  " if progress else "")
            + f"{each.title:<{TITLE_COLUMNS}} {each.length:>7}  {each.in_hand}".rstrip(),
            each.name,
            "",
            reasons.get(each, "") + " ".join(each.briefing.split()),
        )
        for each in offered
    ]
    rows = [*lessons, *rows] if trains else [*rows, *lessons]
    advice: tuple[str, ...] = ("Up, Down, or part of a title; Enter begins, Esc leaves",)
    if progress is None:
        advice += ("Marks are kept by: trainer run --trainee NAME",)
    elif trains:
        advice += (f"Kept on this machine as {progress.trainee}; another: --trainee NAME",)
    choice = ExerciseChoice("Choose an exercise", rows, advice, size=(76, 40))
    if progress and suggestion:
        passed = sum(progress.passed(each.name) for each in offered)
        choice.title = f"{progress.trainee}: {passed} of {len(offered)} passed; next is chosen"
        choice.moved = [row.words for row in rows].index(suggestion.lesson.name)
    return choice


@dataclass
class SideThenExercise:
    """Who trains or instructs, then the list of exercises for him.

    Both are one dialog, because a second screen would lose the keys pressed while its list is read.
    """

    offer: Callable[[str], ExerciseChoice]
    side: str = ""  # once it is known
    choice: ExerciseChoice = field(default_factory=side_choice)

    def __post_init__(self) -> None:
        """Ask for the exercise alone where the side is known."""
        if self.side:
            self.choice = self.offer(self.side)

    @property
    def size(self) -> tuple[int, int]:
        """Return columns and rows, at most."""
        return self.choice.size

    def draw(self, width: int, height: int) -> Lines:
        """Return the dialog."""
        return self.choice.draw(width, height)

    def press(self, key: str, character: str | None) -> DialogOutcome | None:
        """Take a key; return how the dialog ends, None while it goes on."""
        return self._go_on(self.choice.press(key, character))

    def click(self, column: int, row: int, width: int) -> DialogOutcome | None:
        """Take a click; return how the dialog ends, None while it goes on."""
        return self._go_on(self.choice.click(column, row, width))

    def _go_on(self, done: DialogOutcome | None) -> DialogOutcome | None:
        if self.side or done is None or done == NO_OUTCOME:
            return done
        (self.side,) = done.orders
        self.choice = self.offer(self.side)
        return None


class ExerciseScreen(App[DialogOutcome], inherit_bindings=False):
    """The choice, alone on the screen."""

    CSS_PATH = "console.tcss"
    ENABLE_COMMAND_PALETTE = False
    BINDINGS: ClassVar[list[BindingType]] = []

    def __init__(self, choice: SideThenExercise) -> None:
        super().__init__()
        self._choice = choice

    def on_mount(self) -> None:
        """Show the list; the screen ends with it."""
        self.push_screen(Dialog(self._choice), self.exit)


def choose_exercise(
    offer: Callable[[str], ExerciseChoice], side: str = ""
) -> tuple[str, str] | None:
    """Ask at the terminal for a side, unless it is given, and for an exercise.

    ``offer`` makes the list for a side. Return both, "" to sail freely; None to leave.
    """
    from trainer.console.launch import forget_size  # noqa: PLC0415  not for the words alone

    forget_size()
    choice = SideThenExercise(offer, side)
    done = ExerciseScreen(choice).run()
    if done is None or done == NO_OUTCOME:
        return None
    (name,) = done.orders
    return choice.side, "" if name == FREE_SAILING else name
