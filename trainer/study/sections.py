"""The parts of the bench that are measured by themselves, by the option that asks for them."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final

from trainer.files.vessel_file import VesselFile
from trainer.study import end_to_end, on_time, starting


@dataclass(frozen=True)
class Wanted:
    """What is to be measured, and for how long."""

    file: VesselFile
    seconds: float
    minutes: float  # of a session in a crowd


@dataclass(frozen=True)
class Section:
    """One part: how it is measured, and its figures as lines of a page."""

    measure: Callable[[Wanted], Any]
    lines: Callable[[Any], list[str]]


SECTIONS: Final = {
    "on_time": Section(
        lambda wanted: on_time.time_ticks(wanted.file, wanted.seconds, wanted.minutes),
        on_time.lines,
    ),
    "latency": Section(
        lambda wanted: end_to_end.time_helm(wanted.file, wanted.seconds), end_to_end.lines
    ),
    "starting": Section(lambda _wanted: starting.time_starts(), starting.lines),
}
