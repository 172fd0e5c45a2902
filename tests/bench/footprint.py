"""The size of the tick's machine code in 16-bit words, beside that of 1969.

It is compiled for size in processes of their own: every kernel once, then the compiler's choice of
what to join; the shorter of two orders of the instructions counts. The report's trigonometry is
used, as in 1969.

What the machine code of 1969 did, put together from the core's kernels: for counting its words.

The program UPDATE of 1969 was one cycle of the modified set: forces, accelerations, attitude,
integration. The whole tick had autopilot, control surfaces, propulsion, tanks and the sea's noise
besides. Neither had casualties, orders by hand, air, pumps, holds or the surface. The wide set,
which 1969 had not either, is counted by itself.
"""

import json
import math
import re
import subprocess
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Final

from helpers.places import tests_environment
from helpers.tables_1969 import CORE_WORDS
from llvmlite import binding  # type: ignore[import-untyped]

from trainer.boat.entries import BOAT_RECORDS, Entry
from trainer.boat.export.targets import find_processor
from trainer.config.files import ConfigError
from trainer.core import wide
from trainer.core.actuators import advance_surface
from trainer.core.autopilot.course import course_law
from trainer.core.autopilot.depth import depth_error, plane_law
from trainer.core.autopilot.reference import COURSE_AXIS, DEPTH_AXIS, move_reference
from trainer.core.autopilot.speed import follow_trim, learnt
from trainer.core.autopilot.steering import (
    BOW,
    RUDDER,
    first_gain,
    scheduled_gains,
    steer,
)
from trainer.core.ballast.ballast import balance
from trainer.core.compact import forces, lagged_rates
from trainer.core.elementary import cosine_and_sine
from trainer.core.integrators import adams
from trainer.core.kernel import kernel
from trainer.core.kinematics import attitude_of, kinematics
from trainer.core.noise import SEA_FILTER, gaussian
from trainer.core.sea.filter_1969 import filter_noise
from trainer.core.state import STATE
from trainer.core.terms import EXTRA_TERMS
from trainer.core.vessel import COMPACT, COURSE_INTEGRAL_GAIN, INTEGRAL_GAIN

CPUS: Final = ("x86-64-v3", "x86-64-v4")
WORDS_1969: Final = {  # [16-bit words] of its Table 16
    "update": CORE_WORDS["UPDATE"],
    "tick": sum(CORE_WORDS.values()),
}
MEMORY: Final = 4096  # [16-bit words] for a tick with its constants and its state
VESSEL: Final = "bb2"
ORDERS: Final = ("source", "list-burr")  # of the instructions: as written, for few registers
CALLED: Final = re.compile(r"call [^\n]*@(?:llvm\.)?mem(?:set|cpy)\b")
HELD: Final = re.compile(r"^@llvm\.compiler\.used = .*\n", re.MULTILINE)  # memset, memcpy
DEFINED: Final = re.compile(r"^(define [^\n]*?) \{$", re.MULTILINE)
LATER: Final = {  # what the state holds besides, from one number of it to another
    "air, pumps and their faults": ("tank_air", "vent_fault"),
    "casualties and holds": ("casualty", "sailed"),
    "the wide set": ("last_turn", "validity"),
    "the wave filter": ("sea_modes", "push_number"),
    "waves, ascent, hovering and trim": ("wave_slow", "trim_forward"),
}
WIDE: Final = "wide"  # the program that 1969 had not
ELEMENTARY: Final = "elementary"  # square root, sine and cosine, which are within the others
OWN_TO_PROCESSORS: Final = "floating point", "data transfer"  # no programs any more
CHILD: Final = """
import json, sys
from llvmlite import binding
binding.set_option("", "--pre-RA-sched=" + sys.argv[1])
from trainer.core import kernel
kernel.part = kernel.kernel = kernel.compiled_with(error_model="numpy", **kernel.LEAN_OPTIONS)
from bench import footprint
ticks = {"update": footprint.update_of_1969, "tick": footprint.tick_of_1969}
ticks[footprint.WIDE] = footprint.wide_of_today
ticks[footprint.ELEMENTARY] = footprint.elementary_of_1969
print(json.dumps({name: footprint.sections(tick) for name, tick in ticks.items()}))
"""


@dataclass(frozen=True)
class Code:
    """The size of one program on one processor, in words of 16 bits."""

    program: str
    cpu: str
    code_words: int
    constant_words: int
    code_words_1969: int | None  # None: it had no such program


@dataclass(frozen=True)
class Footprint:
    """The size of the tick."""

    codes: tuple[Code, ...]
    state_words: int  # of what 1969 had
    later_state_words: dict[str, int]  # by what it is of
    compact_words: int  # without the terms that 1969 had not
    least_whole_words: int  # a tick's code and constants, the compact record and the state
    whole_words_wanted: int


def sections(function: Callable[..., int]) -> dict[str, tuple[int, int]]:
    """Return by processor how many bytes of code and of constants ``function`` takes."""
    from trainer.boat.assemble import Method, fit_out  # noqa: PLC0415
    from trainer.boat.export.lowering import freestanding_module  # noqa: PLC0415  kernels are settled
    from trainer.config.boat.vessel import load_vessel  # noqa: PLC0415

    method = Method("modified", "lagged", "report", "adams2", 0.5)
    scheme = fit_out(load_vessel(VESSEL), method).scheme
    module = freestanding_module(Entry(function, BOAT_RECORDS, int), scheme, {})
    return {cpu: sizes(small_object(str(module), cpu)) for cpu in CPUS}


def small_object(text: str, cpu: str) -> bytes:
    """Return LLVM text compiled for size."""
    target = find_processor(cpu)
    machine = binding.Target.from_triple(binding.get_process_triple()).create_target_machine(
        cpu=target.name, features=target.features, opt=2, reloc="pic", codemodel="small"
    )
    tuning = binding.create_pipeline_tuning_options(speed_level=2)
    tuning.size_level = 1
    tuning.loop_vectorization = tuning.slp_vectorization = tuning.loop_unrolling = False
    builder = binding.create_pass_builder(machine, tuning)
    module = binding.parse_assembly(text)
    builder.getModulePassManager().run(module, builder)
    return bytes(machine.emit_object(strip(str(module), builder)))


def strip(text: str, builder: Any) -> Any:
    """Return the module of optimised LLVM text, marked as small, without what nothing calls."""
    if not CALLED.search(text):
        text = HELD.sub("", text)
    module = binding.parse_assembly(DEFINED.sub(r"\1 optsize {", text))
    passes = binding.create_new_module_pass_manager()
    passes.add_global_dead_code_eliminate_pass()
    passes.run(module, builder)
    return module


def sizes(code: bytes) -> tuple[int, int]:
    """Return the bytes of an object's code and of its constants."""
    whole = binding.ObjectFileRef.from_data(code)
    texts = constants = 0
    for part in whole.sections():  # each is gone when the next comes
        size = int(part.size())
        texts += size * bool(part.is_text())
        constants += size * (part.name() or b"").startswith(b".rodata")
    return texts, constants


def footprint() -> Footprint:
    """Return what the tick takes on processors of today; ConfigError if it cannot be compiled."""
    compiled = [compile_in_order(order) for order in ORDERS]
    codes = tuple(
        Code(name, cpu, *min(found[name][cpu] for found in compiled), WORDS_1969.get(name))
        for name, by_cpu in compiled[0].items()
        for cpu in by_cpu
    )
    later = {name: words_of(*ends) for name, ends in LATER.items()}
    state = STATE.itemsize // 2 - sum(later.values())
    compact = COMPACT.itemsize // 2 - 4 * len(EXTRA_TERMS)
    ticks = [code.code_words + code.constant_words for code in codes if code.program == "tick"]
    return Footprint(codes, state, later, compact, min(ticks) + compact + state, MEMORY)


def words_of(first: str, last: str) -> int:
    """Return the 16-bit words of the state from one of its numbers to another."""
    places: Mapping[str, Any] = STATE.fields or {}
    begin, end = int(places[first][1]), int(places[last][1]) + STATE[last].itemsize
    return (end - begin) // 2


def compile_in_order(order: str) -> dict[str, dict[str, tuple[int, int]]]:
    """Return the words of code and constants, by program and processor, in one order.

    It is one of ORDERS.
    """
    environment = tests_environment(NUMBA_OPT="0", NUMBA_DISABLE_JIT="0")
    words = [sys.executable, "-W", "ignore", "-c", CHILD, order]
    done = subprocess.run(words, env=environment, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise ConfigError(f"the tick was not compiled for size: {done.stderr.strip()}")
    return {
        name: {cpu: (code // 2, constants // 2) for cpu, (code, constants) in by_cpu.items()}
        for name, by_cpu in json.loads(done.stdout).items()
    }


def lines(figures: Footprint) -> list[str]:
    """Return the figures as lines of a page."""
    of_1969 = [code for code in figures.codes if code.program in WORDS_1969]
    later = [code for code in figures.codes if code.program == WIDE]
    functions = [code.code_words for code in figures.codes if code.program == ELEMENTARY]
    half = f"half the memory of 1969: {figures.whole_words_wanted}"
    return [
        "",
        "FOOTPRINT ([16-bit words], compiled for size; modified set, the report's trigonometry)",
        f"  {'program':<8}{'processor':<12}{'code':>8}{'constants':>11}{'1969':>8}{'times':>8}",
        *(_row(code) for code in of_1969),
        _part("SQRT and SIN/COS", min(functions, default=0)),
        *(_part(name, 0) for name in OWN_TO_PROCESSORS),
        _part("COMMON", figures.state_words + figures.compact_words),
        f"    SQRT and SIN/COS are within the programs; COMMON is state {figures.state_words} and",
        f"    constants of the boat {figures.compact_words}, at four words a number (1969: two)",
        f"  the tick with all of it {figures.least_whole_words}; {half}",
        "  besides, what 1969 had not; wide: the motion beyond the range of its coefficients",
        *(_row(code) for code in later),
        *(f"  state, {what} {words}" for what, words in figures.later_state_words.items()),
    ]


def _part(name: str, words: int) -> str:
    """Return a part of the program of 1969 as a row of the table, with our words of it."""
    return f"  {name:<20}{words:>8}{'':>11}{CORE_WORDS[name]:>8}"


def _row(code: Code) -> str:
    """Return a program as a row of the table."""
    row = f"  {code.program:<8}{code.cpu:<12}{code.code_words:>8}{code.constant_words:>11}"
    if code.code_words_1969 is None:
        return row
    return f"{row}{code.code_words_1969:>8}{code.code_words / code.code_words_1969:>8.2f}"


@kernel
def update_of_1969(boat: Any, few: Any, how: Any, now: Any, work: Any) -> int:  # noqa: ARG001 as all
    """Advance the motion of these records by one cycle, controls held; return 0."""
    attitude = attitude_of(how[0].trig, now)
    forces(few, attitude, now, work[0].force)
    lagged_rates(few, work[0].force, now)
    kinematics(attitude, now)
    adams(how, now)
    return 0


@kernel
def tick_of_1969(boat: Any, few: Any, how: Any, now: Any, work: Any) -> int:
    """Advance boat, autopilot, surfaces, propeller, tanks and noise by one cycle; return 0."""
    c, s, gains, h = boat[0], now[0], work[0].gains, how[0].h
    filter_noise(work, gaussian(int(s.seed), SEA_FILTER, int(s.tick)), now)
    scheduled_gains(boat, s.u, gains)
    for axis in range(COURSE_AXIS + 1):
        here = s.z if axis == DEPTH_AXIS else s.psi
        move_reference(axis, here, h, gains, now)
    for surface in range(BOW + 1):
        if surface == RUDDER:
            law = course_law(now, gains)
            step = h * gains[COURSE_INTEGRAL_GAIN] * (s.psi_reference - s.psi)
        else:
            first = first_gain(surface)
            law = plane_law(now, gains, first)
            step = h * gains[first + INTEGRAL_GAIN] * depth_error(gains, now)
        steer(boat, now, surface, law, step)
    follow_trim(boat, h, now)
    s.speed_trim = learnt(boat, h, now)
    s.command_u_c = s.ordered_speed + s.speed_trim
    balance(boat, now)
    attitude = attitude_of(how[0].trig, now)
    forces(few, attitude, now, work[0].force)
    lagged_rates(few, work[0].force, now)
    kinematics(attitude, now)
    adams(how, now)
    for i in range(3):
        s.surface[i] = advance_surface(
            s.surface[i], s.command[i], c.limit[i], c.surface_rate * h, 1.0
        )
    s.u_c += h / c.propulsion_lag * (s.command_u_c - s.u_c)
    s.tick += 1.0
    return 0


@kernel
def elementary_of_1969(boat: Any, few: Any, how: Any, now: Any, work: Any) -> int:  # noqa: ARG001 as all
    """Write a square root, a sine and a cosine; return 0."""
    s = now[0]
    s.zdot = math.sqrt(s.u)
    s.xdot, s.ydot = cosine_and_sine(s.psi)
    return 0


@kernel
def wide_of_today(boat: Any, few: Any, how: Any, now: Any, work: Any) -> int:  # noqa: ARG001 as all
    """Correct the accelerations of these records by the wide set; return 0."""
    wide.correct(boat, how[0].equations, now, work, work[0].external)
    return 0
