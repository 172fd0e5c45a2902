"""The parts of ``trainer dev bench``, each with the option that asks for it alone.

``cli/workshop/bench`` measures the parts that are asked for.
"""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import asdict, dataclass
from typing import Any, Final

from trainer.analysis.bench import end_to_end, on_time, start_up
from trainer.config.boat.vessel import VesselFile


@dataclass(frozen=True)
class BenchRequest:
    """The subject of a measurement, and its length."""

    file: VesselFile
    seconds: float  # [s] of real time for each part that runs in it
    minutes: float = 0.25  # [min] of a session in a crowd


@dataclass(frozen=True)
class Section:
    """One part: how it is measured, and its figures as lines of a page."""

    measure: Callable[[Any], Any]  # of a request
    lines: Callable[[Any], list[str]]


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
    "on_time": Section(
        lambda wanted: on_time.time_ticks(wanted.file, wanted.seconds, wanted.minutes),
        on_time.lines,
    ),
    "latency": Section(
        lambda wanted: end_to_end.time_helm(wanted.file, wanted.seconds), end_to_end.lines
    ),
    "starting": Section(lambda _wanted: start_up.time_starts(), start_up.lines),
}
