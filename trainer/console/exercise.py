"""A screen's exercise: its task, a lesson's step, its end and its marks."""

import contextlib
from dataclasses import dataclass, field
from typing import Final, NamedTuple

from trainer.config.exercise.outcome import Outcome

REPEATED_KEYS: Final = ("line", "wins", "lost")  # keys of an exercise that come again and again


def marks_in_words(fields: str) -> str:
    """Return outcome and total in words, as the session announced them."""
    outcome, total, *aids = (*fields.split(","), "")[: max(fields.count(",") + 1, 2)]
    with contextlib.suppress(ValueError):
        total = f"{float(total):.0f} marks of 100"
    told = (outcome, total or "no marks", *(f"with {aid}" for aid in aids))
    return ", ".join(filter(None, told))


class LessonStep(NamedTuple):
    """A step of a lesson. Without a text it is none."""

    number: str = ""
    steps: str = ""  # how many there are
    instrument: str = ""  # to look at
    text: str = ""
    hint: str = ""


NO_STEP: Final = LessonStep()
LESSON_END: Final = LessonStep("0")  # told after the last step


@dataclass
class Exercise:
    """What is to be done, how it ended, and what it was worth."""

    values: dict[str, str] = field(default_factory=dict)  # by key
    lists: dict[str, list[str]] = field(default_factory=dict)  # of the repeated keys
    briefing: list[str] = field(default_factory=list)
    step: LessonStep = NO_STEP
    undone: tuple[str, ...] = ()  # numbers of the steps of a lesson that is over
    following: str = ""  # name of what comes after that lesson
    outcome: str = ""  # of an exercise that is over
    over_at: float = 0.0  # [s]
    endings: int = 0  # of exercises
    marks: list[str] = field(default_factory=list)  # in words, and their reasons
    wrong_at: float | None = None  # [s] of the reason that cost most
    releases: int = 0  # of marks to the crew
    debriefing: str = ""  # how much of a debrief is written, while it is
    page: str = ""  # the file of the debrief, once it is written
    rings: int = 0  # how often a bell has been due
    _old_lines: int = 0  # of the briefing that came before the line was lost last

    @property
    def by_hand(self) -> list[str]:
        """Return what is worked by hand."""
        return list(filter(None, self.values.get("hand", "").split(",")))

    def left_at(self, seconds: float) -> float | None:
        """Return how much is left [s] at a time, None where there is no end."""
        try:
            return max(float(self.values["duration"]) - seconds, 0.0)
        except (KeyError, ValueError):
            return None

    def take_value(self, _seconds: float, subject: str) -> None:
        """Take a key and its value."""
        key, equals, value = subject.partition("=")
        if equals and key in REPEATED_KEYS:
            lines = self.lists.setdefault(key, [])
            lines.extend([value] if value not in lines else [])
        elif equals:
            self.values[key] = value

    def take_step(self, _seconds: float, subject: str) -> None:
        """Take a step of a lesson."""
        self.step = LessonStep(*subject.split(",", 3))
        self.rings += 1

    def take_hint(self, _seconds: float, hint: str) -> None:
        """Take what helps with the present step."""
        self.step = self.step._replace(hint=hint)
        self.rings += 1

    def take_undone(self, _seconds: float, subject: str) -> None:
        """Take the steps that were not done, after the name of what follows."""
        self.following, *undone = subject.split(",")
        self.undone = tuple(undone)

    def take_end(self, seconds: float, outcome: str) -> None:
        """Take the end, unless it is sent again because the line was lost meanwhile."""
        if not self.outcome:
            self.outcome, self.over_at = outcome or Outcome.ENDED, seconds
            self.marks.clear()
            self.endings += 1
            self.rings += 1

    def take_marks(self, _seconds: float, subject: str) -> None:
        """Take the marks, before their reasons."""
        self.marks, self.wrong_at = [marks_in_words(subject)], None

    def take_reason(self, _seconds: float, subject: str) -> None:
        """Take a reason of the marks, after the time [s] that it is about."""
        time_text, _, reason = subject.partition(",")
        if time_text and self.wrong_at is None:
            self.wrong_at = float(time_text)
        self.marks += [reason] if reason not in self.marks else []

    def take_debriefing(self, _seconds: float, share: str) -> None:
        """Take how much of a debrief is written."""
        self.debriefing = f"{float(share):.0%}" if share else ""

    def take_page(self, _seconds: float, file: str) -> None:
        """Take the file of a debrief that is written."""
        self.page = file

    def go_on(self) -> None:
        """Forget the end, because the exercise or another one is flown now."""
        self.outcome, self.over_at = "", 0.0
        self.undone, self.following, self.page = (), "", ""
        self.marks.clear()

    def lose_line(self) -> None:
        """Expect briefing and repeated keys anew, because the line is lost."""
        self.lists.clear()
        self._old_lines = len(self.briefing)

    def forget(self) -> None:
        """Forget all but the file's name, which comes before the other facts."""
        self.values = {key: value for key, value in self.values.items() if key == "name"}
        self.lists.clear()
        self.step = NO_STEP
        del self.briefing[: self._old_lines]
        self.go_on()
