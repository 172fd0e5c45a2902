"""Programs of the system that tests use, installed where the environment allows it."""

import contextlib
import os
import shutil
import subprocess

import pytest

PATIENCE = 90.0  # [s]


def install(program: str, package: str, patience: float = PATIENCE) -> str | None:
    """Return the path of a program, installed first where CI_APT=1 allows it; None without."""
    path = f"{os.environ['PATH']}:/usr/sbin"
    if os.environ.get("CI_APT") == "1" and shutil.which(program, path=path) is None:
        for command in (["update"], ["install", "-y", "--no-install-recommends", package]):
            with contextlib.suppress(OSError, subprocess.TimeoutExpired):  # no network, say
                subprocess.run(
                    ["apt-get", *command], check=False, capture_output=True, timeout=patience
                )
    return shutil.which(program, path=path)


def installed(program: str, package: str, patience: float = PATIENCE) -> str:
    """Return the path of a program; where it cannot be had the test is skipped, and says so."""
    found = install(program, package, patience)
    if found is None:
        pytest.skip(f"no {program} here: apt-get install {package}, or set CI_APT=1")
    return found
