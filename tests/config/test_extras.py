"""What the plain install lacks is told in one line, with the words that install it."""

import ast
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
import sys
from importlib.abc import MetaPathFinder

class Hidden(MetaPathFinder):
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in HIDDEN:
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)

import importlib.util
found = importlib.util.find_spec
importlib.util.find_spec = lambda name, package=None: (
    None if name.partition(".")[0] in HIDDEN else found(name, package)
)
sys.meta_path.insert(0, Hidden())
sys.argv = ["trainer", *ARGUMENTS]
from trainer.__main__ import main
main()
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
NEEDING = [  # what is hidden, what is typed, what is told
    (("scipy",), "prbs bb2", "scipy"),
    (("scipy",), "identify study.toml", "scipy"),
    pytest.param(
        *(("matplotlib",), "sea sea-state-5 --plot sea.svg", "matplotlib"), marks=pytest.mark.slow
    ),
    (("matplotlib",), "manoeuvre turning-circle bb2 --plot turn.svg", "matplotlib"),
    (("pyarrow",), "sweep study.toml --out out.parquet", "pyarrow"),
    (("distributed",), "sweep study.toml --out out.parquet --scheduler tcp://h:1", "distributed"),
    (("pyarrow",), "export run.trainer --parquet out", "pyarrow"),
    (("rerun",), "export run.trainer --rrd out.rrd", "rerun"),
]


def without(hidden: tuple[str, ...], line: str, folder: Path) -> subprocess.CompletedProcess[str]:
    """Run a command in a folder where libraries are not installed."""
    program = HIDING.replace("HIDDEN", repr(hidden)).replace("ARGUMENTS", repr(line.split()))
    return subprocess.run(
        [sys.executable, "-c", program],
        cwd=folder,
        env=environment(),
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("recording")
    line = "run --headless --speed max --duration 5 --record run.trainer"
    done = without((), line, folder)
    assert done.returncode == 0, done.stderr
    return folder / "run.trainer"


@pytest.mark.process
@pytest.mark.parametrize(("hidden", "line", "library"), NEEDING, ids=str)
def test_a_command_that_needs_an_extra_names_it_in_one_line(
    hidden: tuple[str, ...], line: str, library: str, recording: Path, tmp_path: Path
) -> None:
    (tmp_path / "study.toml").write_text(STUDY, encoding="utf-8")
    (tmp_path / "run.trainer").write_bytes(recording.read_bytes())

    done = without(hidden, line, tmp_path)

    assert done.returncode == 2, done.stderr
    assert done.stderr.count("\n") == 1, done.stderr
    assert library in done.stderr
    assert f"pip install '{PACKAGE_NAME}[{EXTRA_BY_LIBRARY[library]}]'" in done.stderr


@pytest.mark.process
def test_a_run_without_the_viewer_says_so_and_sails(tmp_path: Path) -> None:
    line = "run --headless --speed max --duration 5 --no-record --rrd out.rrd"

    done = without(("rerun",), line, tmp_path)

    assert done.returncode == 0, done.stderr
    assert f"--rrd needs rerun: pip install '{PACKAGE_NAME}[rerun]'" in done.stderr
    assert "Traceback" not in done.stderr


@pytest.mark.process
def test_the_plain_install_checks_a_boat_and_flies_an_exercise(tmp_path: Path) -> None:
    for line in ("check bb2", "exercise check depth-changes", "manoeuvre turning-circle bb2"):
        done = without(tuple(EXTRA_BY_LIBRARY), line, tmp_path)

        assert done.returncode == 0, done.stderr


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
