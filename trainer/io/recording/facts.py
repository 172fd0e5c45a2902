"""What a recording holds for programs, beside its words for people.

It is who gave an order, what an order meant to the crew, and why a branch was begun. The words may
be put otherwise, or in another language: nothing is decided by them.
"""

from dataclasses import dataclass
from enum import Enum
from typing import NamedTuple


class GiverKind(Enum):
    """What gives an order. The value stands in recordings."""

    STATION = "station"
    SCHEDULE = "schedule"  # of the exercise
    PLAN = "plan"  # of an instructor, whose time or condition has come
    GUARD = "guard"  # who levels a boat that would be too deep
    MEETING = "meeting"  # a helmsman who meets the swing, where it has stopped
    REFERENCE = "reference"  # the reference crew


@dataclass(frozen=True, slots=True)
class Giver:
    """Who gives an order."""

    kind: GiverKind
    role: str  # of the station; else a name of its own
    words: str
    plan: int = 0  # its number, 0 for none

    def __str__(self) -> str:
        return self.words


class CrewNews(Enum):
    """What an order said to the crew, or of it. The value stands in recordings."""

    NOTHING = ""
    ORDERED = "ordered"
    REPEATED = "repeated"
    WRONG_REPEAT = "wrong-repeat"


class CrewFact(NamedTuple):
    """What an order said to the crew, and of which order to it."""

    news: CrewNews = CrewNews.NOTHING
    order: str = ""  # as the crew is told it


class BranchCause(Enum):
    """Why a branch was begun. The value stands in recordings."""

    START = "start"
    JUMP = "jump"  # somebody wound back, or took over
    GAP = "gap"  # the recording was out of reach


NO_CREW_FACT = CrewFact()
SCHEDULE_GIVER = Giver(GiverKind.SCHEDULE, "schedule", "schedule")
GUARD_GIVER = Giver(GiverKind.GUARD, "guard", "guard")
REFERENCE_GIVER = Giver(GiverKind.REFERENCE, "reference crew", "reference crew")


def station(role: str, line: str) -> Giver:
    """Return who gives an order at a line."""
    return Giver(GiverKind.STATION, role, f"{role} at {line}")


def plan_of(role: str, number: int) -> Giver:
    """Return who gives an order that was planned by somebody of a role."""
    return Giver(GiverKind.PLAN, role, f"{role} at plan {number}", number)


def meeting(role: str) -> Giver:
    """Return who has the rudder amidships once the swing is met."""
    return Giver(GiverKind.MEETING, role, f"{role} meeting her")
