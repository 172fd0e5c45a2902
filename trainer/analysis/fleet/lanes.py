"""Boats side by side in one array, and the views that read one of them.

A block holds LANE_COUNT boats. Each number of the boat is LANE_COUNT numbers next to each other,
one for each lane, so that the processor can work on several boats by one instruction. A kernel
takes what ``a_view`` makes for a record, and the compiler takes it for an offset in the block. So
the core's equations, by which one boat is computed, are compiled once more for boats side by side,
and are written once.

A loop over ``every_lane()`` becomes vector code if nothing in it calls a library or leaves early,
and if both sides of a choice are loaded before it is made.
"""

import dis
import operator
from collections.abc import Mapping
from types import FunctionType
from typing import Any, Final

import numpy as np
from llvmlite import ir  # type: ignore[import-untyped]
from numba import types
from numba.core import cgutils
from numba.core.typing.templates import (
    AbstractTemplate,
    AttributeTemplate,
    infer_getattr,
    signature,
)
from numba.core.typing.templates import infer_global as typed_as
from numba.extending import (
    intrinsic,
    lower_builtin,
    lower_getattr_generic,
    lower_setattr_generic,
    models,
    register_model,
)

from trainer.core.kernel import inlined

FixedFields = Mapping[str, float]

# boats of a block: whole vectors of processors that take two, four or eight numbers
LANE_COUNT: Final = 16
DOUBLE_TYPE: Final = types.float64
BLOCK_TYPE: Final = types.Array(DOUBLE_TYPE, 1, "C")
DOUBLE_IR: Final = ir.DoubleType()
UNIT_DOUBLE: Final = DOUBLE_IR(3.0 * 2.0**51)  # a double whose last binary place is the unit
UNIT_BITS: Final = ir.IntType(64)(0x4338 << 48)


class LaneRecord(types.Type):
    """A record of one boat in a block. ``first`` is the offset of its first number."""

    def __init__(self, name: str, layout: np.dtype[Any], first: int, known: FixedFields) -> None:
        """Take the layout of the record for which it stands, and what is known of it."""
        self.layout, self.first, self.known = layout, first, known
        super().__init__(name=f"LaneRecord({name}, {first})")

    def member(self, name: str) -> "LaneNumbers | None":
        """Return where a field is; None if no field has that name."""
        fields = self.layout.fields
        if fields is None or name not in fields:
            return None
        kind, offset = fields[name][:2]
        return LaneNumbers(kind.shape, self.first + offset // 8)


class LaneNumbers(types.Type):
    """Numbers of one boat in a block: a field with a shape."""

    def __init__(self, shape: tuple[int, ...], first: int) -> None:
        """Take the shape, and the offset of the first."""
        self.shape, self.first = shape, first
        super().__init__(name=f"LaneNumbers({shape}, {first})")

    @property
    def index(self) -> Any:
        """Return the type of an index."""
        count = len(self.shape)
        return types.intp if count == 1 else types.UniTuple(types.intp, count)


@register_model(LaneRecord)
@register_model(LaneNumbers)
class LaneModel(models.StructModel):
    """The data of a view: the block and the lane. Its type knows which number it is of."""

    def __init__(self, manager: Any, view: types.Type) -> None:
        """Lay it out."""
        members = [("block", types.CPointer(DOUBLE_TYPE)), ("lane", types.intp)]
        super().__init__(manager, view, members)


@infer_getattr
class FieldType(AttributeTemplate):
    """The type of a field of a record."""

    key = LaneRecord

    def generic_resolve(self, view: LaneRecord, name: str) -> Any:  # type: ignore[override]
        """Return the type; None if there is no such field."""
        member = view.member(name)
        return member if member is None or member.shape else DOUBLE_TYPE


@typed_as(operator.getitem)
class ElementType(AbstractTemplate):
    """``state[0]`` is the record, ``s.motion[i]`` a number."""

    def generic(self, args: tuple[Any, ...], _keywords: Any) -> Any:
        """Return the types of element, view and index."""
        view = args[0]
        if isinstance(view, LaneRecord):
            return signature(view, view, types.intp)
        return signature(DOUBLE_TYPE, view, view.index) if isinstance(view, LaneNumbers) else None


@typed_as(operator.setitem)
class AssignmentType(AbstractTemplate):
    """The rule that only a number can be put at an offset."""

    def generic(self, args: tuple[Any, ...], _keywords: Any) -> Any:
        """Return the types of view, index and number."""
        view = args[0]
        if isinstance(view, LaneNumbers):
            return signature(types.none, view, view.index, DOUBLE_TYPE)
        return None


def _address(builder: Any, view: Any, offset: Any) -> Any:
    """Return the address of the number at ``offset`` of the view's boat."""
    numbers = builder.mul(offset, cgutils.intp_t(LANE_COUNT), flags=["nsw"])
    return builder.gep(view.block, [builder.add(numbers, view.lane, flags=["nsw"])], inbounds=True)


def _open_view(context: Any, builder: Any, kind: Any, value: Any = None) -> Any:
    """Return a view as its two parts."""
    return cgutils.create_struct_proxy(kind)(context, builder, value=value)


@lower_getattr_generic(LaneRecord)
def _get_field(context: Any, builder: Any, kind: Any, value: Any, name: str) -> Any:
    member = kind.member(name)
    view = _open_view(context, builder, kind, value)
    if name in kind.known:
        return DOUBLE_IR(kind.known[name])
    if not member.shape:
        return builder.load(_address(builder, view, cgutils.intp_t(member.first)))
    numbers = _open_view(context, builder, member)
    numbers.block, numbers.lane = view.block, view.lane
    return numbers._getvalue()  # noqa: SLF001 numba's own idiom


@lower_setattr_generic(LaneRecord)
def _set_field(context: Any, builder: Any, kinds: Any, args: Any, name: str) -> None:
    kind, given_type = kinds.args
    view = _open_view(context, builder, kind, args[0])
    number = context.cast(builder, args[1], given_type, DOUBLE_TYPE)
    builder.store(number, _address(builder, view, cgutils.intp_t(kind.member(name).first)))


@lower_builtin(operator.getitem, LaneRecord, types.intp)
def _record_itself(_context: Any, _builder: Any, _kinds: Any, args: Any) -> Any:
    return args[0]


def _element(context: Any, builder: Any, kind: LaneNumbers, args: Any) -> Any:
    """Return the address of an element."""
    index = args[1]
    if len(kind.shape) == 2:
        row = builder.mul(builder.extract_value(index, 0), cgutils.intp_t(kind.shape[1]))
        index = builder.add(row, builder.extract_value(index, 1))
    offset = builder.add(index, cgutils.intp_t(kind.first))
    return _address(builder, _open_view(context, builder, kind, args[0]), offset)


@lower_builtin(operator.getitem, LaneNumbers, types.Any)
def _get_element(context: Any, builder: Any, kinds: Any, args: Any) -> Any:
    return builder.load(_element(context, builder, kinds.args[0], args))


@lower_builtin(operator.setitem, LaneNumbers, types.Any, types.Any)
def _set_element(context: Any, builder: Any, kinds: Any, args: Any) -> None:
    builder.store(args[2], _element(context, builder, kinds.args[0], args))


def a_view(name: str, layout: np.dtype[Any], first: int, known: FixedFields) -> Any:
    """Return a function of a block and a lane that gives a kernel its record.

    ``first`` is the offset of the record's first number among those of a boat. Numbers that are
    ``known``, since they are the same for all boats and stay so, are not read from the block.
    """
    kind = LaneRecord(name, layout, first, known)

    @intrinsic
    def view(_typing: Any, _block: Any, _lane: Any) -> Any:
        def lower(context: Any, builder: Any, kinds: Any, args: Any) -> Any:
            array = context.make_array(kinds.args[0])(context, builder, args[0])
            seen = _open_view(context, builder, kind)
            seen.block, seen.lane = array.data, args[1]
            return seen._getvalue()  # noqa: SLF001

        return kind(BLOCK_TYPE, types.intp), lower

    return view


@inlined
def every_lane() -> Any:
    """Return the lanes of a block, to loop over.

    A call gives the length, because the compiler would unroll a loop whose length it knows at once,
    before the loop could become vector code.
    """
    return range(LANE_COUNT)


@intrinsic
def nearest(_typing: Any, _number: Any) -> Any:
    """Return the result of ``elementary._nearest`` by instructions on lanes, up to 2^51."""

    def lower(_context: Any, builder: Any, _kinds: Any, args: Any) -> Any:
        floor = builder.module.declare_intrinsic("llvm.floor", [UNIT_DOUBLE.type])
        whole = builder.call(floor, [builder.fadd(args[0], UNIT_DOUBLE.type(0.5))])
        bits = builder.bitcast(builder.fadd(whole, UNIT_DOUBLE), UNIT_BITS.type)
        return builder.sub(bits, UNIT_BITS)

    return types.int64(DOUBLE_TYPE), lower


@intrinsic
def as_float(_typing: Any, _whole: Any) -> Any:
    """Return the result of ``elementary._as_float``, likewise."""

    def lower(_context: Any, builder: Any, _kinds: Any, args: Any) -> Any:
        above = builder.bitcast(builder.add(args[0], UNIT_BITS), UNIT_DOUBLE.type)
        return builder.fsub(above, UNIT_DOUBLE)

    return DOUBLE_TYPE(types.int64), lower


@intrinsic
def times_power_of_two(_typing: Any, _number: Any, _power: Any) -> Any:
    """Return the result of ``elementary._times_power_of_two`` for powers from -1022 to 1023."""

    def lower(_context: Any, builder: Any, _kinds: Any, args: Any) -> Any:
        number, power = args
        biased = builder.shl(builder.add(power, power.type(1023)), power.type(52))
        return builder.fmul(number, builder.bitcast(biased, number.type))

    return DOUBLE_TYPE(DOUBLE_TYPE, types.int64), lower


def relay_kernel(kernel: Any, instead: Mapping[str, Any]) -> Any:
    """Return ``kernel`` to be compiled into its caller, with all that it calls.

    The equations are the kernel's own. Where the kernel, or one that it calls, calls a kernel whose
    name is in ``instead``, that of ``instead`` takes its place. Without JIT it is the kernel
    itself.
    """
    return _relaid(kernel, instead, {})


def _relaid(kernel: Any, instead: Mapping[str, Any], done: dict[Any, Any]) -> Any:
    """Return ``kernel`` for lanes, made once."""
    if not hasattr(kernel, "py_func"):
        return kernel
    if kernel not in done:
        function = kernel.py_func
        known = dict(function.__globals__)
        loads = (i for i in dis.get_instructions(function) if i.opname == "LOAD_GLOBAL")
        for name in {i.argval for i in loads}:
            if name in instead:
                known[name] = instead[name]
            elif hasattr(known.get(name), "py_func"):
                known[name] = _relaid(known[name], instead, done)
        done[kernel] = inlined(FunctionType(function.__code__, known, function.__name__))
    return done[kernel]
