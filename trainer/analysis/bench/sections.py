"""The parts of ``trainer dev bench``, each with the option that asks for it alone.

``cli/workshop/bench`` measures the parts that are asked for. A part that this machine lacks
something for (such as Chromium) is left out with the reason, because the others are still worth
having.
"""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import asdict, dataclass
from typing import Any, Final

from trainer.analysis.bench import (
    class_boats,
    end_to_end,
    numbers,
    on_time,
    standard_hour,
    start_up,
    web,
)
from trainer.config.vessel import VesselFile


@dataclass(frozen=True)
class BenchRequest:
    """The subject of a measurement, and its length."""

    file: VesselFile
    seconds: float  # [s] of real time for each part that runs in it
    minutes: float = 0.25  # [min] of a session in a crowd
    attended: float = 60.0  # [s] of a session with pages, and of a class
    boats: int = 8  # of a class


@dataclass(frozen=True)
class Section:
    """One part: how it is measured, and its figures as lines of a page."""

    measure: Callable[[BenchRequest], Any]
    lines: Callable[[Any], list[str]]


@dataclass(frozen=True)
class OmittedSection:
    """A part that cannot be measured here, and why."""

    left_out: str


def or_left_out(lacking: type[Exception], section: Section) -> Section:
    """Return a section that becomes an ``OmittedSection`` where ``lacking`` is raised."""

    def measure(wanted: BenchRequest) -> Any:
        try:
            return section.measure(wanted)
        except lacking as error:
            return OmittedSection(str(error))

    def lines(figures: Any) -> list[str]:
        return [figures.left_out] if isinstance(figures, OmittedSection) else section.lines(figures)

    return Section(measure, lines)


def measure_sections(
    sections: Mapping[str, Section], names: Iterable[str], wanted: BenchRequest
) -> tuple[dict[str, Any], list[str]]:
    """Return the figures of parts as a tree by name, and their pages."""
    figures, pages = {}, []
    for name in names:
        measured = sections[name].measure(wanted)
        figures[name] = asdict(measured)
        pages.append("\n".join(sections[name].lines(measured)).strip())
    return figures, pages


SECTIONS: Final = {
    "same_bits": Section(
        lambda _wanted: standard_hour.same_bits(standard_hour.ways()), standard_hour.lines
    ),
    "on_time": Section(
        lambda wanted: on_time.time_ticks(wanted.file, wanted.seconds, wanted.minutes),
        on_time.lines,
    ),
    "latency": Section(
        lambda wanted: end_to_end.time_helm(wanted.file, wanted.seconds), end_to_end.lines
    ),
    "numbers": Section(lambda wanted: numbers.time_numbers(wanted.file), numbers.lines),
    "starting": Section(lambda _wanted: start_up.time_starts(), start_up.lines),
    "web": or_left_out(
        web.NoBrowserError,
        Section(lambda wanted: web.time_pages(wanted.file, wanted.attended), web.lines),
    ),
    "class": or_left_out(
        class_boats.NoProcessFiguresError,
        Section(
            lambda wanted: class_boats.time_class(wanted.boats, wanted.attended), class_boats.lines
        ),
    ),
}
