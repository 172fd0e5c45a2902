"""The symbols of an object file of ELF or Mach-O, as far as the shipped objects have them."""

import struct
from collections.abc import Iterator

ELF_SYMTAB, MACHO_SYMTAB = 2, 2  # types of a section, and of a load command
MACHO_MAGIC = 0xFEEDFACF


def symbols(code: bytes) -> Iterator[tuple[str, bool]]:
    """Yield each named symbol of an object that others see, and whether it is defined."""
    if code[:4] == b"\x7fELF":
        yield from _elf_symbols(code)
    else:
        yield from _macho_symbols(code)


def _name(strings: bytes, at: int) -> str:
    return strings[at : strings.index(b"\0", at)].decode()


def _elf_symbols(code: bytes) -> Iterator[tuple[str, bool]]:
    (start,) = struct.unpack_from("<Q", code, 40)
    size, count = struct.unpack_from("<HH", code, 58)
    sections = [struct.unpack_from("<IIQQQQIIQQ", code, start + i * size) for i in range(count)]
    for section in sections:
        if section[1] != ELF_SYMTAB:
            continue
        link = sections[section[6]]
        strings = code[link[4] : link[4] + link[5]]
        for at in range(section[4], section[4] + section[5], 24):
            name, info, _, place, _, _ = struct.unpack_from("<IBBHQQ", code, at)
            if name and info >> 4:  # not local
                yield _name(strings, name), place != 0


def _macho_symbols(code: bytes) -> Iterator[tuple[str, bool]]:
    magic, *_, count, _, _, _ = struct.unpack_from("<8I", code, 0)
    assert magic == MACHO_MAGIC
    at = 32
    for _ in range(count):
        command, size = struct.unpack_from("<II", code, at)
        if command == MACHO_SYMTAB:
            first, many, text, length = struct.unpack_from("<4I", code, at + 8)
            strings = code[text : text + length]
            for each in range(first, first + 16 * many, 16):
                name, kind, _, _, _ = struct.unpack_from("<IBBHQ", code, each)
                if name and kind & 1:
                    yield _name(strings, name), kind & 0x0E != 0
        at += size
