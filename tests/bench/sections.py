"""The comparisons of the bench, by the options that ask for each alone."""

from functools import partial
from typing import Final

from c_twin import comparison
from c_twin.compiler import SAME_BITS, build

from bench import (
    control,
    footprint,
    identify,
    instructions,
    machines,
    parts,
    peers,
    waits,
    wasm,
)
from trainer.analysis.bench import standard_hour as whole
from trainer.analysis.bench.sections import Section, or_left_out
from trainer.analysis.bench.standard_hour import SameBits, fly_hour
from trainer.boat.export.targets import NoCompilerError
from trainer.config.files import ConfigError

SAMPLES: Final = 2000  # of the records that are fitted


def same_bits_as_c() -> SameBits:
    """Return in what bits the standard hour ends, in C as well; NoCompilerError without one."""
    in_c = {f"C, {way.name}": partial(fly_hour, build(way)) for way in SAME_BITS}
    return whole.same_bits(whole.ways() | in_c)


def parts_against(commit: str) -> Section:
    """Return the tick by its parts, and beside that of a commit."""
    return Section(lambda wanted: parts.time_parts(wanted.file, commit), parts.lines)


SECTIONS: Final = {
    "against_c": or_left_out(
        NoCompilerError,
        Section(lambda wanted: comparison.against_c(wanted.file), comparison.lines),
    ),
    "beside_c": or_left_out(
        NoCompilerError,
        Section(lambda wanted: control.time_beside_c(wanted.seconds), control.lines),
    ),
    "same_bits": or_left_out(
        NoCompilerError, Section(lambda _wanted: same_bits_as_c(), whole.lines)
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
