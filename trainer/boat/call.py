"""The tick of one boat is called from Python at the least cost.

Its records are bound once, by their addresses.

Taking five records apart at every call costs more than the tick does, and 20 us where nothing of it
is in the caches. They never move while their owner keeps them, so that one small array of addresses
serves. This reaches into numba: ``compilation.known_compiler`` says whether it may be imported.
"""

import functools
from collections.abc import Callable
from typing import Any, Final

import numba
import numpy as np
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic
from numba.np import arrayobj
from numpy.typing import NDArray

from trainer.core.casualties import instruments
from trainer.core.kernel import Numbers, Record, kernel
from trainer.core.scheme import SCHEME
from trainer.core.soundings import sound
from trainer.core.state import SCRATCH, STATE
from trainer.core.update import update
from trainer.core.vessel import COMPACT, VESSEL

Addresses = NDArray[np.int64]
Places = NDArray[np.int64]
ROW_TYPE: Final = types.Array(types.float64, 1, "C")


def _record_at(kind: np.dtype) -> Any:
    """Return a function for kernels: from an address the record there, not copied."""
    array = numba.typeof(np.zeros(1, kind))

    @intrinsic
    def at(_context: Any, _address: Any) -> Any:
        def code(context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
            record = context.make_array(array)(context, builder)
            size = context.get_constant(types.intp, kind.itemsize)
            arrayobj.populate_array(
                record,
                data=builder.inttoptr(arguments[0], record.data.type),
                shape=cgutils.pack_array(builder, [context.get_constant(types.intp, 1)]),
                strides=cgutils.pack_array(builder, [size]),
                itemsize=size,
                meminfo=None,
            )
            return record._getvalue()  # noqa: SLF001  numba has no other way

        return array(types.int64), code

    return at


vessel_at, compact_at, scheme_at = _record_at(VESSEL), _record_at(COMPACT), _record_at(SCHEME)
state_at, scratch_at = _record_at(STATE), _record_at(SCRATCH)


def _row_at(_context: Any, _address: Any, _count: Any) -> Any:
    """Return a function for kernels: from an address so many numbers there, not copied."""

    def code(context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        numbers = context.make_array(ROW_TYPE)(context, builder)
        arrayobj.populate_array(
            numbers,
            data=builder.inttoptr(arguments[0], numbers.data.type),
            shape=cgutils.pack_array(builder, [arguments[1]]),
            strides=cgutils.pack_array(builder, [context.get_constant(types.intp, 8)]),
            itemsize=8,
            meminfo=None,
        )
        return numbers._getvalue()  # noqa: SLF001  numba has no other way

    return ROW_TYPE(types.int64, types.int64), code


row_at: Any = intrinsic(_row_at)


@kernel
def update_at(addresses: Addresses) -> int:
    """Advance the boat whose records lie at these addresses by one tick; return its status.

    The address and the length of a chart of the ground come last; it is sounded before the tick.
    """
    if addresses[6] != 0:
        sound(vessel_at(addresses[0]), row_at(addresses[5], addresses[6]), state_at(addresses[3]))
    return update(
        vessel_at(addresses[0]),
        compact_at(addresses[1]),
        scheme_at(addresses[2]),
        state_at(addresses[3]),
        scratch_at(addresses[4]),
    )


@kernel
def fly_at(addresses: Addresses, places: Places, rows: Numbers) -> int:
    """Advance the boat by a tick for each of the rows.

    Return the status of the last one. A row has the numbers at those places of the state, then
    what the gauges read, if it is longer.
    """
    state, scratch = state_at(addresses[3]), scratch_at(addresses[4])
    count = places.size
    for i in range(rows.shape[0]):
        status = update_at(addresses)
        if status != 0:
            return status
        for k in range(count):
            rows[i, k] = state[0].whole[places[k]]
        if rows.shape[1] > count:
            instruments(state, scratch)
            for k in range(scratch[0].reading.size):
                rows[i, count + k] = scratch[0].reading[k]
    return 0


def addresses_of(records: tuple[Record, ...], chart: Numbers | None) -> Addresses:
    """Return the addresses of records and chart. Their owner keeps them, and does not move them."""
    chart_address = (0, 0) if chart is None else (chart.ctypes.data, chart.size)
    return np.array([*(record.ctypes.data for record in records), *chart_address])


def bind_flight(
    records: tuple[Record, ...], chart: Numbers | None
) -> Callable[[Places, Numbers], int]:
    """Return ``fly_at`` of these records, as ``bind_update`` does with one tick."""
    return functools.partial(fly_at, addresses_of(records, chart))


def bind_update(records: tuple[Record, ...], chart: Numbers | None = None) -> Callable[[], int]:
    """Return ``update`` of these records, compiled, the chart of the ground sounded before it.

    The caller keeps the records, and does not move them, because only addresses are bound.
    """
    addresses = addresses_of(records, chart)
    # the machine code itself: to find it anew by its arguments' types takes a third of a tick
    compiled: Callable[[Addresses], int] = update_at.compile((numba.typeof(addresses),))
    return functools.partial(compiled, addresses)
