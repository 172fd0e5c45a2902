"""The comparisons of the bench, by the options that ask for each alone."""

import contextlib
from collections.abc import Callable, Iterable, Mapping
from dataclasses import asdict, dataclass
from functools import partial
from typing import Any, Final

from c_twin import comparison
from c_twin.compiler import SAME_BITS, build

from bench import (
    class_boats,
    control,
    footprint,
    helm,
    identify,
    instructions,
    machines,
    numbers,
    on_time,
    parts,
    peers,
    session_ticks,
    waits,
    wasm,
    ways,
    web,
)
from bench import standard_hour as whole
from bench.standard_hour import SameBits, fly_hour
from trainer.boat.export.targets import NoCompilerError
from trainer.config.boat.vessel import VesselFile
from trainer.config.files import ConfigError

CLASS_BOATS: Final = 8  # where nobody says how many
SAMPLES: Final = 2000  # of the records that are fitted


@dataclass(frozen=True)
class Section:
    """One part: how it is measured, and its figures as lines of a page."""

    measure: Callable[[Any], Any]  # of a request
    lines: Callable[[Any], list[str]]


@dataclass(frozen=True)
class BenchRequest:
    """The subject of a measurement, and its length."""

    file: VesselFile
    seconds: float  # [s] of real time for each part that runs in it
    minutes: float = 0.25  # [min] of a session in a crowd
    attended: float = 60.0  # [s] of a session with pages, and of a class
    boats: int = 8  # of a class


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


def same_bits_as_c() -> SameBits:
    """Return in what bits the standard hour ends, in C too if it can be."""
    ways = whole.ways()
    with contextlib.suppress(NoCompilerError):
        ways |= {f"C, {way.name}": partial(fly_hour, build(way)) for way in SAME_BITS}
    return whole.same_bits(ways)


def parts_against(commit: str) -> Section:
    """Return the tick by its parts, and beside that of a commit."""
    return Section(lambda wanted: parts.time_parts(wanted.file, commit), parts.lines)


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
    "ways": Section(lambda wanted: ways.time_ways(wanted.file), ways.lines),
    "session": Section(
        lambda wanted: session_ticks.time_session(wanted.file, wanted.seconds), session_ticks.lines
    ),
    "on_time": Section(
        lambda wanted: on_time.time_ticks(wanted.file, wanted.seconds, wanted.minutes),
        on_time.lines,
    ),
    "helm": Section(lambda wanted: helm.time_helm(wanted.file, wanted.seconds), helm.lines),
    "against_c": or_left_out(
        NoCompilerError,
        Section(lambda wanted: comparison.against_c(wanted.file), comparison.lines),
    ),
    "beside_c": or_left_out(
        NoCompilerError,
        Section(lambda wanted: control.time_beside_c(wanted.seconds), control.lines),
    ),
    "same_bits": Section(lambda _wanted: same_bits_as_c(), whole.lines),
    "numbers": Section(lambda wanted: numbers.time_numbers(wanted.file), numbers.lines),
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
    "parts": Section(lambda wanted: parts.time_parts(wanted.file), parts.lines),
    "footprint": Section(lambda _wanted: footprint.footprint(), footprint.lines),
    "peers": Section(lambda wanted: peers.time_peers(wanted.file), peers.lines),
    "wasm": or_left_out(
        NoCompilerError, Section(lambda wanted: wasm.time_hour_in_node(wanted.file), wasm.lines)
    ),
    "machines": Section(lambda _wanted: machines.fly_on_machines(), machines.lines),
    "instructions": or_left_out(
        ConfigError, Section(lambda _wanted: instructions.measure(), instructions.lines)
    ),
    "waits": Section(lambda _wanted: waits.time_waits(), waits.lines),
    "identify": Section(lambda _wanted: identify.identify_speed(SAMPLES), identify.lines),
}
