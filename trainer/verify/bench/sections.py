"""The parts of the bench, by the options that ask for each alone."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final

from trainer.boat.export.targets import NoCompilerError
from trainer.config.vessel import VesselFile
from trainer.verify.bench import (
    end_to_end,
    exported,
    fleet,
    footprint,
    identify,
    on_time,
    peers,
    standard_hour,
    start_up,
    web,
)
from trainer.verify.c_reference import comparison

SAMPLES: Final = 2000  # of the records that are fitted


@dataclass(frozen=True)
class Wanted:
    """The subject of a measurement, and its length."""

    file: VesselFile
    seconds: float
    minutes: float  # of a session in a crowd
    attended: float  # [s] of a session with pages


@dataclass(frozen=True)
class Section:
    """One part: how it is measured, and its figures as lines of a page."""

    measure: Callable[[Wanted], Any]
    lines: Callable[[Any], list[str]]


@dataclass(frozen=True)
class LeftOut:
    """A part that cannot be measured here, and why."""

    left_out: str


def or_left_out(section: Section) -> Section:
    """Return a part that needs a compiler or a browser. Without it, it says so and is left out."""

    def measure(wanted: Wanted) -> Any:
        try:
            return section.measure(wanted)
        except (NoCompilerError, web.NoBrowserError) as error:
            return LeftOut(str(error))

    def lines(figures: Any) -> list[str]:
        return [figures.left_out] if isinstance(figures, LeftOut) else section.lines(figures)

    return Section(measure, lines)


SECTIONS: Final = {
    "against_c": or_left_out(
        Section(lambda wanted: comparison.against_c(wanted.file), comparison.lines)
    ),
    "side_by_side": Section(lambda wanted: fleet.time_side_by_side(wanted.file), fleet.lines),
    "same_bits": Section(lambda _wanted: standard_hour.same_bits(), standard_hour.lines),
    "footprint": Section(lambda _wanted: footprint.footprint(), footprint.lines),
    "peers": Section(lambda wanted: peers.time_peers(wanted.file), peers.lines),
    "exported": or_left_out(
        Section(lambda wanted: exported.time_hour_in_node(wanted.file), exported.lines)
    ),
    "on_time": Section(
        lambda wanted: on_time.time_ticks(wanted.file, wanted.seconds, wanted.minutes),
        on_time.lines,
    ),
    "latency": Section(
        lambda wanted: end_to_end.time_helm(wanted.file, wanted.seconds), end_to_end.lines
    ),
    "starting": Section(lambda _wanted: start_up.time_starts(), start_up.lines),
    "web": or_left_out(
        Section(lambda wanted: web.time_pages(wanted.file, wanted.attended), web.lines)
    ),
    "identify": Section(lambda _wanted: identify.identify_speed(SAMPLES), identify.lines),
}
