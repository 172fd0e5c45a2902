"""What the plain install lacks is told in one line, with the words that install it."""

import ast
import json
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
from helpers.places import ROOT, environment
from helpers.syntax import nodes_of

from trainer.config.extras import EXTRA_BY_LIBRARY, PACKAGE_NAME

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
BROUGHT = ("llvmlite", "markupsafe", "rich")  # by numba, jinja2 and textual
IMPORTED_AS = {"pyserial": "serial", "rerun-sdk": "rerun"}
HIDING = """
import contextlib, importlib.util, io, json, sys
from importlib.abc import MetaPathFinder

hidden, lines = json.loads(sys.argv[1])

class Hidden(MetaPathFinder):
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in hidden:
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)

found = importlib.util.find_spec
importlib.util.find_spec = lambda name, package=None: (
    None if name.partition(".")[0] in hidden else found(name, package)
)
sys.meta_path.insert(0, Hidden())
from trainer.__main__ import main
told = []
for line in lines:
    sys.argv, code = ["trainer", *line.split()], 0
    err = io.StringIO()
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(err):
        try:
            main()
        except SystemExit as end:
            code = end.code or 0
    told.append([code, err.getvalue()])
print(json.dumps(told))
"""
STUDY = """
schema = "sweep/1"
name = "one"
[manoeuvre]
name = "turning-circle"
[sample]
plan = "monte-carlo"
seed = 1
members = 2
[[vary]]
name = "angle"
key = "manoeuvre.angle_deg"
distribution = "uniform"
low = 10.0
high = 20.0
"""
FIRST = "run --headless --speed max --duration 5 --record run.trainer"
NEEDING = {  # what is typed, and of what is hidden that tells
    "prbs bb2": "scipy",
    "identify study.toml": "scipy",
    "sea sea-state-5 --plot sea.svg": "matplotlib",
    "manoeuvre turning-circle bb2 --plot turn.svg": "matplotlib",
    "sweep study.toml --out out.parquet": "pyarrow",
    "export run.trainer --parquet out": "pyarrow",
    "export run.trainer --rrd out.rrd": "rerun",
    "run --headless --speed max --duration 5 --record seen.trainer --rrd out.rrd": "rerun",
    "run --headless --speed max --duration 5 --no-record --csv kept.csv --rrd out.rrd": "rerun",
    "serve --speed max --duration 5 --record seen.trainer --rrd out.rrd": "rerun",
}
SPREAD = "sweep study.toml --out out.parquet --scheduler tcp://h:1"
GONE_ON = "resume run.trainer --headless --speed max --duration 9 --rrd out.rrd"
VIEWED = "run --headless --speed max --duration 5 --no-record --rerun"
PLAIN = ["check bb2", "exercise check depth-changes", "manoeuvre turning-circle bb2"]


def without(hidden: list[str], lines: list[str], folder: Path) -> list[tuple[int, str]]:
    """Return what commands end with and tell in one process where libraries are not installed."""
    (folder / "study.toml").write_text(STUDY, encoding="utf-8")
    done = subprocess.run(
        [sys.executable, "-c", HIDING, json.dumps([hidden, lines])],
        cwd=folder,
        env=environment(),
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return [(code, told) for code, told in json.loads(done.stdout.splitlines()[-1])]


@pytest.mark.process
def test_a_command_that_needs_an_extra_names_it_in_one_line_and_no_other_does(
    tmp_path: Path,
) -> None:
    lines = [*PLAIN, FIRST, VIEWED, *NEEDING]
    (tmp_path / "kept.csv").write_text("of a run before")
    told = dict(zip(lines, without(list(EXTRA_BY_LIBRARY), lines, tmp_path), strict=True))
    (told[SPREAD],) = without(["distributed"], [SPREAD], tmp_path)

    assert [(line, *told[line]) for line in (*PLAIN, FIRST, VIEWED) if told[line][0]] == []
    assert f"--rerun needs rerun: pip install '{PACKAGE_NAME}[rerun]'" in told[VIEWED][1]
    assert "Traceback" not in told[VIEWED][1]
    for line, library in (NEEDING | {SPREAD: "distributed"}).items():
        code, text = told[line]
        assert (code, text.count("\n")) == (2, 1), text
        assert library in text
        assert f"pip install '{PACKAGE_NAME}[{EXTRA_BY_LIBRARY[library]}]'" in text
    assert not (tmp_path / "seen.trainer").exists()  # it was refused before it flew
    assert (tmp_path / "kept.csv").read_text() == "of a run before"
    flown = (tmp_path / "run.trainer").read_bytes()
    ((code, text),) = without(["rerun"], [GONE_ON], tmp_path)
    assert (code, "--rrd needs rerun" in text) == (2, True), text
    assert (tmp_path / "run.trainer").read_bytes() == flown


def imported(path: Path) -> set[str]:
    """Return the top names that a source imports, wherever in it."""
    found: set[str] = set()
    for node in nodes_of(path):
        if isinstance(node, ast.Import):
            found |= {alias.name.partition(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            found.add(node.module.partition(".")[0])
    return found


def required(lines: list[str]) -> set[str]:
    """Return the import names of the libraries that lines of pyproject require."""
    names = {re.split(r"[<>=!~ ]", line)[0] for line in lines}
    return {IMPORTED_AS.get(name, name) for name in names}


@pytest.mark.slow
def test_every_library_is_of_the_plain_install_or_has_an_extra() -> None:
    plain = required(PROJECT["dependencies"]) | {"trainer", *BROUGHT}
    for path in sorted((ROOT / "trainer").rglob("*.py")):
        strangers = imported(path) - plain - set(sys.stdlib_module_names) - set(EXTRA_BY_LIBRARY)
        assert not strangers, f"{path}: {strangers}"


def test_every_extra_that_is_told_brings_its_library() -> None:
    for library, extra in EXTRA_BY_LIBRARY.items():
        assert library in required(PROJECT["optional-dependencies"][extra])
