"""A unit's library as a component of WebAssembly, by the draft standard fmi-ls-wasm.

The draft is that of July 2026 (Modelica Association, WIT package ``fmi:fmi3@3.0.0``), and may
change. clang links ``component.c`` over ``fmi3.c`` into a module. A component is a module in a
shell that says what it takes and gives: ``component.wasm`` is the shell of the world
``co-simulation-fmu``, made by wit-component, with an empty module where a boat's belongs.
"""

from pathlib import Path
from typing import Final

SHELL_PATH: Final = Path(__file__).with_name("component.wasm")
EMPTY_MODULE: Final = b"\0asm\1\0\0\0"
MODULE_SECTION: Final = 1  # of a component
COMPONENT_SOURCES: Final = (("face.c", "component.c"), ("fmi3.c", "fmi3.c"))
MODULE_OPTIONS: Final = (
    *("--target=wasm32-wasi", "-mexec-model=reactor", "-nostartfiles", "-Wl,--no-entry"),
    *("-Wl,--strip-all", "-Wl,--no-check-features", "-Wl,-z,stack-size=65536"),
)
MANIFEST_PLACE: Final = "extra/org.modelica.fmi-ls-wasm/manifest.xml"
MANIFEST_TEXT: Final = """\
<?xml version="1.0" encoding="UTF-8"?>
<fmiLayeredStandardManifest xmlns:fmi-ls="http://fmi-standard.org/fmi-ls-manifest"
  fmi-ls:fmi-ls-name="org.modelica.fmi-ls-wasm" fmi-ls:fmi-ls-version="0.1.0"
  fmi-ls:fmi-ls-description="FMI Layered Standard for WebAssembly"/>
"""


def component_of(module: bytes) -> bytes:
    """Return the component of a module that has what the shell takes and gives."""
    empty = bytes((MODULE_SECTION, len(EMPTY_MODULE))) + EMPTY_MODULE
    before, after = SHELL_PATH.read_bytes().split(empty)
    return before + bytes([MODULE_SECTION]) + encode_size(len(module)) + module + after


def encode_size(size: int) -> bytes:
    """Return a size as WebAssembly has it: seven bits a byte, the lowest first (LEB128)."""
    groups = [size >> shift & 0x7F for shift in range(0, max(size.bit_length(), 1), 7)]
    return bytes([*(group | 0x80 for group in groups[:-1]), groups[-1]])
