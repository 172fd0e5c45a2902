"""The tools of Node that check the pages, installed once for all tests of this user."""

import hashlib
import os
import re
import shutil
import subprocess
import tempfile
from pathlib import Path
from typing import Final

from helpers.installation import do_without
from helpers.places import ROOT

LISTED: Final = ("package.json", "package-lock.json")
NAMES: Final = "typescript, eslint, axe-core, a screen reader"
INSTALLING_S: Final = 600.0  # [s] a network that is away for two minutes is waited for
# What axe-core finds on a page, and where.
BARRIERS: Final = """async () =>
  (await axe.run(document, { resultTypes: ["violations"] })).violations.map(({ id, nodes }) =>
    `${id}: ${nodes.map((each) => each.target.join(" ")).join(", ")}`)"""
RETRIES: Final = ("--fetch-retries=8", "--fetch-retry-maxtimeout=30000")


def modules() -> Path:
    """Return the folder of the packages that package.json names, or do without the test."""
    given = [ROOT / "tests" / "web" / name for name in LISTED]
    digest = hashlib.sha256(b"".join(path.read_bytes() for path in given)).hexdigest()[:16]
    cache = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    folder = cache / f"submarine-trainer-node-{digest}"
    if not folder.exists():
        if not (shutil.which("npm") and shutil.which("node")):
            do_without("no npm: install the packages nodejs and npm")
        install(given, folder)
    return folder / "node_modules"


def axe() -> str:
    """Return the script of axe-core, which finds barriers."""
    return (modules() / "axe-core" / "axe.min.js").read_text(encoding="utf-8")


def screen_reader() -> str:
    """Return a script that makes ``screenReader``, which says aloud what it reads."""
    folder = modules() / "@guidepup" / "virtual-screen-reader" / "lib" / "esm"
    module = (folder / "index.browser.js").read_text(encoding="utf-8")
    names = re.search(r"export\{.*?(\S+) as virtual\};", module)
    assert names, "the screen reader names its parts otherwise"
    own = module.replace(names[0], "")
    return f"(() => {{ {own}\nglobalThis.screenReader = {names[1].rpartition(',')[2]}; }})()"


def install(given: list[Path], folder: Path) -> None:
    """Install the packages into a folder, whole or not at all."""
    folder.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=folder.parent, ignore_cleanup_errors=True) as name:
        there = Path(name) / "node"
        there.mkdir()
        for path in given:
            shutil.copy(path, there)
        words = ["npm", "ci", "--no-audit", "--no-fund", "--ignore-scripts", *RETRIES]
        try:
            done = subprocess.run(
                words, cwd=there, capture_output=True, text=True, timeout=INSTALLING_S, check=False
            )
        except subprocess.TimeoutExpired:
            do_without(f"npm ci does not answer: no network for {NAMES}")
        if done.returncode:
            do_without(f"npm cannot have {NAMES}: {done.stderr[-200:]}")
        if not folder.exists():  # another process may have been quicker
            there.rename(folder)


def run(script: str, *words: str, folder: Path = ROOT) -> str:
    """Return what a tool says of the pages' scripts, "" where all is good."""
    done = subprocess.run(
        ["node", str(modules() / script), *words],
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
    )
    return done.stdout + done.stderr if done.returncode else ""
