"""A pytest plugin: what waits for the clock and fails beside others is tried once more, alone.

A test that is marked `clock` waits for another process, a browser or the clock, so that a busy
machine can fail it. Where nothing but such tests have failed, and few, each is tried again when all
others are through: once, in a process of its own. What passes then is told as FLAKY and kept in a
list; what fails twice is red. All other tests have one verdict.
"""

import subprocess
import sys
from pathlib import Path
from typing import Final

import pytest

MAX_FLAKY: Final = 5  # more are no accident of a busy machine
LIST_NAME: Final = "flaky.txt"  # in pytest's cache: a line for each that passed alone
# What these tests find once in fifty runs is a defect: whoever reads them again may not see it.
ONE_VERDICT: Final = frozenset(
    {
        *("test_admission.py", "test_crash.py", "test_fuzz.py", "test_power.py"),
        *("test_recording.py", "test_same_bits.py", "test_security.py"),
    }
)


class FailureLog:
    """The tests that have failed in any process, and whether each may be tried again."""

    def __init__(self, config: pytest.Config) -> None:
        """Begin with none."""
        self._config = config
        self._is_clock: dict[str, bool] = {}

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Keep a failure."""
        if report.failed:
            before = self._is_clock.get(report.nodeid, True)
            self._is_clock[report.nodeid] = before and waits_for_clock(report)

    @pytest.hookimpl(tryfirst=True)
    def pytest_sessionfinish(self, session: pytest.Session, exitstatus: int) -> None:
        """Try again what may be. Without a second failure the run has none."""
        few = 0 < len(self._is_clock) <= MAX_FLAKY and all(self._is_clock.values())
        if exitstatus != pytest.ExitCode.TESTS_FAILED or not few:
            return
        again = {test: passes_alone(test, self._config.rootpath) for test in self._is_clock}
        self._tell(again)
        if all(again.values()):
            session.exitstatus = pytest.ExitCode.OK

    def _tell(self, again: dict[str, bool]) -> None:
        """Print each test's verdict and keep the list of those that passed alone."""
        terminal = self._config.pluginmanager.getplugin("terminalreporter")
        for test, passed in again.items():
            verdict = "FLAKY, passed alone" if passed else "FAILED TWICE, beside others and alone"
            terminal.write_line(f"\n{verdict}: {test}", yellow=passed, red=not passed)
        for kind in ("failed", "error"):
            reports = terminal.stats.pop(kind, [])
            for report in reports:
                passed = again[report.nodeid]
                terminal.stats.setdefault("flaky" if passed else kind, []).append(report)
                if passed:
                    terminal.write_line("\n".join(error_lines(report)))
        cache = getattr(self._config, "cache", None)
        if cache is None:  # left out by -p no:cacheprovider
            return
        with (cache.mkdir("flaky") / LIST_NAME).open("a", encoding="utf-8") as kept:
            kept.writelines(f"{test}\n" for test, passed in again.items() if passed)


def error_lines(report: pytest.TestReport) -> list[str]:
    """Return what a failure said, which nobody sees again, and where."""
    lines = report.longreprtext.strip().splitlines()
    return [f"  {line}" for line in lines if line.startswith("E ")] + [f"  {lines[-1]}"]


def waits_for_clock(report: pytest.TestReport) -> bool:
    """Return whether a busy machine may have failed a test."""
    return "clock" in report.keywords and Path(report.location[0]).name not in ONE_VERDICT


def pytest_configure(config: pytest.Config) -> None:
    """Listen where there are workers, or what load disturbs is chosen, and in no worker."""
    whole = getattr(config.option, "numprocesses", None) or "alone" in config.option.markexpr
    if whole and not hasattr(config, "workerinput"):
        config.pluginmanager.register(FailureLog(config))


def passes_alone(test: str, folder: Path) -> bool:
    """Return whether a test passes in a process of its own, with no other beside it."""
    isolated = ["-I"] if sys.flags.isolated else []
    words = [sys.executable, *isolated, "-m", "pytest", "-q", "-n", "0", "-m", "", test]
    return subprocess.run(words, cwd=folder, check=False).returncode == 0
