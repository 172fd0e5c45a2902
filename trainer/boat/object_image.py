"""An object of x86-64 in memory, by itself: its addresses filled in, and made executable.

The shipped object calls no library and has its sections as far apart in the file as they ask for,
so no linker is needed. What has anything else in it is refused here, and LLVM loads it, whose
import takes a tenth of a start and half of its memory.

Source: System V Application Binary Interface, chapter 4, and its supplement for AMD64, 4.4.
"""

import ctypes
import mmap
import sys
from typing import Any, Final

import numpy as np

# of 64 bits, low byte first; and from byte 16 on: not linked, for x86-64
ELF_BEGINNING: Final = b"\x7fELF\x02\x01", b"\x01\x00\x3e\x00"
SECTION_LAYOUT: Final = np.dtype("u4,u4,u8,u8,u8,u8,u4,u4,u8,u8")
SECTION_LAYOUT.names = (
    "name",
    "kind",
    "flags",
    "address",
    "begin",
    "size",
    "link",
    "info",
    "step",
    "row",
)
SYMBOL_LAYOUT: Final = np.dtype("u4,u1,u1,u2,u8,u8")
SYMBOL_LAYOUT.names = ("name", "kind", "seen", "section", "value", "size")
RELOCATION_LAYOUT: Final = np.dtype("u8,u4,u4,i8")
RELOCATION_LAYOUT.names = ("place", "kind", "symbol", "added")
PLAIN, SYMBOLS, TEXTS, RELOCATIONS = 1, 2, 3, 4  # kinds of sections
WRITTEN, LOADED = 1, 2  # flags of a section
KNOWN_FLAGS: Final = 0x77  # with these: runs, is to be merged, has texts, is about another
SEALED_SECTION_NAME: Final = (
    b".data.rel.ro\0"  # where only addresses are written, before anything runs
)
LAST_PLAIN_SYMBOL_KIND: Final = 5  # the last kind of a symbol that is where it says
FIRST_RESERVED_SECTION: Final = 0xFF00  # from where on numbers of sections are of none
# kinds of relocations: an address, and the way from their place to what is here or is called
ADDRESS, WAY, CALL = 1, 2, 4


class ObjectImage:
    """An object in executable memory, and the addresses of its functions by name."""

    def __init__(self, code: bytes) -> None:
        """Load an object; OSError where memory may not be made executable.

        ValueError or IndexError for one that is of another kind, or has what is not known here.
        """
        if (code[:6], code[16:20]) != ELF_BEGINNING or sys.platform != "linux":
            raise ValueError("of an unknown kind, or another system's way to memory")
        begin, count, naming = (
            int.from_bytes(code[a:b], "little") for a, b in ((40, 48), (60, 62), (62, 64))
        )
        sections = np.frombuffer(code, SECTION_LAYOUT, count, begin)
        full = sections[sections["size"] > 0]
        loaded = full[full["flags"] & LOADED > 0]
        written = loaded[loaded["flags"] & WRITTEN > 0]["name"] + sections[naming]["begin"]
        (table,) = full[full["kind"] == SYMBOLS]
        symbols = _rows(code, SYMBOL_LAYOUT, table)
        own = (symbols["section"] > 0) & (symbols["section"] < FIRST_RESERVED_SECTION)
        steps = np.maximum(loaded["step"], 1)
        if (
            not np.isin(full["kind"], (PLAIN, SYMBOLS, TEXTS, RELOCATIONS)).all()
            or (full["flags"] & ~np.uint64(KNOWN_FLAGS)).any()
            or (loaded["kind"] != PLAIN).any()
            or (loaded["begin"] % steps).any()
            or (mmap.PAGESIZE % steps).any()
            or any(
                code[at : at + len(SEALED_SECTION_NAME)] != SEALED_SECTION_NAME
                for at in written.tolist()
            )
            or (symbols["kind"] % 16 > LAST_PLAIN_SYMBOL_KIND).any()
            or (symbols["section"][1:] == 0).any()  # the first is none, by the format
        ):
            raise ValueError("has a section or a symbol of an unknown kind")
        memory = mmap.mmap(-1, len(code), mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS)
        memory.write(code)
        base = ctypes.addressof(ctypes.c_char.from_buffer(memory))
        image = np.frombuffer(memory, np.uint8)
        offsets = sections["begin"][np.where(own, symbols["section"], 0)] + symbols["value"]
        for each in full[full["kind"] == RELOCATIONS]:
            target, rows = sections[each["info"]], _rows(code, RELOCATION_LAYOUT, each)
            kinds, places = rows["kind"], (target["begin"] + rows["place"]).astype(np.int64)
            values = offsets[rows["symbol"]].astype(np.int64) + rows["added"]
            within = (np.minimum(places, values) >= 0) & (np.maximum(places, values) < len(code))
            if not (own[rows["symbol"]] & np.isin(kinds, (ADDRESS, WAY, CALL)) & within).all():
                raise ValueError("asks for what it has not, or in an unknown way")
            for chosen, size, filled in (
                (kinds == ADDRESS, 8, values + base),
                (kinds != ADDRESS, 4, (values - places).astype("<i4")),
            ):
                found = np.ascontiguousarray(filled[chosen]).view(np.uint8).reshape(-1, size)
                image[places[chosen][:, None] + np.arange(size)] = found
        texts = sections[table["link"]]["begin"] + symbols["name"][own]
        self._addresses = {
            code[at : code.index(b"\0", at)].decode(): base + offset
            for at, offset in zip(texts.tolist(), offsets[own].tolist(), strict=True)
        }
        self._memory = memory  # it is there as long as this object
        protect = ctypes.CDLL(None, use_errno=True).mprotect
        where = ctypes.c_void_p(base), ctypes.c_size_t(len(code))
        if protect(*where, mmap.PROT_READ | mmap.PROT_EXEC):
            raise OSError(ctypes.get_errno(), "memory may not be made executable")

    def address_of(self, name: str) -> int:
        """Return the address of a function, 0 if there is none of the name."""
        return int(self._addresses.get(name, 0))


def _rows(code: bytes, kind: np.dtype[np.void], section: np.void) -> np.ndarray[Any, Any]:
    """Return a section of an object as records of a kind."""
    return np.frombuffer(code, kind, int(section["size"]) // kind.itemsize, section["begin"])
