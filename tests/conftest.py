"""Boats for the tests."""

import gc
import math
import os
import signal
import subprocess
import sys
from collections.abc import Callable, Generator, Iterator
from functools import partial
from pathlib import Path

import hypothesis
import pytest
from helpers import boats
from helpers.installation import PACKAGES, SLOW_PACKAGES, install_missing

from trainer.boat.boat import Boat

NEEDING_THE_CORE_ALONE = ("core", "core and not slow", "laws")  # what is chosen by -m
WAITING = ("web", "session", "console")  # folders of tests that mostly wait, for ticks and pages
pytest_plugins = [
    *("helpers.browser", "helpers.crewed", "helpers.few_points", "helpers.once_more"),
    *("helpers.pilots", "helpers.process_guard"),
]
# One commit, one verdict: the same examples each time, however slow the machine.
hypothesis.settings.register_profile("steady", deadline=None, derandomize=True)
hypothesis.settings.load_profile("steady")
# What is tested is what is installed, in all that the tests start as well: not what lies beside.
os.environ["PYTHONSAFEPATH"] = "1"
# Bytecode is kept, or each of many hundred starts compiles every source anew, for seconds.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
sys.dont_write_bytecode = False
# pytest-xdist's workers ignore Ctrl-C, and so would all that they start.
signal.signal(signal.SIGINT, signal.default_int_handler)
gc.disable()  # what is imported and collected is no garbage, and nothing looks through it for some


@pytest.hookimpl(trylast=True)
def pytest_collection_finish() -> None:
    """Let garbage be looked for in what the tests make, and in nothing else."""
    gc.freeze()
    gc.enable()


def pytest_configure(config: pytest.Config) -> None:
    """Have each process begin to collect at another file, so that each compiles others.

    What one has compiled the others read, where all who go the same way compile everything.
    """
    worker, count = (os.environ.get(f"PYTEST_XDIST_WORKER{end}", "") for end in ("", "_COUNT"))
    if worker and config.args_source is not pytest.Config.ArgsSource.ARGS:
        folder = Path(__file__).parent
        files = sorted(map(str, folder.rglob("test_*.py")))
        first = len(files) * int(worker.removeprefix("gw")) // int(count)
        config.args[:] = files[first:] + files[:first]


def pytest_sessionstart(session: pytest.Session) -> None:
    """Begin to compile what several processes would compile side by side: the core and fits.

    A boat's core comes with the package, except where settings of numba ask for other code; it is
    waited for. Fits, and ships that are not linear, go on beside the first tests, because their
    own tests come late. Who names files of tests waits for the core alone: what else those need
    they compile. Programs are installed, where that is allowed, unless no test starts any.
    """
    if not getattr(session.config.option, "numprocesses", None):
        return
    gc.enable()  # the workers collect, and not this process
    core, chosen = started("helpers.core"), session.config.option.markexpr
    named = session.config.args_source is pytest.Config.ArgsSource.ARGS
    if named or chosen in NEEDING_THE_CORE_ALONE:
        assert_done(core)
        return
    fits = started("helpers.fitted")
    if "not process" not in chosen:
        install_missing(PACKAGES | (SLOW_PACKAGES if chosen == "slow" else {}))
    assert_done(core)
    session.config.add_cleanup(partial(assert_done, fits))


@pytest.hookimpl(wrapper=True)
def pytest_xdist_auto_num_workers() -> Generator[None, int, int]:
    """Let ``-n auto`` start one process more than there are processors, because tests wait too."""
    return (yield) + 1


def assert_done(process: subprocess.Popen[bytes]) -> None:
    """Wait for a process that is to succeed."""
    assert process.wait() == 0, process.args


def started(*words: str) -> subprocess.Popen[bytes]:
    """Start a module, or a command, that is silent."""
    return subprocess.Popen(
        [sys.executable, "-m", *words],
        stdout=subprocess.DEVNULL,
        env=os.environ | {"PYTHONPATH": str(Path(__file__).parent)},
    )


@pytest.hookimpl(trylast=True)  # of those that are chosen
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Begin with tests that wait in half of the processes, with those that compute in the others.

    Each process takes its share as it stands here, and what others have left over. Tests of fits
    come late, when these are compiled.
    """
    items.sort(key=lambda item: item.path)  # which processes collect in orders of their own
    items.sort(key=lambda item: item.path.parent.name == "identify")
    processes = int(os.environ.get("PYTEST_XDIST_WORKER_COUNT", "1"))
    half = max(processes // 2, 1)
    waiting = [item for item in items if item.path.parent.name in WAITING]
    computing = [item for item in items if item.path.parent.name not in WAITING]
    few = math.ceil(len(waiting) / half)
    beside = max(len(items) // processes - few, 0)
    items.clear()
    for i in range(half):
        items += waiting[i * few : (i + 1) * few] + computing[i * beside : (i + 1) * beside]
    items += computing[half * beside :]


@pytest.fixture(scope="session", autouse=True)
def elsewhere(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Keep sockets and recordings of the tests, and of what they start, out of the user's own.

    The folders' names are short: a local socket's path has room for a hundred characters.
    """
    with pytest.MonkeyPatch.context() as environment:
        for name in ("XDG_RUNTIME_DIR", "XDG_STATE_HOME"):
            environment.setenv(name, str(tmp_path_factory.mktemp("xdg")))
        yield


@pytest.fixture(scope="session")
def make_boat() -> Callable[..., Boat]:
    """Return a function that makes boats; see helpers.boats."""
    return boats.make_boat


@pytest.fixture(scope="session")
def by_hand() -> Callable[[Boat], None]:
    """Return a function that puts every surface and the propeller in hand as they stand."""
    return boats.take_in_hand
