"""The machine code of the core's kernels, and the call of it.

An object for the plainest processor of each platform comes with the package, so that nothing is
compiled before a boat goes to sea: its bits are those of any other compilation. Where none fits, on
another platform or with a core that was changed, the same object is made here once, in sight, and
kept in the cache. It is chosen and its SHA-256 is checked before a byte of it is loaded, because a
damaged one would end the process.

Settings of numba that ask for other code are obeyed: then no object is used, and numba compiles, or
the interpreter runs, what is called.
"""

import ctypes
import errno
import functools
import gzip
import hashlib
import json
import os
import platform
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final, NamedTuple

import numpy as np

from trainer.boat.entries import (
    KERNEL_ENTRIES,
    NUMBER_PAIR,
    Entry,
    RecordRow,
    digest_room,
    entries_of,
    entry_of,
    room_of,
)
from trainer.boat.object_image import ObjectImage
from trainer.boat.platforms import (
    CARD_FILE,
    SHIPPED_PLATFORMS,
    fitting_name,
    host_features,
    platform_name,
)
from trainer.core.digest import core_digest
from trainer.core.kernel import INTERPRETED, Kernel

SHIPPED_FOLDER: Final = Path(__file__).with_name("shipped")
HOST_NAME: Final = "host"
MADE_PREFIX: Final = "object-"  # of an object that was made here
# settings of numba that ask for other code than the object's
NUMBA_SETTINGS: Final = ("BOUNDSCHECK", "CPU_NAME", "CPU_FEATURES", "OPT")
SHIPPED_WAY: Final = "shipped"
BY_NUMBA: Final = "compiled by numba"
EMPTY_CHART: Final = np.empty(0)
NO_BYTES: Final = ctypes.c_char * 0
MAKING_TEXT: Final = "trainer: compiling the core for this machine, this once (about a minute) ..."
FORBIDDEN_TEXT: Final = (
    "this system lets no program make machine code at run time: allow it for trainer (systemd: "
    "MemoryDenyWriteExecute=no; SELinux: the boolean deny_execmem off)"
)


def shipped_card() -> dict[str, Any]:
    """Return the card of the shipped objects, {} if it cannot be read."""
    try:
        card = json.loads((SHIPPED_FOLDER / CARD_FILE).read_text("utf-8"))
    except (OSError, ValueError):
        return {}
    return card if isinstance(card, dict) else {}


def shipped_object(platform_asked: str | None = None, room: str = "") -> bytes | None:
    """Return the shipped object for a platform or this machine, None if there is none.

    It is the core's, or that of a room above. One that is not whole is told, and not used.
    """
    name, card = platform_asked or fitting_name(host_features()), shipped_card()
    fits = card.get(room) == digest_room(room) if room else card.get("core") == core_digest()
    if not fits or name is None:
        return None
    name = f"{room}-{name}" if room else name
    path = SHIPPED_FOLDER / f"{name}.o.gz"
    try:
        code = gzip.decompress(path.read_bytes())
        whole = hashlib.sha256(code).hexdigest() == card["objects"][name]["sha256"]
    except (OSError, EOFError, ValueError, KeyError, TypeError):
        whole = False
    if not whole:
        print(f"trainer: {path}: damaged, and not used: install again", file=sys.stderr)
        return None
    return code


def made_object() -> bytes | None:
    """Return the object for this machine, made here once; None if it cannot be."""
    from importlib import metadata  # noqa: PLC0415  what is shipped does without

    from trainer.core.cache import cache_folder  # noqa: PLC0415  it claims the folder

    facts = [core_digest(), platform_name(), platform.python_version()]
    facts += [entry.name for entry in KERNEL_ENTRIES]
    facts += [metadata.version(name) for name in ("numba", "llvmlite")]
    name = MADE_PREFIX + hashlib.sha256(repr(facts).encode()).hexdigest()[:16]
    path = cache_folder() / f"{name}.o"
    digest_path = path.with_suffix(".sha256")
    try:
        code = path.read_bytes()
        if hashlib.sha256(code).hexdigest() == digest_path.read_text("ascii"):
            return code
    except (OSError, ValueError):
        pass
    from trainer.boat.export.objects import make_objects  # noqa: PLC0415  it imports the compiler
    from trainer.config.files import ConfigError  # noqa: PLC0415

    print(MAKING_TEXT, file=sys.stderr, flush=True)
    try:
        code = make_objects(HOST_NAME)[HOST_NAME]
    except ConfigError as problem:
        print(f"trainer: {problem}; numba compiles what is called", file=sys.stderr)
        return None
    made = path.with_suffix(f".{os.getpid()}")
    made.write_bytes(code)
    digest_path.write_text(hashlib.sha256(code).hexdigest(), "ascii")
    made.replace(path)
    return code


class Library:
    """An object in memory, and its functions."""

    def __init__(self, code: bytes) -> None:
        """Load an object; PermissionError where memory may not be made executable."""
        try:
            self.address_of: Callable[[str], int] = ObjectImage(code).address_of
        except (ValueError, IndexError, OSError):
            self.address_of = self._load_by_llvm(code)
        # it stays for good: a thread may be in it, even while the process ends
        ctypes.pythonapi.Py_IncRef(ctypes.py_object(self))

    def _load_by_llvm(self, code: bytes) -> Callable[[str], int]:
        """Return what tells the address of a function in an object that LLVM has loaded."""
        from llvmlite import binding  # type: ignore[import-untyped]  # noqa: PLC0415

        try:
            binding.check_jit_execution()
        except OSError:
            raise PermissionError(errno.EPERM, FORBIDDEN_TEXT) from None
        binding.initialize_native_target()
        binding.initialize_native_asmprinter()
        kind = SHIPPED_PLATFORMS.get(platform_name())
        triple = kind.triple if kind else binding.get_process_triple()
        machine = binding.Target.from_triple(triple).create_target_machine(opt=3)
        empty = binding.parse_assembly("")
        empty.triple, empty.data_layout = triple, str(machine.target_data)
        engine = binding.create_mcjit_compiler(empty, machine)
        engine.add_object_file(binding.ObjectFileRef.from_data(code))
        engine.finalize_object()
        return lambda name: int(engine.get_function_address(name))


class _Way(NamedTuple):
    """How kernels are computed: by the library, or as the name says."""

    name: str
    library: Library | None


@functools.cache
def _find_way() -> _Way:
    """Load the machine code, and return how kernels are computed in this process."""
    if INTERPRETED:
        return _Way("interpreted", None)
    settings = (os.environ.get(f"NUMBA_{name}", "0") for name in NUMBA_SETTINGS)
    if any(setting not in ("", "0") for setting in settings):
        return _Way(BY_NUMBA, None)
    if code := shipped_object():
        return _Way(SHIPPED_WAY, Library(code))
    if code := made_object():
        return _Way("made here", Library(code))
    return _Way(BY_NUMBA, None)


@functools.cache
def _find_library(room: str) -> Library | None:
    """Load the machine code of a room, where that of the core is shipped as well."""
    way = _find_way()
    if not room or way.name != SHIPPED_WAY:
        return None if room else way.library
    code = shipped_object(room=room)
    return Library(code) if code else None


def way_name() -> str:
    """Return how kernels are computed: shipped, made here, compiled by numba, or interpreted."""
    return _find_way().name


def _address(array: Any) -> int:
    """Return where the numbers of an array are.

    A view of no bytes tells it in a quarter of the time that numpy's ways take. It needs an array
    that may be written and has no fields.
    """
    if array.dtype.names or not array.flags.writeable:
        return int(array.ctypes.data)
    return ctypes.addressof(NO_BYTES.from_buffer(array))


def _fits(kind: Any, given: Any) -> bool:
    """Return whether an argument is of the kind that the object takes, else numba takes it."""
    if not isinstance(given, np.ndarray) or not given.flags.c_contiguous:
        return False
    if isinstance(kind, RecordRow):
        return bool(given.dtype == kind.dtype) and given.ndim == 1
    if not isinstance(kind, tuple):
        return bool(given.dtype == kind) and given.shape == (1,)
    shape = given.shape
    if given.dtype != np.float64 or len(shape) != len(kind):
        return False
    for size, had in zip(kind, shape, strict=True):  # noqa: SIM110  all() takes three times as long
        if size not in (0, had):
            return False
    return True


def call_entry(entry: Entry, address: int) -> Callable[..., Any]:
    """Return what calls the machine code of a kernel as the kernel is called.

    What it is given of other kinds than the object's numba takes, and compiles for.
    """
    number, pointer = ctypes.c_double, ctypes.c_void_p
    is_number = [kind is float or kind is int for kind in entry.kinds]
    kinds = [number if plain else pointer for plain in is_number]
    kinds += [number for _ in entry.sizes] + [pointer] * bool(entry.answers)
    # a tick is too short for other threads to have their turn in it, many ticks are not
    prototype = ctypes.CFUNCTYPE if entry.many_ticks else ctypes.PYFUNCTYPE
    function = prototype(ctypes.c_int, *kinds)(address)
    sizes, answers = tuple(entry.sizes), entry.answers
    wanted = tuple(zip(range(len(kinds)), entry.kinds, is_number, strict=False))
    # the records of the last call and their addresses, in one object, for calls by any thread
    nothing = object()
    last: tuple[tuple[Any, ...], tuple[int, ...]] = (nothing,) * len(wanted), (0,) * len(wanted)

    def call(*asked: Any) -> Any:
        nonlocal last
        given = (*asked[0], *asked[1:]) if entry.bundle else asked
        before, known = last
        words, moved = [], False
        for i, kind, plain in wanted:
            each = given[i]
            if each is before[i]:
                words.append(known[i])
            elif plain and not isinstance(each, np.ndarray):
                words.append(each)
            elif not plain and _fits(kind, each):
                words.append(_address(each))
                moved = moved or isinstance(kind, np.dtype)
            else:
                return entry.kernel.dispatcher(*asked)
        if moved:
            # nothing but records is kept: what is written for many ticks may be large
            kept = (given[i] if isinstance(kind, np.dtype) else nothing for i, kind, _ in wanted)
            last = tuple(kept), tuple(words)
        words += [given[index].shape[i] for index, i in sizes]
        if not answers:
            status = function(*words)
            return entry.answer(status) if entry.answer else None
        answer = np.empty(answers)
        function(*words, _address(answer))
        return tuple(answer.tolist()) if entry.answer is NUMBER_PAIR else float(answer[0])

    return call


def bind(kernel: Callable[..., Any], *arguments: Any) -> Callable[[], int]:
    """Return the call of a kernel with these arguments, which stay where they are.

    Only addresses are bound: to take records apart at every call would cost more than a tick. The
    kernel's entry is one that can be bound. TypeError if an argument is of another kind than there.
    """
    library = _find_way().library
    if library is None:
        return functools.partial(kernel, *arguments)
    entry = entry_of(kernel)
    given = (*arguments[0], *arguments[1:]) if entry.bundle else arguments
    sizes = [given[index].shape[i] for index, i in entry.sizes]
    block: Any = np.zeros(len(given) + len(sizes), np.int64)
    numbers = block.view(np.float64)
    numbers[len(given) :] = sizes
    for index, (kind, each) in enumerate(zip(entry.kinds, given, strict=True)):
        if kind is int or kind is float:
            numbers[index] = each
        elif _fits(kind, each):
            block[index] = _address(each)
        else:
            raise TypeError(f"{entry.name}: argument {index} is of another kind")
    words_there = (ctypes.c_int64 * block.size).from_buffer(block)
    prototype = ctypes.CFUNCTYPE if entry.many_ticks else ctypes.PYFUNCTYPE
    function = prototype(ctypes.c_int)(library.address_of(entry.bound_name))
    bound: Any = functools.partial(function, ctypes.byref(words_there))  # the least of all calls
    bound.kept = given  # as long as the call is
    return bound  # type: ignore[no-any-return]


def find_code(kernel: Kernel) -> Callable[..., Any] | None:
    """Return what calls the machine code of a kernel, None if it has none here."""
    room = room_of(kernel.py_func.__module__)
    entry = next((each for each in entries_of(room) if each.kernel is kernel), None)
    library = _find_library(room) if entry else None
    if entry is None or library is None:
        return None
    address = library.address_of(entry.name)  # 0: the object is of before this entry
    return call_entry(entry, address) if address else None
