"""What waits for the clock is tried once more, alone, and told; nothing else is."""

import subprocess
import sys
from pathlib import Path

import pytest
from helpers import places, waiting
from helpers.lanes import sample_cases
from helpers.waiting import await_begun

FLAKY = """
import pathlib, pytest
MARK = pathlib.Path(__file__).with_name("seen")
@pytest.mark.clock
def test_flaky():
    seen = MARK.exists()
    MARK.touch()
    assert seen, "the machine was busy"
"""
BUSY = "  E       AssertionError: the machine was busy"
TEARDOWN = """
import pathlib, pytest
MARK = pathlib.Path(__file__).with_name("torn")
@pytest.fixture
def torn():
    yield
    seen = MARK.exists()
    MARK.touch()
    assert seen
@pytest.mark.clock
def test_flaky_at_its_end(torn):
    pass
"""
TWICE = """
import pytest
@pytest.mark.clock
def test_late_always():
    assert False
"""
PURE = """
def test_wrong():
    assert False
"""
CASES: dict[str, tuple[list[str], int, list[str]]] = {  # tests; exit code, what is told
    "flaky": ([FLAKY], 0, ["FLAKY, passed alone: test_0.py::test_flaky", BUSY, "1 flaky"]),
    "flaky at its end": ([TEARDOWN], 0, ["FLAKY, passed alone"]),
    "fails twice": ([TWICE], 1, ["FAILED TWICE, beside others and alone: test_0.py", "1 failed"]),
    "one of two fails twice": ([FLAKY, TWICE], 1, ["FLAKY, passed alone", "FAILED TWICE"]),
    "a pure failure beside it": ([FLAKY, PURE], 1, ["2 failed"]),
    "too many": ([TWICE] * 6, 1, ["6 failed"]),
}


def run_tests(
    folder: Path, texts: list[str], words: tuple[str, ...] = ("-n", "2")
) -> subprocess.CompletedProcess[str]:
    """Run made-up tests in a folder of their own, by two workers if nothing else is said."""
    for number, text in enumerate(texts):
        (folder / f"test_{number}.py").write_text(text)
    (folder / "pytest.ini").write_text("[pytest]\nmarkers =\n clock: waits\n alone: works\n")
    (folder / "conftest.py").write_text('pytest_plugins = ["helpers.once_more"]\n')
    return subprocess.run(
        [sys.executable, "-m", "pytest", "-q", *words],
        cwd=folder,
        env=places.tests_environment(),
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.mark.process
@pytest.mark.parametrize("name", sample_cases(CASES, "too many"))
def test_only_what_waits_for_the_clock_is_tried_again(name: str, tmp_path: Path) -> None:
    texts, code, told = CASES[name]
    done = run_tests(tmp_path, texts)

    assert done.returncode == code, done.stdout
    assert [words for words in told if words not in done.stdout] == [], done.stdout
    kept = tmp_path / ".pytest_cache" / "d" / "flaky" / "flaky.txt"
    listed = kept.read_text() if kept.exists() else ""
    assert listed.count("\n") == done.stdout.count("FLAKY, passed alone")


@pytest.mark.process
@pytest.mark.parametrize(("name", "code"), [("test_any.py", 0), ("test_power.py", 1)])
def test_what_load_disturbs_is_tried_again_alone_but_where_one_failure_is_one(
    name: str, code: int, tmp_path: Path
) -> None:
    (tmp_path / name).write_text(FLAKY.replace("def test", "@pytest.mark.alone\ndef test"))
    done = run_tests(tmp_path, [], ("-m", "alone"))

    assert done.returncode == code
    assert (f"FLAKY, passed alone: {name}::test_flaky" in done.stdout) == (code == 0)


@pytest.mark.alone
@pytest.mark.process
@pytest.mark.parametrize(
    ("program", "wrong"),
    [
        ("import threading; threading.Event().wait()", "nothing has moved"),
        ("while True: pass", "of work, and in vain"),
        ("", "it is over"),
    ],
)
def test_a_process_is_waited_for_as_long_as_it_works(
    program: str, wrong: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(waiting, "PATIENCE", 1.0)
    monkeypatch.setattr(waiting, "MAX_WORK_S", 1.0)
    with subprocess.Popen([sys.executable, "-c", program]) as process:
        try:
            with pytest.raises(AssertionError, match=wrong):
                await_begun(process, lambda: False, lambda: "it is over")
        finally:
            process.kill()
