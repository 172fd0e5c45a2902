"""The facts of a recording that programs decide on, beside its words for people.

``recording`` stores them; debriefs and sessions read them. They are who gave an order, what it
meant to the crew, and why a branch was begun. No program reads the words, because they may be
reworded or translated.
"""

from dataclasses import dataclass
from enum import Enum
from typing import NamedTuple


class GiverKind(Enum):
    """The kinds of order givers. The values stand in recordings."""

    STATION = "station"
    SCHEDULE = "schedule"  # of the exercise
    PLAN = "plan"  # of an instructor, whose time or condition has come
    GUARD = "guard"  # who levels a boat that would be too deep
    MEETING = "meeting"  # a helmsman who meets the swing, where it has stopped
    REFERENCE = "reference"  # the reference crew


@dataclass(frozen=True, slots=True)
class Giver:
    """The giver of an order."""

    kind: GiverKind
    role: str  # of the station; else a name of its own
    words: str
    plan: int = 0  # its number, 0 for none

    def __str__(self) -> str:
        return self.words


class CrewNews(Enum):
    """The news of an order for the crew, or of it. The values stand in recordings."""

    NOTHING = ""
    ORDERED = "ordered"
    REPEATED = "repeated"
    WRONG_REPEAT = "wrong-repeat"


class CrewFact(NamedTuple):
    """The news of an order for the crew, and the crew order concerned."""

    news: CrewNews = CrewNews.NOTHING
    order: str = ""  # the order in words, as the crew reads it


class BranchCause(Enum):
    """The causes of a new branch. The values stand in recordings."""

    START = "start"
    JUMP = "jump"  # somebody wound back, or took over
    GAP = "gap"  # the recording was out of reach
    SHOWN = "shown"  # the reference crew shows the way: no run of the crew's


NOTE_KIND = "alert-note"  # of events that programs alone read: what became of an alert
OVER_WORDS = "EXERCISE OVER: "  # begin the event of an exercise's end
NO_CREW_FACT = CrewFact()
SCHEDULE_GIVER = Giver(GiverKind.SCHEDULE, "schedule", "schedule")
GUARD_GIVER = Giver(GiverKind.GUARD, "guard", "guard")
REFERENCE_GIVER = Giver(GiverKind.REFERENCE, "reference crew", "reference crew")


def station(role: str, line: str) -> Giver:
    """Return the giver of an order that came by a line."""
    return Giver(GiverKind.STATION, role, f"{role} at {line}")


def plan_of(role: str, number: int) -> Giver:
    """Return the giver of a planned order, with the role of the planner."""
    return Giver(GiverKind.PLAN, role, f"{role} at plan {number}", number)


def meeting(role: str) -> Giver:
    """Return the giver of the order amidships that ends an order to meet the swing."""
    return Giver(GiverKind.MEETING, role, f"{role} meeting her")
