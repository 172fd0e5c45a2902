"""Compiling the tick of one boat before anything else, with its progress in percent.

A boat at sea by the interpreter needs only the tick to go over to machine code. So ``warm_up``
compiles it first. Progress is counted in kernels: those below ``update`` that are done.
"""

from collections.abc import Callable
from types import ModuleType
from typing import Any

from numba import types
from numba.core import event
from numba.extending import is_jitted

from trainer.boat.call import update_at


class CompileProgress(event.Listener):
    """How many of the kernels below an entry have been compiled."""

    def __init__(self, entry: Any, tell: Callable[[int], None]) -> None:
        self.waiting = kernels_below(entry)
        self.count = len(self.waiting)
        self.tell = tell

    def on_start(self, _event: Any) -> None:
        """Do nothing; numba asks for it."""

    def on_end(self, ended: Any) -> None:
        """Tell how far it is [%] once a kernel is done."""
        self.waiting.discard(ended.data["dispatcher"])
        self.tell(100 * (self.count - len(self.waiting)) // self.count)


def kernels_below(entry: Any) -> set[Any]:
    """Return the kernels that an entry calls, those that they call, and itself."""
    known: set[Any] = set()
    ahead = {entry}
    while ahead:
        kernel = ahead.pop()
        known.add(kernel)
        ahead |= callees(kernel.py_func) - known
    return known


def callees(function: Any) -> set[Any]:
    """Return the kernels that a function names, also by their module."""
    names = function.__code__.co_names
    namespace = function.__globals__
    modules = [
        vars(namespace[name]) for name in names if isinstance(namespace.get(name), ModuleType)
    ]
    things = [place[name] for place in (namespace, *modules) for name in names if name in place]
    return {thing for thing in things if is_jitted(thing)}


def compile_tick(tell: Callable[[int], None]) -> None:
    """Compile the tick; ``tell`` is called with how far that is [%]."""
    with event.install_listener("numba:compile", CompileProgress(update_at, tell)):
        update_at.compile((types.Array(types.int64, 1, "C"),))
