"""The tools of Node that check the pages, installed once for all tests of this user."""

import hashlib
import os
import shutil
import subprocess
import tempfile
from pathlib import Path
from typing import Final

import pytest

from helpers.places import ROOT

LISTED: Final = ("package.json", "package-lock.json")
PATIENCE: Final = 180.0  # [s]


def modules() -> Path:
    """Return the folder of the packages that tests/web/package.json names; skip without."""
    given = [ROOT / "tests" / "web" / name for name in LISTED]
    digest = hashlib.sha256(b"".join(path.read_bytes() for path in given)).hexdigest()[:16]
    cache = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    folder = cache / f"submarine-trainer-node-{digest}"
    if not folder.exists():
        if not (shutil.which("npm") and shutil.which("node")):
            pytest.skip("no npm: install the packages nodejs and npm")
        install(given, folder)
    return folder / "node_modules"


def install(given: list[Path], folder: Path) -> None:
    """Install the packages into a folder, whole or not at all."""
    folder.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=folder.parent, ignore_cleanup_errors=True) as name:
        there = Path(name) / "node"
        there.mkdir()
        for path in given:
            shutil.copy(path, there)
        words = ["npm", "ci", "--no-audit", "--no-fund", "--ignore-scripts"]
        try:
            done = subprocess.run(
                words, cwd=there, capture_output=True, text=True, timeout=PATIENCE, check=False
            )
        except subprocess.TimeoutExpired:
            pytest.skip("npm ci does not answer: no network for typescript, eslint, axe-core")
        if done.returncode:
            pytest.skip(f"npm cannot have typescript, eslint, axe-core: {done.stderr[-200:]}")
        if not folder.exists():  # another process may have been quicker
            there.rename(folder)


def run(script: str, *words: str) -> str:
    """Return what a tool says of the pages' scripts, "" where all is good."""
    done = subprocess.run(
        ["node", str(modules() / script), *words],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    return done.stdout + done.stderr if done.returncode else ""
