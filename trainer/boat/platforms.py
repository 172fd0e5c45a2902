"""The platforms that the core is compiled for, and levels of processors.

``export/objects`` makes the objects that are shipped, ``machine_code`` loads the one of this
machine; ``export/targets`` and ``export/wasm`` compile a boat's own core.
"""

import contextlib
import platform
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Final, NamedTuple

CPU_FACTS: Final = Path("/proc/cpuinfo")  # of Linux
CARD_FILE: Final = "card.json"  # what the objects were made from
# what each level has over the one before it, by the names of Linux
PROCESSOR_LEVELS: Final = {
    "x86-64-v2": ("sse4_2", "ssse3", "popcnt"),
    "x86-64-v3": ("avx2", "bmi1", "bmi2", "f16c", "fma", "movbe", "abm"),
    "x86-64-v4": ("avx512f", "avx512bw", "avx512cd", "avx512dq", "avx512vl"),
}
LLVM_NAMES: Final = {"sse4_2": "sse4.2", "bmi1": "bmi", "abm": "lzcnt"}  # where they differ


class Platform(NamedTuple):
    """What an object is compiled for, by the compiler's names, and what links it."""

    triple: str
    cpu: str
    purpose: str = ""
    features: str = ""
    bits: int = 64  # of an address; with 32 the code is for size
    helpers: tuple[str, ...] = ()  # files of LLVM text that the code generator calls
    compiler: str = "cc"
    packages: str = "gcc"  # Debian's, that have it and its library
    board: tuple[str, ...] = ()  # files of C that start a program where there is no system
    unit_folders: tuple[str, ...] = ()  # of a unit's library, by FMI 2.0 and 3.0


ARM_COMPILER: Final = (  # input and output by the debugger, vectors at address 0
    "arm-none-eabi-gcc -mcpu=cortex-m7 -mthumb -mfloat-abi=hard -mfpu=fpv5-d16 "
    "--specs=rdimon.specs -Wl,--section-start=.vectors=0"
)
# fmt: off
CPU_TARGETS: Final[Mapping[str, Platform]] = {  # by the name for --cpu
    "x86-64-v2": Platform("x86_64-unknown-linux-gnu", "x86-64-v2", "any of the last 15 years"),
    "x86-64-v3": Platform("x86_64-unknown-linux-gnu", "x86-64-v3", "with AVX2"),
    "x86-64-v4": Platform("x86_64-unknown-linux-gnu", "x86-64-v4", "with AVX-512"),
    "native": Platform("", "", "this one"),
    "aarch64": Platform(
        "aarch64-unknown-linux-gnu", "generic", "ARM of 64 bits, Linux",
        compiler="aarch64-linux-gnu-gcc", packages="gcc-aarch64-linux-gnu libc6-dev-arm64-cross",
    ),
    "riscv64": Platform(
        "riscv64-unknown-linux-gnu", "generic-rv64", "RISC-V of 64 bits, Linux",
        features="+m,+a,+f,+d,+c",
        compiler="riscv64-linux-gnu-gcc", packages="gcc-riscv64-linux-gnu libc6-dev-riscv64-cross",
    ),
    "cortex-m7": Platform(
        "thumbv7em-unknown-none-eabihf", "cortex-m7", "ARM Cortex-M7 with doubles, no system",
        bits=32, helpers=("aeabi.ll",),
        compiler=ARM_COMPILER, packages="gcc-arm-none-eabi libnewlib-arm-none-eabi",
        board=("board.c",),
    ),
    "wasm32": Platform(  # with the features that every browser has since 2021
        "wasm32-unknown-unknown", "mvp", "WebAssembly",
        features="+bulk-memory,+bulk-memory-opt", bits=32, compiler="wasm-ld", packages="lld",
    ),
}
# by system and machine; the first that a processor can run is taken
SHIPPED_PLATFORMS: Final[Mapping[str, Platform]] = {
    "linux-x86_64-v3": CPU_TARGETS["x86-64-v3"],
    "linux-x86_64": CPU_TARGETS["x86-64-v2"]._replace(
        compiler="x86_64-linux-gnu-gcc", packages="gcc-x86-64-linux-gnu libc6-dev-amd64-cross",
        unit_folders=("linux64", "x86_64-linux"),
    ),
    "linux-aarch64": CPU_TARGETS["aarch64"]._replace(
        unit_folders=("aarch64-linux", "aarch64-linux"),  # FMI 2.0.5 takes the names of 3.0 there
    ),
    # as ELF, because as COFF it would ask for _fltused
    "windows-x86_64": Platform(
        "x86_64-pc-windows-msvc-elf", "x86-64-v2",
        compiler="x86_64-w64-mingw32-gcc", packages="gcc-mingw-w64-x86-64",
        unit_folders=("win64", "x86_64-windows"),
    ),
    "macos-arm64": Platform("arm64-apple-macosx11.0.0", "apple-m1"),
}
# fmt: on
WASM_PLATFORM: Final = "wasm"  # of a unit as a component, by fmi-ls-wasm, of FMI 3.0 alone
UNIT_PLATFORMS: Final[Mapping[str, Platform]] = {  # by the name for --platform
    **{name: kind for name, kind in SHIPPED_PLATFORMS.items() if kind.unit_folders},
    WASM_PLATFORM: CPU_TARGETS["wasm32"]._replace(
        compiler="clang",
        packages="clang lld wasi-libc libclang-rt-dev-wasm32",
        unit_folders=("", "wasm32-wasip2"),
    ),
}
NATIVE_PLATFORMS: Final = [name for name in UNIT_PLATFORMS if name != WASM_PLATFORM]
# objects of those kernels alone that a unit calls, for size, since a unit is mailed about
UNIT_OBJECTS: Final = {name: f"unit-{name}" for name in UNIT_PLATFORMS}
# rooms above, whose kernels have objects of their own, with the module that has their entries
ROOMS: Final[Mapping[str, str]] = {"judge": "trainer.debrief.marks.tally_sheet"}
SHIPPED_OBJECTS: Final[Mapping[str, Platform]] = {
    **SHIPPED_PLATFORMS,
    **{f"{room}-{name}": kind for room in ROOMS for name, kind in SHIPPED_PLATFORMS.items()},
    **{name: UNIT_PLATFORMS[kind] for kind, name in UNIT_OBJECTS.items()},
}
SYSTEM_NAMES: Final = {"darwin": "macos", "win32": "windows"}


def flags_of(cpu: str) -> tuple[str, ...]:
    """Return Linux's names of what a level of processor has, () for no level."""
    levels = list(PROCESSOR_LEVELS)
    below = levels[: levels.index(cpu) + 1] if cpu in levels else ()
    return tuple(flag for level in below for flag in PROCESSOR_LEVELS[level])


def has_flag(features: Mapping[str, bool], flag: str) -> bool:
    """Return whether features, by the compiler's names, have what Linux calls ``flag``."""
    return bool(features.get(LLVM_NAMES.get(flag, flag)))


def host_features() -> Mapping[str, bool]:
    """Return what this machine's processor has, by the compiler's names."""
    with contextlib.suppress(OSError), CPU_FACTS.open(encoding="utf-8") as lines:
        for line in lines:
            if line.startswith("flags"):  # on x86, of each processor
                return {LLVM_NAMES.get(flag, flag): True for flag in line.split()}
    from llvmlite import binding  # type: ignore[import-untyped]  # noqa: PLC0415

    features: Mapping[str, bool] = binding.get_host_cpu_features()
    return features


def platform_name() -> str:
    """Return the name of this machine's platform, whatever its processor has."""
    machine = {"amd64": "x86_64"}.get(platform.machine().lower(), platform.machine().lower())
    return f"{SYSTEM_NAMES.get(sys.platform, sys.platform)}-{machine}"


def fitting_name(features: Mapping[str, bool]) -> str | None:
    """Return the first platform whose object a processor of this machine's kind can run."""
    here = platform_name()
    for name, kind in SHIPPED_PLATFORMS.items():
        fits = all(has_flag(features, flag) for flag in flags_of(kind.cpu))
        if fits and name in (here, f"{here}-v3"):
            return name
    return None
