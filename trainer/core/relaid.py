"""The core's kernels compiled once more, for boats side by side."""

import dis
from collections.abc import Mapping
from types import FunctionType
from typing import Any

from trainer.core.kernel import inlined


def relaid(kernel: Any, instead: Mapping[str, Any]) -> Any:
    """Return ``kernel`` to be compiled into its caller, with all that it calls.

    The equations are the kernel's own. A kernel that it calls, or one of those, is exchanged for
    that of the same name in ``instead``. Without JIT it is the kernel itself.
    """
    return _relaid(kernel, instead, {})


def _relaid(kernel: Any, instead: Mapping[str, Any], done: dict[Any, Any]) -> Any:
    """Return ``kernel`` for lanes, made once."""
    if not hasattr(kernel, "py_func"):
        return kernel
    if kernel not in done:
        function = kernel.py_func
        known = dict(function.__globals__)
        for name in _called(function):
            if name in instead:
                known[name] = instead[name]
            elif hasattr(known.get(name), "py_func"):
                known[name] = _relaid(known[name], instead, done)
        done[kernel] = inlined(FunctionType(function.__code__, known, function.__name__))
    return done[kernel]


def _called(function: FunctionType) -> set[str]:
    """Return the names of its module that a function uses."""
    return {i.argval for i in dis.get_instructions(function) if i.opname == "LOAD_GLOBAL"}
