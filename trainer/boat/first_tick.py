"""The tick of one boat, compiled alone, at the least cost: ``python -m trainer.boat.first_tick``.

A boat that is at sea already needs this one entry, and hundreds of kernels below it. To be called
by Python, to run by itself and to lie in the cache costs a small kernel more than its equations
do. Here only the entry gets that. The machine code of the entry is what any process reads later.

A kernel is not put into its callers here. Numba has what a part calls inherit the part's option,
if it is compiled within it, and the rates would then be in the tick nine times over.

It takes a process of its own, whose kernels Python cannot call. It reaches into numba:
``compilation.known_compiler`` says whether it may be done.
"""

import functools
import gc
from collections.abc import Callable
from types import ModuleType
from typing import Any, Final

from numba import njit, types
from numba.core import event
from numba.core.compiler import Compiler
from numba.extending import is_jitted

from trainer.boat import compilation

COLLECTION_THRESHOLDS: Final = 50_000, 20, 100  # objects, rounds, rounds: a compiler makes millions


class LeanCompiler(Compiler):
    """A compiler of kernels that only kernels call."""

    def define_pipelines(self) -> Any:
        """Return numba's own passes, told that nothing will call the kernel from outside."""
        self.state.flags.no_cpython_wrapper = True
        self.state.flags.no_compile = True
        return super().define_pipelines()  # type: ignore[no-untyped-call]

    def compile_extra(self, func: Callable[..., Any]) -> Any:
        """Return the kernel compiled. Its callers know it by a name that is not its code."""
        compiled: Any = super().compile_extra(func)  # type: ignore[no-untyped-call]
        name: Any = [].append  # a dispatcher takes nothing but a built-in function, each its own
        self.state.targetctx.insert_user_function(name, compiled.fndesc, [compiled.library])
        return compiled._replace(entry_point=name)


class Progress(event.Listener):
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
    own = function.__globals__
    modules = [vars(own[name]) for name in names if isinstance(own.get(name), ModuleType)]
    things = [place[name] for place in (own, *modules) for name in names if name in place]
    return {thing for thing in things if is_jitted(thing)}


def make_kernels_lean() -> None:
    """Import the tick, whose kernels are compiled for each other alone. None may be there yet."""
    from trainer.core import kernel as decorators  # noqa: PLC0415

    usual: Any = decorators.kernel, decorators.part
    lean: dict[str, Any] = {"error_model": "numpy", "pipeline_class": LeanCompiler}
    own: Any = decorators
    own.kernel = njit(forceinline=False, **lean, **decorators.LEAN)
    own.part = njit(forceinline=True, **lean, **decorators.LEAN)
    try:
        from trainer.core import soundings, update  # noqa: F401, PLC0415
    finally:
        own.kernel, own.part = usual


def compile_tick(tell: Callable[[int], None]) -> None:
    """Compile the tick into the cache, in a process that has imported no kernel."""
    make_kernels_lean()
    # numba tells each pass the arguments' types in words; those of a record are hundreds of fields
    record: Any = types.Record
    record.__repr__ = functools.cache(record.__repr__)
    from trainer.boat.call import update_at  # noqa: PLC0415

    gc.freeze()
    gc.set_threshold(*COLLECTION_THRESHOLDS)
    with event.install_listener("numba:compile", Progress(update_at, tell)):
        update_at.compile((types.Array(types.int64, 1, "C"),))


if __name__ == "__main__":
    compile_tick(compilation.write_progress)
    compilation.keep("tick")
