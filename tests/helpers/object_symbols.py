"""The symbols of an object of ELF, Mach-O or WebAssembly, as far as the shipped ones have them."""

import struct
from collections.abc import Iterator

ELF_SYMTAB, MACHO_SYMTAB = 2, 2  # types of a section, and of a load command
MACHO_MAGIC = 0xFEEDFACF
WASM_CUSTOM, WASM_SYMTAB = 0, 8  # types of a section, and of a part of "linking"
WASM_DATA = 1  # a kind of symbol; 0 is a function, and others are the linker's own
WASM_LOCAL, WASM_UNDEFINED = 2, 16  # flags


def symbols(code: bytes) -> Iterator[tuple[str, bool]]:
    """Yield each named symbol of an object that others see, and whether it is defined."""
    if code[:4] == b"\x7fELF":
        yield from _elf_symbols(code)
    elif code[:4] == b"\0asm":
        yield from _wasm_symbols(code)
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


def _read_number(code: bytes, at: int) -> tuple[int, int]:
    """Return a number as WebAssembly has it (LEB128), and where the next one is."""
    number = shift = 0
    while code[at] & 0x80:
        number, shift, at = number | (code[at] & 0x7F) << shift, shift + 7, at + 1
    return number | code[at] << shift, at + 1


def _wasm_symbols(code: bytes) -> Iterator[tuple[str, bool]]:
    at = 8
    while at < len(code):
        size, begin = _read_number(code, at + 1)
        if code[at] == WASM_CUSTOM and code[begin : begin + 8] == b"\7linking":
            _, part = _read_number(code, begin + 8)  # its version
            while part < begin + size:
                length, first = _read_number(code, part + 1)
                if code[part] == WASM_SYMTAB:
                    yield from _wasm_table(code, first)
                part = first + length
        at = begin + size


def _wasm_table(code: bytes, at: int) -> Iterator[tuple[str, bool]]:
    count, at = _read_number(code, at)
    for _ in range(count):
        kind = code[at]
        flags, at = _read_number(code, at + 1)
        known, name = not flags & WASM_UNDEFINED, "without a name"
        if kind != WASM_DATA:
            _, at = _read_number(code, at)  # its index
        if known or kind == WASM_DATA:
            length, at = _read_number(code, at)
            name, at = code[at : at + length].decode(), at + length
        if known and kind == WASM_DATA:
            for _ in range(3):  # segment, offset, size
                _, at = _read_number(code, at)
        if kind <= WASM_DATA and not flags & WASM_LOCAL:
            yield name, known


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
