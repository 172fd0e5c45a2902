"""What an exercise comes to: code compares these, never the words.

The values stand in recordings' results, trainees' files, changes of marks, and facts on the wire.
"""

from enum import StrEnum


class Outcome(StrEnum):
    """What an exercise comes to, by its marks or by how it ended."""

    UNDECIDED = ""  # nothing decides it, or not yet
    WON = "won"
    LOST = "lost"
    NOT_REACHED = "not reached"
    FREE = "free"  # of marks: the instructor let something be automatic, or broke it by hand
    OPEN = "open"  # neither won nor lost by what could still be earned
    ENDED = "ended"  # by its time, its last step, or the instructor
    DONE = "done"  # a lesson, each of its steps
    NOT_DONE = "not done"  # a lesson to its last step, with steps that were given up
    LEFT = "left"  # before its end
