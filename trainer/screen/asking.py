"""Questions before what cannot be undone."""

from dataclasses import dataclass

from trainer.screen.choice import NOTHING, Done
from trainer.screen.ink import Lines, fit, line


@dataclass
class Question:
    """A question, and the answers by their keys."""

    asks: str
    answers: dict[str, tuple[str, Done]]  # key: what it does in words, and how the dialog ends
    size: tuple[int, int] = (60, 7)

    def press(self, key: str, _character: str | None) -> Done | None:
        """Take a key; return how the dialog ends, None while it goes on."""
        if key in ("escape", "n"):
            return NOTHING
        return self.answers[key][1] if key in self.answers else None

    def draw(self, width: int, height: int) -> Lines:
        """Return the dialog."""
        lines = [line((f" {self.asks}", "title")), line()]
        for key, (says, _) in self.answers.items():
            lines.append(line((f"   {key.upper():<5}", "value"), says))
        lines.append(line(("   Esc  ", "value"), "neither"))
        return [fit(each, width) for each in lines[:height]]


def leaving(*, own: bool) -> Question:
    """Return the question whether the instructor ends the run or only leaves it."""
    end = ("end the run: its recording is complete", Done(("quit",)))
    goes = "leave; it ends unless others are attached" if own else "leave; the session goes on"
    return Question("Leave?", {"q": end, "l": (goes, Done(leave=True))})


def emergency() -> Question:
    """Return the question before all main ballast is blown."""
    blow = ("blow all main ballast from both banks", Done(("emergency blow",)))
    return Question("Emergency blow?", {"e": blow})
