"""Programs of the system that tests use, installed before the first of them where that is allowed.

CI_APT=1 allows it, and says that none may be missing: then a test that lacks one fails. Elsewhere
it is skipped, and says so.
"""

import contextlib
import os
import shutil
import subprocess
import time
from collections.abc import Mapping, Sequence
from typing import Any, Final, NoReturn

INSTALLING_S: Final = 600.0  # [s] for all of them
OUTAGE_S: Final = 240.0  # [s] that the network may be away
AGAIN_AFTER_S: Final = 10.0  # [s] between two tries
PACKAGES: Final = {  # one or more, by program
    "caddy": "caddy",
    "chromium": "chromium",
    "chromium-headless-shell": "chromium-headless-shell",
    "faketime": "faketime",
    "gpsd": "gpsd",
    "gpsdecode": "gpsd-clients",
    "nginx": "nginx",
    "node": "nodejs",
    "npm": "npm",
    "ser2net": "ser2net",
    "tmux": "tmux",
    "wasm-ld": "lld",
}
SLOW_PACKAGES: Final = {  # of the slow lane alone
    "aarch64-linux-gnu-gcc": "gcc-aarch64-linux-gnu libc6-dev-arm64-cross",
    "arm-none-eabi-gcc": "gcc-arm-none-eabi libnewlib-arm-none-eabi",
    "clang": "clang lld wasi-libc libclang-rt-dev-wasm32",
    "firefox-esr": "firefox-esr",
    "qemu-aarch64": "qemu-user",
    "qemu-riscv64": "qemu-user",
    "qemu-system-arm": "qemu-system-arm",
    "riscv64-linux-gnu-gcc": "gcc-riscv64-linux-gnu libc6-dev-riscv64-cross",
    "valgrind": "valgrind",
    "wine": "wine wine64",
    "x86_64-w64-mingw32-gcc": "gcc-mingw-w64-x86-64",
}
# Another process that installs is waited for, and an index that does not come is a failure.
PATIENT: Final = ("-o", "DPkg::Lock::Timeout=300", "-o", "APT::Update::Error-Mode=any")


def is_complete() -> bool:
    """Return whether all programs are to be here, and may be installed."""
    return os.environ.get("CI_APT") == "1"


def find(program: str) -> str | None:
    """Return the path of a program; None without."""
    return shutil.which(program, path=f"{os.environ['PATH']}:/usr/sbin")


def run_program(words: Sequence[object], **more: Any) -> "subprocess.CompletedProcess[str]":
    """Run a program that must succeed; return what it wrote."""
    return subprocess.run(
        [str(word) for word in words], capture_output=True, text=True, check=True, **more
    )


def install_missing(packages: Mapping[str, str]) -> None:
    """Install at once those that lack their programs, where that is allowed."""
    if is_complete():
        missing = [names for program, names in packages.items() if find(program) is None]
        install([name for names in missing for name in names.split()])


def install(packages: list[str]) -> None:
    """Install packages; what fails is told by the tests that want them."""
    if not packages:
        return
    for words in (["update"], ["install", "-y", "--no-install-recommends", *packages]):
        call_apt(words)


def call_apt(words: Sequence[str]) -> None:
    """Call apt-get until it succeeds or a network that is away has had its time.

    Its own tries are of no use then: an address that has refused once it asks no more.
    """
    until = time.monotonic() + OUTAGE_S
    with contextlib.suppress(OSError, subprocess.TimeoutExpired):
        while subprocess.run(
            ["apt-get", *PATIENT, *words], check=False, capture_output=True, timeout=INSTALLING_S
        ).returncode:
            if time.monotonic() > until:
                return
            time.sleep(AGAIN_AFTER_S)


def installed(program: str, package: str) -> str:
    """Return the path of a program, or do without the test."""
    return find(program) or do_without(f"no {program} here: apt-get install {package}")


def do_without(why: str) -> NoReturn:
    """Skip a test that lacks a program; fail it where none may be missing."""
    import pytest  # noqa: PLC0415  programs are installed before it is

    if is_complete():
        pytest.fail(f"{why} (CI_APT=1 says that all are here)")
    pytest.skip(f"{why}, or set CI_APT=1")


if __name__ == "__main__":
    install_missing(PACKAGES)
