"""The core's kernels as LLVM modules that call nothing outside themselves.

``library``, ``wasm`` and ``objects`` make their code of it. numba compiles the core's own kernel;
its text is linked with an entry that any C program can call, and with our own versions of the few
library functions. Nothing here may change an operation: no contraction, no reassociation, so that
the bits are the trainer's.
"""

import os
import re
import subprocess
import sys
from collections.abc import Collection, Iterable, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final, NamedTuple

import numba
import numpy as np
from llvmlite import binding  # type: ignore[import-untyped]
from numba import types

from trainer.boat.entries import NUMBER_PAIR, Entry, RecordRow
from trainer.boat.export.targets import Effort, optimise_module
from trainer.boat.platforms import Platform
from trainer.config.files import ConfigError
from trainer.core.kernel import INTERPRETED, TESTED_NUMBA, Record, is_tested

FREESTANDING_PATH: Final = Path(__file__).parent / "freestanding.ll"
# the machine that kernels are lowered for where the bytes may not depend on that which lowers: what
# it lacks is not in the text either
PLAIN_MACHINE: Final = {"NUMBA_CPU_NAME": "generic", "NUMBA_CPU_FEATURES": ""}
BOAT_TICK: Final = "trainer_tick"  # of one boat's object
SCHEME_INDEX: Final = 2  # among the arguments of a tick


class NumbaAnswer(NamedTuple):
    """How numba returns an answer by address, and how that becomes a status."""

    kind: str  # of LLVM
    status: str  # from %whole, the answer, to %said


NUMBA_ANSWERS: Final[Mapping[Any, NumbaAnswer]] = {
    int: NumbaAnswer("i64", "%said = trunc i64 %whole to i32"),
    bool: NumbaAnswer("i8", "%said = zext i8 %whole to i32"),
    float: NumbaAnswer("double", "%said = add i32 0, 0"),
    NUMBER_PAIR: NumbaAnswer("[2 x double]", "%said = add i32 0, 0"),
    None: NumbaAnswer("ptr", "%said = add i32 0, 0"),
}


def argument_types(entry: Entry) -> tuple[Any, ...]:
    """Return numba's types of what a kernel takes."""
    taken: list[Any] = []
    for kind in entry.kinds:
        if isinstance(kind, np.dtype):
            taken.append(types.Array(numba.from_dtype(kind), 1, "C"))
        elif isinstance(kind, RecordRow):
            taken.append(types.Array(numba.from_dtype(kind.dtype), 1, "C"))
        elif isinstance(kind, tuple):
            taken.append(types.Array(types.float64, len(kind), "C"))
        else:
            taken.append(types.int64 if kind is int else types.float64)
    if not entry.bundle:
        return tuple(taken)
    bundled = types.Tuple(taken[: entry.bundle])  # type: ignore[no-untyped-call]
    return (bundled, *taken[entry.bundle :])


def refuse_compiler() -> None:
    """Raise ConfigError if numba may not compile, or is of a version not tested."""
    if not is_tested(numba.__version__):
        (first, second), (_, last) = TESTED_NUMBA
        raise ConfigError(
            f"export-core: numba {numba.__version__} was not tested with it: install "
            f"'numba>={first}.{second},<{first}.{last + 1}'"
        )
    if INTERPRETED:
        raise ConfigError("export-core compiles the core: unset NUMBA_DISABLE_JIT")


def kernel_text(entry: Entry) -> tuple[str, str]:
    """Return the LLVM text of a kernel, with what it calls, and its name.

    ConfigError as for ``refuse_compiler``.
    """
    refuse_compiler()
    kernel = entry.kernel

    def call(given: Any) -> Any:  # not the kernel again, which stands in the text of others too
        return kernel(*given)

    call.__qualname__ = call.__name__ = entry.name  # so that no two texts name one function
    tuple_of: Any = types.Tuple
    whole = tuple_of(argument_types(entry))  # whose parts numba hands over one by one
    compiled: Any = numba.njit((whole,), error_model="numpy")(call)
    (known,) = compiled.signatures
    return compiled.inspect_llvm(known), compiled.overloads[known].fndesc.mangled_name


def array_words(address: str, shape: Sequence[str], size: int) -> list[str]:
    """Return the words in which numba takes an array of elements of a size [bytes]."""
    strides = [str(size)] if len(shape) == 1 else [f"%{address[1:]}_row", str(size)]
    count = shape[0] if len(shape) == 1 else f"%{address[1:]}_all"
    words = ["ptr null", "ptr null", f"i64 {count}", f"i64 {size}", f"ptr {address}"]
    return [*words, *(f"i64 {each}" for each in (*shape, *strides))]


def handed_over(entry: Entry) -> tuple[list[str], list[str]]:
    """Return the lines that prepare the words of a kernel, and those words."""
    lines, words = [], []
    sizes = {at: f"%n{i}" for i, at in enumerate(entry.sizes)}
    for at, size in sizes.items():
        lines.append(f"{size} = fptosi double %s{list(sizes).index(at)} to i64")
    for index, kind in enumerate(entry.kinds):
        if isinstance(kind, np.dtype):
            words += array_words(f"%x{index}", ["1"], kind.itemsize)
        elif isinstance(kind, RecordRow):
            words += array_words(f"%x{index}", [sizes[index, 0]], kind.dtype.itemsize)
        elif isinstance(kind, tuple):
            shape = [sizes.get((index, i), str(size)) for i, size in enumerate(kind)]
            if len(shape) == 2:
                lines.append(f"%x{index}_all = mul i64 {shape[0]}, {shape[1]}")
                lines.append(f"%x{index}_row = mul i64 8, {shape[1]}")
            words += array_words(f"%x{index}", shape, 8)
        elif kind is int:
            lines.append(f"%w{index} = fptosi double %x{index} to i64")
            words.append(f"i64 %w{index}")
        else:
            words.append(f"double %x{index}")
    return lines, words


def entry_text(entry: Entry, kernel: str, name: str, scheme: bytes | None = None) -> str:
    """Return the LLVM text of a function ``name`` through which a host calls a kernel.

    It takes addresses and numbers, then sizes, then where an answer of numbers goes, and returns
    the kernel's status, or -1 where the kernel raises. A kernel of numba's takes addresses for its
    answer and its error first. A scheme that is given is a constant of the text.
    """
    lines, words = handed_over(entry)
    taken = [
        f"{'double' if kind in (float, int) else 'ptr'} %x{i}" for i, kind in enumerate(entry.kinds)
    ]
    constant = ""
    if scheme is not None:
        del taken[SCHEME_INDEX]
        taken = [each.replace("ptr", "ptr noalias") for each in taken]
        words = [word.replace(f"%x{SCHEME_INDEX}", "@scheme") for word in words]
        size, quoted = len(scheme), quote_bytes(scheme)
        constant = f'@scheme = internal constant [{size} x i8] c"{quoted}", align 8\n'
    taken += [f"double %s{i}" for i, _ in enumerate(entry.sizes)]
    answer = NUMBA_ANSWERS[entry.answer]
    if entry.answers:
        taken.append("ptr %place")
    else:
        lines.append(f"%place = alloca {answer.kind}")
    kinds = ", ".join(word.partition(" ")[0] for word in words)
    body = "\n  ".join(lines)
    return f"""{constant}
declare i32 @"{kernel}"(ptr, ptr, {kinds})
define i32 @{name}({", ".join(taken)}) {{
  {body}
  %error = alloca ptr
  %raised = call i32 @"{kernel}"(ptr %place, ptr %error, {", ".join(words)})
  %sound = icmp eq i32 %raised, 0
  %whole = load {answer.kind}, ptr %place
  {answer.status}
  %status = select i1 %sound, i32 %said, i32 -1
  ret i32 %status
}}
"""


def quote_bytes(data: bytes) -> str:
    """Return bytes as they stand in an LLVM string."""
    return "".join(f"\\{byte:02x}" for byte in data)


def constants_text(constants: Mapping[str, bytes]) -> str:
    """Return the LLVM text of public constant blocks of bytes by their names."""
    return "\n".join(
        f'@{name} = constant [{len(data)} x i8] c"{quote_bytes(data)}", align 8'
        for name, data in constants.items()
    )


def freestanding_module(entry: Entry, scheme: Record, constants: Mapping[str, bytes]) -> Any:
    """Return the module of ``trainer_tick`` for one scheme, beside the constants.

    ``trainer_tick`` is the kernel of the addresses of all other records, and what the scheme does
    not choose falls away. Only ``trainer_tick`` and the constants can be seen from outside, so that
    the compiler may inline or drop all else.
    """
    binding.initialize_native_target()
    binding.initialize_native_asmprinter()
    text, name = kernel_text(entry)
    module = binding.parse_assembly(text)
    head = entry_text(entry, name, BOAT_TICK, np.asarray(scheme).tobytes())
    for part in (head, freestanding_text(64), constants_text(constants)):
        module.link_in(binding.parse_assembly(part))
    return seal_module(module, {BOAT_TICK, *constants})


def freestanding_text(bits: int) -> str:
    """Return the LLVM text of the library functions where pointers have so many bits."""
    return f"%size = type i{bits}\n" + FREESTANDING_PATH.read_text(encoding="utf-8")


def seal_module(module: Any, shown: Collection[str]) -> Any:
    """Return ``module`` with nothing to be seen from outside but the names ``shown``."""
    for thing in (*module.functions, *module.global_variables):
        seen = thing.is_declaration or thing.name in shown or thing.name.startswith("llvm.")
        if not seen:
            thing.linkage = "internal"
    module.verify()
    return module


def compile_for(
    target: Platform, texts: Iterable[str], shown: Collection[str], effort: Effort
) -> bytes:
    """Return one object of these texts for a platform, with the names ``shown``."""
    binding.initialize_all_targets()
    binding.initialize_all_asmprinters()
    machine = binding.Target.from_triple(target.triple).create_target_machine(
        cpu=target.cpu,
        features=target.features,
        opt=effort.level,
        reloc="pic" if target.bits == 64 else "static",
        codemodel="small",
    )
    head = f'target datalayout = "{machine.target_data}"\ntarget triple = "{target.triple}"\n'
    module = binding.parse_assembly(head + freestanding_text(target.bits))
    helpers = [FREESTANDING_PATH.with_name(name).read_text("utf-8") for name in target.helpers]
    for text in (*helpers, *texts):
        own = re.sub(r"^target .*$", "", text, flags=re.MULTILINE)
        module.link_in(binding.parse_assembly(head + own))
    seal_module(module, shown)
    optimise_module(module, machine, effort)
    return bytes(machine.emit_object(module))


def lower_in_child(
    program: str, words: Sequence[str], settings: Mapping[str, str] = MappingProxyType({})
) -> None:
    """Run a program of this package that lowers for a plain processor.

    It is a process of its own. Its bytes then do not depend on this machine, nor on the user's
    settings of numba, except that of its cache. ConfigError with what it says where it fails.
    """
    environment = {
        name: value for name, value in os.environ.items() if not name.startswith("NUMBA_")
    }
    if "NUMBA_CACHE_DIR" in os.environ:
        environment["NUMBA_CACHE_DIR"] = os.environ["NUMBA_CACHE_DIR"]
    root = str(Path(__file__).parents[3])
    environment |= {**PLAIN_MACHINE, **settings}
    environment["PYTHONPATH"] = os.pathsep.join([root, os.environ.get("PYTHONPATH", "")])
    call_program([sys.executable, "-c", program, *words], environment)


def call_program(words: Sequence[str], environment: Mapping[str, str]) -> None:
    """Call another program; ConfigError with what it says where it fails."""
    done = subprocess.run(words, env=environment, capture_output=True, text=True, check=False)  # noqa: S603
    if done.returncode != 0:
        said = (done.stderr.strip().splitlines() or ["no word"])[-1]
        raise ConfigError(f"export-core: {Path(words[0]).name} failed: {said}")
