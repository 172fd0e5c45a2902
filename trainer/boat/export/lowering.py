"""The compiled tick as one LLVM module that calls nothing outside itself.

``library`` and ``wasm`` make their objects of it. numba compiles the core's own kernel; its text is
linked with an entry that any C program can call, with the scheme as a constant, so that what the
scheme does not choose falls away, and with our own versions of the few library functions. Nothing
here may change an operation: no contraction, no reassociation, so that the bits are the trainer's.
"""

from collections.abc import Callable, Collection, Mapping, Sequence
from pathlib import Path
from typing import Any, Final

import numba
import numpy as np
from llvmlite import binding  # type: ignore[import-untyped]
from numba import carray, types  # type: ignore[attr-defined]

from trainer.config.files import ConfigError
from trainer.core.kernel import TESTED_NUMBA, Record, is_tested
from trainer.core.scheme import SCHEME
from trainer.core.state import SCRATCH, STATE
from trainer.core.update import update
from trainer.core.vessel import COMPACT, VESSEL

Kind = np.dtype | type  # of a parameter: the record at an address, or `float`
TICK_RECORDS: Final[tuple[Kind, ...]] = (VESSEL, COMPACT, SCHEME, STATE, SCRATCH)
FREESTANDING_PATH: Final = Path(__file__).parent / "freestanding.ll"
# numba returns whether a kernel raised, and its answer by address: where it raised the status is -1
ENTRY_TEMPLATE: Final = """
@scheme = internal constant [{size} x i8] c"{scheme}", align 8
declare i32 @"{kernel}"(ptr, ptr, ptr, ptr, ptr, ptr, ptr)
define i32 @trainer_tick(ptr noalias readonly %vessel, ptr noalias readonly %compact,
                         ptr noalias %state, ptr noalias %scratch) {{
  %answer = alloca i64
  %error = alloca ptr
  store i64 -1, ptr %answer
  %raised = call i32 @"{kernel}"(ptr %answer, ptr %error, ptr %vessel, ptr %compact,
                                 ptr @scheme, ptr %state, ptr %scratch)
  %sound = icmp eq i32 %raised, 0
  %wide = load i64, ptr %answer
  %said = trunc i64 %wide to i32
  %status = select i1 %sound, i32 %said, i32 -1
  ret i32 %status
}}
"""


def tick(vessel: Any, compact: Any, scheme: Any, state: Any, scratch: Any) -> int:
    """Advance the records at these addresses by one tick; return the status of ``update``."""
    boat, few = carray(vessel, 1), carray(compact, 1)
    return update(boat, few, carray(scheme, 1), carray(state, 1), carray(scratch, 1))


def kernel_text(
    function: Callable[..., int], kinds: Sequence[Kind] = TICK_RECORDS
) -> tuple[str, str]:
    """Return the LLVM text of a function of addresses and numbers, and its name.

    ConfigError where numba is told not to compile, or is of a version that was not tested.
    """
    if not is_tested(numba.__version__):
        (first, second), (_, last) = TESTED_NUMBA
        raise ConfigError(
            f"export-core: numba {numba.__version__} was not tested with it: install "
            f"'numba>={first}.{second},<{first}.{last + 1}'"
        )
    if numba.config.DISABLE_JIT:  # type: ignore[attr-defined]
        raise ConfigError("export-core compiles the core: unset NUMBA_DISABLE_JIT")
    taken = [
        types.float64 if kind is float else types.CPointer(numba.from_dtype(kind))  # type: ignore[no-untyped-call]
        for kind in kinds
    ]
    compiled: Any = numba.njit(types.int64(*taken), error_model="numpy")(function)
    signature = compiled.signatures[0]
    name = compiled.overloads[signature].fndesc.mangled_name
    return compiled.inspect_llvm(signature), name


def quote_bytes(data: bytes) -> str:
    """Return bytes as they stand in an LLVM string."""
    return "".join(f"\\{byte:02x}" for byte in data)


def constants_text(constants: Mapping[str, bytes]) -> str:
    """Return the LLVM text of public constant blocks of bytes by their names."""
    return "\n".join(
        f'@{name} = constant [{len(data)} x i8] c"{quote_bytes(data)}", align 8'
        for name, data in constants.items()
    )


def freestanding_module(
    function: Callable[..., int], scheme: Record, constants: Mapping[str, bytes]
) -> Any:
    """Return the module of ``trainer_tick`` for one scheme, beside the constants.

    ``trainer_tick`` does what ``function`` does with the addresses of all records; ``tick`` is the
    whole tick. Only ``trainer_tick`` and the constants can be seen from outside, so that the
    compiler may inline or drop all else.
    """
    binding.initialize_native_target()
    binding.initialize_native_asmprinter()
    text, name = kernel_text(function)
    module = binding.parse_assembly(text)
    chosen = np.asarray(scheme).tobytes()
    entry = ENTRY_TEMPLATE.format(size=len(chosen), scheme=quote_bytes(chosen), kernel=name)
    for part in (entry, freestanding_text(64), constants_text(constants)):
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
