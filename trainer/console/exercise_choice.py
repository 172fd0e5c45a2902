"""The choice before a session: sail freely, or one of the exercises."""

import textwrap
from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, Final

from textual.app import App
from textual.binding import BindingType

from trainer.config.course import Lesson
from trainer.console.dialogs import HEAD_ROWS, NO_OUTCOME, Choice, ChoiceRow, Dialog, DialogOutcome
from trainer.console.pane import Lines, fit, line

FREE_SAILING: Final = "Sail freely"
BRIEFING_ROWS: Final = 4  # [rows] of what is chosen
NO_TITLE: Final = "No title has these letters. Backspace deletes the last letter."


@dataclass
class ExerciseChoice(Choice):
    """The list of exercises by their titles, with the briefing of the chosen one.

    File names are not shown, because they tell what will go wrong.
    """

    def draw(self, width: int, height: int) -> Lines:
        """Return the dialog."""
        shown = self.shown
        place = min(self.place, max(len(shown) - 1, 0))
        room = max(height - HEAD_ROWS - BRIEFING_ROWS - 2, 1)
        first = min(max(place - room // 2, 0), max(len(shown) - room, 0))
        self._first, self._rows = first, room
        rows = [
            line((f" {'>' if first + i == place else ' '} {row.name}", "plain"))
            if first + i != place
            else line((f" > {row.name:<{max(width - 4, 0)}} ", "chosen"))
            for i, row in enumerate(shown[first : first + room])
        ]
        rows += [line()] * (room - len(rows))
        says = self.chosen.says if self.chosen else NO_TITLE
        briefing = textwrap.wrap(says, max(width - 4, 8))
        below = [line((f"   {text}", "ordered")) for text in briefing[:BRIEFING_ROWS]]
        below += [line()] * (BRIEFING_ROWS - len(below))
        lines = [
            line((f" {self.title}", "title")),
            line((" > ", "dim"), (self.typed, "value"), ("_", "dim")),
            *rows,
            line(),
            *below,
            *(line((f" {text}", "dim")) for text in self.advice),
        ]
        return [fit(each, width) for each in lines[:height]]


def exercise_choice(offered: Sequence[Lesson]) -> ExerciseChoice:
    """Return the list: sailing freely comes first, so that Enter alone sails."""
    rows = [
        ChoiceRow(
            FREE_SAILING, FREE_SAILING, "", "No exercise: go to sea at once and do as you like."
        )
    ]
    rows += [
        ChoiceRow(each.title, each.name, "", " ".join(each.briefing.split())) for each in offered
    ]
    advice = ("Press Up or Down, or type part of a title; Enter begins, Esc leaves",)
    return ExerciseChoice("Choose an exercise", rows, advice, size=(76, 40))


class ExerciseScreen(App[DialogOutcome], inherit_bindings=False):
    """The choice, alone on the screen."""

    CSS_PATH = "console.tcss"
    ENABLE_COMMAND_PALETTE = False
    BINDINGS: ClassVar[list[BindingType]] = []

    def __init__(self, choice: ExerciseChoice) -> None:
        super().__init__()
        self._choice = choice

    def on_mount(self) -> None:
        """Show the list; the screen ends with it."""
        self.push_screen(Dialog(self._choice), self.exit)


def choose_exercise(offered: Sequence[Lesson]) -> str | None:
    """Ask at the terminal. Return the name of an exercise, "" to sail freely, None to leave."""
    from trainer.console.launch import forget_size  # noqa: PLC0415  not for the words alone

    forget_size()
    done = ExerciseScreen(exercise_choice(offered)).run()
    if done is None or done == NO_OUTCOME:
        return None
    (name,) = done.orders
    return "" if name == FREE_SAILING else name
