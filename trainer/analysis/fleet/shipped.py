"""One boat's kernels, called from kernels of a fleet by their shipped machine code.

numba would compile them anew with each kernel that calls them, for two minutes. So a fleet gets
the addresses of that code, ``find_codes``, and calls ``update`` and the others here by them. Where
there is no shipped code there are no addresses, and numba compiles what is called.
"""

from collections.abc import Callable
from typing import Any, Final, NamedTuple

from llvmlite import ir  # type: ignore[import-untyped]
from numba import types
from numba.core.typing.templates import signature
from numba.extending import intrinsic, overload

from trainer.boat.machine_code import find_addresses
from trainer.core import start, update
from trainer.core.autopilot.autopilot import stand_by_all
from trainer.core.kernel import Record
from trainer.core.sea import sea
from trainer.core.state import new_scratch

Codes = tuple[int, ...]  # addresses in this process, of SHIPPED_KERNELS; none where numba compiles
SHIPPED_KERNELS: Final[tuple[Any, ...]] = (
    update.update,
    start.level_flight,
    start.set_out,
    stand_by_all,
    sea.order_sea,
)


def find_codes() -> Codes:
    """Return the addresses of SHIPPED_KERNELS."""
    return find_addresses(*SHIPPED_KERNELS)


class SoloWork(NamedTuple):
    """The work space of one boat at a time, and the code that moves it."""

    codes: Codes
    scratch: Record


def new_solo() -> SoloWork:
    """Return a work space."""
    return SoloWork(find_codes(), new_scratch())


@intrinsic
def call_code(_context: Any, address: Any, given: Any) -> tuple[Any, Callable[..., Any]]:
    """Call the code at an address, and return its status.

    It takes what the row in ``boat.entries`` says: arrays by address, numbers as doubles.
    """

    def generate(context: Any, builder: Any, signed: Any, values: Any) -> Any:
        words = []
        for index, kind in enumerate(signed.args[1].types):
            value = builder.extract_value(values[1], index)
            if isinstance(kind, types.Array):
                words.append(context.make_array(kind)(context, builder, value).data)
            else:
                words.append(context.cast(builder, value, kind, types.float64))
        function = ir.FunctionType(ir.IntType(32), [word.type for word in words])
        code = builder.inttoptr(values[0], function.as_pointer())
        return builder.sext(builder.call(code, words), ir.IntType(64))

    return signature(types.int64, address, given), generate  # type: ignore[no-untyped-call]


def bind_kernel(kernel: Callable[..., Any], index: int) -> Callable[..., Any]:
    """Return what a fleet calls for a kernel, whose address is at ``index``."""

    def call(codes: Codes, *given: Any) -> Any:
        del codes  # interpreted there are none
        return kernel(*given)

    @overload(call)
    def choose(codes: Any, *given: Any) -> Callable[..., Any]:  # noqa: ARG001  named as in ``call``
        def call_by_code(codes: Any, *given: Any) -> Any:
            return call_code(codes[index], given)  # type: ignore[call-arg]

        def call_by_numba(codes: Any, *given: Any) -> Any:  # noqa: ARG001
            return kernel(*given)

        return call_by_code if codes.count else call_by_numba

    return call


update_boat, fly_level, set_boat_out, stand_boat_by, order_boats_sea = (
    bind_kernel(kernel, index) for index, kernel in enumerate(SHIPPED_KERNELS)
)
