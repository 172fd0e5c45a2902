"""The platforms that machine code of the core is shipped for.

``export/objects`` makes an object for each, ``machine_code`` loads the one of this machine.
"""

import platform
import sys
from collections.abc import Mapping
from typing import Final, NamedTuple

CARD_FILE: Final = "card.json"  # what the objects were made from


class Platform(NamedTuple):
    """What an object is compiled for, and what a processor must have for it."""

    triple: str
    cpu: str
    features: str
    needs: tuple[str, ...]


X86_NEEDS: Final = ("sse4.2", "ssse3", "popcnt")
V3_NEEDS: Final = (*X86_NEEDS, "avx2", "bmi", "bmi2", "f16c", "fma", "lzcnt", "movbe")
# by system and machine; the first that a processor can run is taken
PLATFORMS: Final[Mapping[str, Platform]] = {
    "linux-x86_64-v3": Platform("x86_64-unknown-linux-gnu", "x86-64-v3", "", V3_NEEDS),
    "linux-x86_64": Platform("x86_64-unknown-linux-gnu", "x86-64-v2", "", X86_NEEDS),
    "linux-aarch64": Platform("aarch64-unknown-linux-gnu", "generic", "", ()),
    # as ELF, because as COFF it would ask for _fltused
    "windows-x86_64": Platform("x86_64-pc-windows-msvc-elf", "x86-64-v2", "", X86_NEEDS),
    "macos-arm64": Platform("arm64-apple-macosx11.0.0", "apple-m1", "", ()),
}
SYSTEM_NAMES: Final = {"darwin": "macos", "win32": "windows"}


def platform_name() -> str:
    """Return the name of this machine's platform, whatever its processor has."""
    machine = {"amd64": "x86_64"}.get(platform.machine().lower(), platform.machine().lower())
    return f"{SYSTEM_NAMES.get(sys.platform, sys.platform)}-{machine}"


def fitting_name(features: Mapping[str, bool]) -> str | None:
    """Return the first platform whose object a processor of this machine's kind can run."""
    here = platform_name()
    for name, kind in PLATFORMS.items():
        if name in (here, f"{here}-v3") and all(features.get(need) for need in kind.needs):
            return name
    return None
