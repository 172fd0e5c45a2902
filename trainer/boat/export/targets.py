"""Processors that the core can be compiled for, and what this installation lacks for one.

There is an object for each, and a library of it where there is a system. ``library`` compiles by
it. The levels are those of x86-64, because code for a newer processor is faster, and does not start
on an older one.
"""

import os
import shlex
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, NamedTuple

from llvmlite import binding  # type: ignore[import-untyped]

from trainer.boat.platforms import CPU_TARGETS, PROCESSOR_LEVELS, Platform, flags_of, has_flag
from trainer.config.files import ConfigError
from trainer.io.orders.grammar import Refused

NATIVE_NAME: Final = "native"
REINSTALL_HINT: Final = "pip install --force-reinstall llvmlite"
# what is not in the object is in nobody's: it would be missed when the library is loaded
STRICT_FLAGS = ["-Wl,-z,defs", "-s"] if sys.platform.startswith("linux") else []


@dataclass(frozen=True)
class Processor:
    """The processor that an object is for.

    It has its name, its features, and Linux's names of those that a host must have.
    """

    name: str
    features: str
    needs: tuple[str, ...]


def find_processor(name: str) -> Processor:
    """Return the processor of that name; ConfigError where this machine cannot compile for it."""
    if name == NATIVE_NAME:
        has = binding.get_host_cpu_features()
        needs = [flag for flag in flags_of(list(PROCESSOR_LEVELS)[-1]) if has_flag(has, flag)]
        return Processor(binding.get_host_cpu_name(), has.flatten(), tuple(needs))
    if refused := lacking_compiler(name):
        raise ConfigError(f"--cpu {name}: {refused.reason}")
    return Processor(name, "", flags_of(name))


def of_this_machine(name: str) -> bool:
    """Return whether a target is a level of this machine's own kind of processor."""
    return name == NATIVE_NAME or name in PROCESSOR_LEVELS


def lacking_compiler(name: str) -> Refused | None:
    """Return why nothing compiles for a target here, and what helps; None if it does."""
    target, host = CPU_TARGETS[name], binding.get_process_triple().partition("-")[0]
    if name in PROCESSOR_LEVELS and host != "x86_64":
        return Refused(f"this machine is {host}; give --cpu {NATIVE_NAME}")
    binding.initialize_all_targets()
    try:
        binding.Target.from_triple(target.triple or binding.get_process_triple())
    except RuntimeError:
        kind = target.triple.partition("-")[0]
        return Refused(f"the compiler in llvmlite has no {kind} here; pip's has: {REINSTALL_HINT}")
    return None


def lacking_linker(target: Platform, program: str) -> Refused | None:
    """Return that a linker is not here, with its packages; None if it is."""
    lack = f"there is no {program!r} here. Debian and Ubuntu: apt install {target.packages}"
    return None if shutil.which(program) else Refused(lack)


def linking_words(target: Platform) -> list[str]:
    """Return the command that links for a target; CC names another for a library."""
    has_library = target.bits == 64  # not a board, nor WebAssembly
    return shlex.split((has_library and os.environ.get("CC")) or target.compiler)


def list_targets() -> list[str]:
    """Return a line for each target, with what this installation lacks for it."""
    rows = []
    for name, target in CPU_TARGETS.items():
        barred = lacking_compiler(name)
        lacks = barred or lacking_linker(target, linking_words(target)[0])
        here = "no" if barred else "no linker" if lacks else "yes"
        notes = filter(None, (target.purpose, lacks.reason if lacks else ""))
        rows.append(f"{name:<11}{here:<11}{'; '.join(notes)}")
    return rows


def object_code(module: Any, target: Processor) -> bytes:
    """Return ``module`` compiled for ``target``, position-independent; the module is spent.

    ConfigError where the compiler below numba is too old.
    """
    if not hasattr(binding, "create_pass_builder"):
        raise ConfigError("export-core needs llvmlite 0.45 or newer, as numba 0.62 brings it")
    machine = binding.Target.from_triple(binding.get_process_triple()).create_target_machine(
        cpu=target.name, features=target.features, opt=3, reloc="pic", codemodel="small"
    )
    optimise_module(module, machine, Effort(3))
    return bytes(machine.emit_object(module))


class Effort(NamedTuple):
    """How hard the compiler tries: its level, and whether it makes vectors, and unrolls loops."""

    level: int
    vectors: bool = False  # numba has made those that are worth it, unless it was told not to
    unrolling: bool = True


def optimise_module(module: Any, machine: Any, effort: Effort) -> None:
    """Optimise a module for a machine, and strip its names."""
    tuning = binding.create_pipeline_tuning_options(speed_level=effort.level)
    tuning.loop_vectorization = tuning.slp_vectorization = effort.vectors
    tuning.loop_unrolling = effort.unrolling
    builder = binding.create_pass_builder(machine, tuning)
    passes = builder.getModulePassManager()
    passes.add_strip_symbols_pass()
    passes.run(module, builder)


def code_words(code: bytes) -> int:
    """Return the size of an object's machine code, in words of 16 bits."""
    sections = binding.ObjectFileRef.from_data(code).sections()
    return sum(int(section.size()) for section in sections if section.is_text()) // 2


class NoCompilerError(Exception):
    """There is no C compiler, or it cannot link; the text says what would."""


def link_library(code: Path, library: Path, target: Platform) -> None:
    """Link the object ``code`` into ``library``; NoCompilerError if that cannot be done here."""
    compiler = linking_words(target)
    words = [*compiler, "-shared", "-nostdlib", *STRICT_FLAGS, "-o", str(library), str(code)]
    if refused := lacking_linker(target, compiler[0]):
        raise NoCompilerError(
            f"{library}: not made, {refused.reason} (CC names another); the object is whole: "
            f"{' '.join(words)}"
        )
    done = subprocess.run(words, capture_output=True, text=True, check=False)  # noqa: S603
    if done.returncode != 0:
        raise NoCompilerError(f"{library}: not made by {' '.join(words)}: {done.stderr.strip()}")
