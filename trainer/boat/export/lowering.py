"""The core's kernels as LLVM modules that call nothing outside themselves.

``library``, ``wasm`` and ``objects`` make their code of it. numba compiles the core's own kernel;
its text is linked with an entry that any C program can call, and with our own versions of the few
library functions. Nothing here may change an operation: no contraction, no reassociation, so that
the bits are the trainer's.
"""

import os
import subprocess
import sys
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import Any, Final

import numba
import numpy as np
from llvmlite import binding  # type: ignore[import-untyped]
from numba import carray, types  # type: ignore[attr-defined]

from trainer.boat.entries import Entry
from trainer.config.files import ConfigError
from trainer.core.kernel import INTERPRETED, TESTED_NUMBA, Record, is_tested

FREESTANDING_PATH: Final = Path(__file__).parent / "freestanding.ll"
# the machine that kernels are lowered for where the bytes may not depend on that which lowers: what
# it lacks is not in the text either
PLAIN_MACHINE: Final = {"NUMBA_CPU_NAME": "generic", "NUMBA_CPU_FEATURES": ""}
SCHEME_PLACE: Final = 2  # of the arguments of a tick


def adapter_source(entry: Entry) -> str:
    """Return the source of a function that calls a kernel with addresses and numbers."""
    sizes = {at: f"n{i}" for i, at in enumerate(entry.sizes)}
    given = []
    for place, kind in enumerate(entry.kinds):
        if kind is float:
            given.append(f"x{place}")
        elif kind is int:
            given.append(f"int(x{place})")
        elif isinstance(kind, tuple):
            shape = (sizes.get((place, i), str(size)) for i, size in enumerate(kind))
            given.append(f"carray(x{place}, ({' '.join(f'int({size}),' for size in shape)}))")
        else:
            given.append(f"carray(x{place}, 1)")
    taken = [f"x{place}" for place in range(len(entry.kinds))] + list(sizes.values())
    call = f"kernel({', '.join(given)})"
    if entry.answers:
        taken.append("answer")
        body = [f"row = carray(answer, {entry.answers})"]
        body.append(", ".join(f"row[{i}]" for i in range(entry.answers)) + f" = {call}")
        body.append("return 0")
    else:
        body = [f"return int({call})"] if entry.answer else [call, "return 0"]
    return "\n    ".join([f"def adapter({', '.join(taken)}):", *body])


def parameter_types(entry: Entry) -> list[Any]:
    """Return numba's types of what the adapter of a kernel takes."""
    number: Any = types.float64
    pointer: Any = types.CPointer
    taken: list[Any] = []
    for kind in entry.kinds:
        if isinstance(kind, np.dtype):
            taken.append(pointer(numba.from_dtype(kind)))
        else:
            taken.append(pointer(number) if isinstance(kind, tuple) else number)
    taken += [number for _ in entry.sizes]
    return taken + [pointer(number)] * bool(entry.answers)


def refuse_compiler() -> None:
    """Raise ConfigError if numba is told not to compile, or is of a version not tested."""
    if not is_tested(numba.__version__):
        (first, second), (_, last) = TESTED_NUMBA
        raise ConfigError(
            f"export-core: numba {numba.__version__} was not tested with it: install "
            f"'numba>={first}.{second},<{first}.{last + 1}'"
        )
    if INTERPRETED:
        raise ConfigError("export-core compiles the core: unset NUMBA_DISABLE_JIT")


def kernel_text(entry: Entry) -> tuple[str, str]:
    """Return the LLVM text of a kernel behind its adapter, and the name of that function.

    ConfigError as for ``refuse_compiler``.
    """
    refuse_compiler()
    known: dict[str, Any] = {"kernel": entry.kernel, "carray": carray}
    exec(adapter_source(entry), known)  # noqa: S102  numba takes no other form of it
    adapter = known["adapter"]
    adapter.__qualname__ = adapter.__name__ = entry.name  # so that no two texts name one function
    compiled: Any = numba.njit(types.int64(*parameter_types(entry)), error_model="numpy")(adapter)
    signature = compiled.signatures[0]
    name = compiled.overloads[signature].fndesc.mangled_name
    return compiled.inspect_llvm(signature), name


def entry_text(entry: Entry, kernel: str, name: str, scheme: bytes | None = None) -> str:
    """Return the LLVM text of a function ``name`` through which a host calls a kernel.

    A kernel of numba's takes places for its answer and its error besides its arguments. The
    function answers -1 where the kernel raises. A scheme that is given is a constant of the text.
    """
    kinds = ["double" if each is types.float64 else "ptr" for each in parameter_types(entry)]
    words = [f"{kind} %x{i}" for i, kind in enumerate(kinds)]
    taken = [word for i, word in enumerate(words) if scheme is None or i != SCHEME_PLACE]
    constant = ""
    if scheme is not None:
        words[SCHEME_PLACE] = "ptr @scheme"
        size, quoted = len(scheme), quote_bytes(scheme)
        constant = f'@scheme = internal constant [{size} x i8] c"{quoted}", align 8\n'
        taken = [word.replace("ptr", "ptr noalias", 1) for word in taken]
    return f"""{constant}
declare i32 @"{kernel}"(ptr, ptr, {", ".join(kinds)})
define i32 @{name}({", ".join(taken)}) {{
  %answer = alloca i64
  %error = alloca ptr
  store i64 -1, ptr %answer
  %raised = call i32 @"{kernel}"(ptr %answer, ptr %error, {", ".join(words)})
  %sound = icmp eq i32 %raised, 0
  %wide = load i64, ptr %answer
  %said = trunc i64 %wide to i32
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
    head = entry_text(entry, name, "trainer_tick", np.asarray(scheme).tobytes())
    for part in (head, freestanding_text(64), constants_text(constants)):
        module.link_in(binding.parse_assembly(part))
    return seal_module(module, {"trainer_tick", *constants})


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


def lower_in_child(program: str, words: Sequence[str]) -> None:
    """Run a program of this package that lowers for a plain processor, in a process of its own.

    Its bytes then do not depend on this machine, nor on settings of numba, except that of its
    cache. ConfigError with what it says where it fails.
    """
    environment = {
        name: value for name, value in os.environ.items() if not name.startswith("NUMBA_")
    }
    if "NUMBA_CACHE_DIR" in os.environ:
        environment["NUMBA_CACHE_DIR"] = os.environ["NUMBA_CACHE_DIR"]
    root = str(Path(__file__).parents[3])
    environment |= PLAIN_MACHINE
    environment["PYTHONPATH"] = os.pathsep.join([root, os.environ.get("PYTHONPATH", "")])
    call_program([sys.executable, "-c", program, *words], environment)


def call_program(words: Sequence[str], environment: Mapping[str, str]) -> None:
    """Call another program; ConfigError with what it says where it fails."""
    done = subprocess.run(words, env=environment, capture_output=True, text=True, check=False)  # noqa: S603
    if done.returncode != 0:
        said = (done.stderr.strip().splitlines() or ["no word"])[-1]
        raise ConfigError(f"export-core: {Path(words[0]).name} failed: {said}")
