"""The first start of a version: at once, interpreted, and compiled beside for the next one."""

import contextlib
import fcntl
import math
import os
import re
import shutil
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from helpers.waiting import await_that

import trainer
from trainer.boat import compilation
from trainer.config.files import shipped_names
from trainer.core.cache import cache_folder
from trainer.io.recording.recording import Recording
from trainer.session import first_start, run, warm_up
from trainer.session.exercise import BackgroundTask
from trainer.session.options import RunOptions

HERE = Path(trainer.__file__).parents[1]
OPTIONS = RunOptions()
BEHIND = (
    "import sys; from trainer.cli.main import main; sys.argv = ['trainer', *{words}]\ntry: main()\n"
)
ASKED = (
    *("rerun", "scipy.linalg", "textual", "geographiclib", "matplotlib", "pyarrow", "sqlite3"),
    *("serial", "numba", "numpy", "trainer.core"),
)


@contextlib.contextmanager
def compiled_by_another(cache: Path) -> Iterator[None]:
    """Hold the lock of the process that fills the cache."""
    folder = cache / cache_folder().name
    folder.mkdir(parents=True)
    with compiled_by_another_in(folder):
        yield


@contextlib.contextmanager
def compiled_by_another_in(folder: Path) -> Iterator[None]:
    """Hold the lock of the process that fills a version's folder of the cache."""
    with (folder / compilation.LOCK_NAME).open("wb") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield


def trained(*words: str, cache: Path | None = None, code: str = "") -> "Done":
    """Return what a `trainer` of a process of its own did; with a cache folder, of that one."""
    own = {"NUMBA_CACHE_DIR", "NUMBA_DISABLE_JIT"}
    kept = {name: value for name, value in os.environ.items() if name not in own}
    kept["PYTHONPATH"] = os.pathsep.join([str(HERE), os.environ.get("PYTHONPATH", "")])
    if cache is not None:
        kept["XDG_CACHE_HOME"] = str(cache)
    how = ["-c", code] if code else ["-m", "trainer", *words]
    return subprocess.run(
        [sys.executable, *how], env=kept, capture_output=True, text=True, timeout=900, check=True
    )


Done = subprocess.CompletedProcess[str]


@pytest.mark.clock
@pytest.mark.process
def test_a_first_run_in_real_time_is_interpreted_and_says_so_to_whoever_comes(
    tmp_path: Path,
) -> None:
    with compiled_by_another(tmp_path):
        done = trained(
            "run", "--headless", "--verbose", "--duration", "1", "--speed", "5", cache=tmp_path
        )

    assert done.stderr == (
        "First start: still preparing in the background (0 %). You can sail now; "
        "only fast time has to wait.\n"
    )
    assert "adams2 at 0.5 s, interpreted" in done.stdout
    assert "overruns 0" in done.stdout
    assert not list(tmp_path.rglob("*.nbi"))


@pytest.mark.process
def test_the_interpreted_run_writes_the_bytes_of_the_compiled_one(tmp_path: Path) -> None:
    exercise = ("run", "periscope-depth", "--headless", "--verbose", "--duration", "20", "--speed")
    with compiled_by_another(tmp_path / "cache"):
        slow = trained(
            *(*exercise, "20", "--csv", str(tmp_path / "slow.csv")), cache=tmp_path / "cache"
        )
    quick = trained(*exercise, "max", "--csv", str(tmp_path / "quick.csv"))

    assert "interpreted" in slow.stdout
    assert "interpreted" not in quick.stdout
    assert (tmp_path / "slow.csv").read_bytes() == (tmp_path / "quick.csv").read_bytes()


@contextlib.contextmanager
def all_but_the_mark(cache: Path) -> Iterator[Callable[[], None]]:
    """Hold the lock of a process that has compiled all but says so when what is yielded is called.

    What is compiled on this machine stands for what that process compiles.
    """
    if not compilation.is_kept():
        trained("run", "--headless", "--duration", "1", "--speed", "max")
    marks = [compilation.mark_path("tick").name, compilation.mark_path("complete").name]
    folder = cache / cache_folder().name
    unmarked = shutil.ignore_patterns(compilation.LOCK_NAME, "complete-*", "tick-*")
    shutil.copytree(cache_folder(), folder, copy_function=os.symlink, ignore=unmarked)
    with (folder / compilation.LOCK_NAME).open("wb") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)

        def complete() -> None:
            for name in marks:
                (folder / name).touch()

        yield complete


def once_at_sea(record: Path, do: Callable[[], object]) -> None:
    """Do something a second after a run of another process has begun to record."""
    await_that(record.exists)
    time.sleep(1.0)
    do()


@pytest.mark.clock
@pytest.mark.process
def test_a_first_run_goes_over_to_machine_code_between_two_ticks_with_the_same_bits(
    tmp_path: Path,
) -> None:
    exercise = ("run", "periscope-depth", "--headless", "--verbose", "--duration", "300", "--speed")
    record = tmp_path / "slow.trainer"
    with all_but_the_mark(tmp_path / "cache") as complete:
        watch = threading.Thread(target=once_at_sea, args=(record, complete))
        watch.start()
        slow = trained(
            *(*exercise, "20", "--csv", str(tmp_path / "slow.csv"), "--record", str(record)),
            cache=tmp_path / "cache",
        )
        watch.join()
    quick = trained(*exercise, "max", "--csv", str(tmp_path / "quick.csv"))

    found = re.search(r"adams2 at 0.5 s, interpreted before tick (\d+)", slow.stdout)
    assert found, slow.stdout
    assert 10 < int(found[1]) < 600
    with contextlib.closing(Recording.look(record)) as recording:
        told = [(each.tick + 1, each.text) for each in recording.events()]
    ready = f"compiled code is ready: from tick {found[1]} on"
    assert (int(found[1]), ready) in told
    assert (tmp_path / "slow.csv").read_bytes() == (tmp_path / "quick.csv").read_bytes()
    assert "interpreted" not in quick.stdout


@pytest.mark.clock
@pytest.mark.process
def test_a_first_run_whose_compilation_fails_goes_on_interpreted_and_says_so(
    tmp_path: Path,
) -> None:
    folder = tmp_path / "cache" / cache_folder().name
    record = tmp_path / "slow.trainer"
    run = threading.Thread(
        target=trained,
        args=("run", "--headless", "--duration", "60", "--speed", "10", "--record", record),
        kwargs={"cache": tmp_path / "cache"},
    )
    with compiled_by_another(tmp_path / "cache"):
        run.start()
        once_at_sea(
            record, lambda: (folder / compilation.ERROR_LOG_NAME).write_text("no space left")
        )
    run.join()

    with contextlib.closing(Recording.look(record)) as recording:
        assert "compiling beside has failed" in [each.text for each in recording.events()]


@pytest.mark.process
def test_the_note_is_among_what_whoever_comes_is_told(tmp_path: Path) -> None:
    with compiled_by_another(tmp_path):
        done = trained("run", "--teletype", "--duration", "0.5", cache=tmp_path)

    assert "only fast time has to wait" in " ".join(done.stdout.split())


@pytest.mark.parametrize("exercise", [None, *shipped_names("exercises")])
def test_a_shipped_exercise_in_real_time_need_not_be_compiled_first(exercise: str | None) -> None:
    assert not first_start.is_hurried(RunOptions(exercise=exercise))


@pytest.mark.parametrize(
    "said",
    [
        {"speed": math.inf},
        {"speed": 100.0},
        {"speed": 5.0, "vessel": "remus100"},
        {"step": 0.01},
        {"step": 0.05, "integrator": "rk4"},
        {"integrator": "rkv"},
        {"vessel": "no-such-boat"},
    ],
)
def test_ticks_that_the_interpreter_cannot_make_in_time_are_compiled_for(
    said: dict[str, Any],
) -> None:
    assert first_start.is_hurried(RunOptions(**said, given=frozenset(said)))


def test_what_an_exercise_says_counts_unless_the_user_says_otherwise(tmp_path: Path) -> None:
    path = tmp_path / "quick.toml"
    path.write_text('schema = "exercise/1"\nname = "n"\nbriefing = "b"\nstep_s = 0.01\n')
    options = RunOptions(exercise=str(path))

    assert first_start.is_hurried(options)
    assert not first_start.is_hurried(replace(options, step=0.5, given=frozenset({"step"})))


@pytest.fixture
def empty_cache(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    """Return an empty cache folder of this process, which looks at it without waiting."""
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    monkeypatch.setattr(compilation, "POLL_PERIOD_S", 0.01)
    return tmp_path


@pytest.fixture
def started(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> list[str]:
    """Return what `prepare` does in a process that has not imported a kernel, an empty cache."""
    done: list[str] = []
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    monkeypatch.setattr(compilation, "is_settled", lambda: False)
    monkeypatch.setattr(compilation, "is_interpreted", lambda: False)
    monkeypatch.setattr(compilation, "use_interpreter", lambda: done.append("interpreted"))
    monkeypatch.setattr(subprocess, "Popen", process_of(done))
    return done


def process_of(done: list[str]) -> Callable[..., Any]:
    """Return what stands for starting a process, which holds no lock and ends at once."""

    class Process:
        def __init__(self, *_words: Any, **_how: Any) -> None:
            done.append("process")

        def wait(self) -> int:
            return 0

    return Process


def test_one_process_compiles_however_many_are_started(started: list[str]) -> None:
    first = first_start.prepare_core(OPTIONS)
    with compilation.compilation_lock():
        compilation.write_progress(40)
        second = first_start.prepare_core(OPTIONS)

    assert "(0 %)" in first
    assert "(40 %)" in second
    assert started == ["interpreted", "process", "interpreted"]


@pytest.mark.process
def test_who_makes_a_page_is_told_that_the_boat_is_compiled_and_once(tmp_path: Path) -> None:
    page = str(tmp_path / "boat.html")
    with all_but_the_mark(tmp_path / "cache"):
        first = trained("export-page", page, cache=tmp_path / "cache")
        second = trained("export-page", page, cache=tmp_path / "cache")

    assert first.stderr == "compiling the boat, this once (about a minute) ...\n"
    assert second.stderr == ""
    assert first.stdout == second.stdout


def test_a_run_after_the_cache_is_full_says_nothing(started: list[str]) -> None:
    compilation.mark_compiled()

    assert first_start.prepare_core(OPTIONS) == ""
    assert started == []


def test_what_went_wrong_beside_is_done_again_where_it_is_seen(
    started: list[str], tmp_path: Path
) -> None:
    (tmp_path / compilation.ERROR_LOG_NAME).write_text("OSError: no space left")

    assert first_start.prepare_core(OPTIONS) == ""
    assert started == []


@pytest.mark.process
def test_what_is_compiled_beside_is_what_runs_and_not_what_lies_in_the_folder(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    clone = tmp_path / "clone"
    (clone / "trainer").mkdir(parents=True)
    (clone / "trainer" / "__init__.py").write_text("raise SystemExit('the sources of a clone')")
    monkeypatch.chdir(clone)
    monkeypatch.delenv("PYTHONSAFEPATH")
    folder = tmp_path / "cache" / cache_folder().name
    folder.mkdir(parents=True)
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(folder))
    compilation.mark_compiled()  # it ends when it finds that
    first_start.compile_beside()
    await_compilers()

    assert (cache_folder() / compilation.ERROR_LOG_NAME).read_text() == ""


def await_compilers() -> None:
    """Wait for the processes that compile beside this one."""
    for thread in threading.enumerate():
        if thread.name == "compiling":
            thread.join(60.0)


def test_who_starts_once_the_tick_is_there_is_told_so_and_compiles_the_rest_beside(
    started: list[str],
) -> None:
    compilation.mark_compiled("tick")

    assert first_start.prepare_core(OPTIONS) == first_start.NEARLY_READY
    assert started == ["interpreted", "process"]


@pytest.mark.process
def test_a_process_that_compiles_holds_the_lock_until_it_ends_whoever_started_it(
    empty_cache: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    del empty_cache
    sleeper = [sys.executable, "-c", "import time; time.sleep(600)"]
    begun: list[subprocess.Popen[bytes]] = []
    real = subprocess.Popen

    def start(_words: list[str], *, pass_fds: tuple[int], **_how: Any) -> "subprocess.Popen[bytes]":
        begun.append(real(sleeper, pass_fds=pass_fds))
        return begun[-1]

    monkeypatch.setattr(subprocess, "Popen", start)
    first_start.compile_beside()
    first_start.compile_beside()
    with compilation.compilation_lock() as lock:
        assert lock is None
    assert len(begun) == 1

    begun[0].kill()
    await_compilers()
    first_start.compile_beside()
    assert len(begun) == 2
    begun[1].kill()
    await_compilers()


@pytest.mark.usefixtures("empty_cache")
def test_a_compiling_process_that_died_is_begun_again_a_few_times_at_most() -> None:
    begun: list[int] = []

    there = compilation.await_tick(threading.Event(), lambda _: None, lambda: begun.append(1))

    assert not there
    assert len(begun) == compilation.MAX_RESTARTS


@pytest.mark.usefixtures("empty_cache")
def test_what_was_begun_again_and_succeeds_is_gone_over_to() -> None:
    there = compilation.await_tick(
        threading.Event(), lambda _: None, lambda: compilation.mark_compiled("tick")
    )

    assert there


def test_a_compilation_that_complained_is_not_begun_again(empty_cache: Path) -> None:
    (empty_cache / compilation.ERROR_LOG_NAME).write_text("OSError: no space left")
    begun: list[int] = []

    assert not compilation.await_tick(threading.Event(), lambda _: None, lambda: begun.append(1))
    assert begun == []


@pytest.mark.usefixtures("empty_cache")
def test_how_far_it_is_only_grows_and_ends_at_a_hundred_though_it_is_begun_again() -> None:
    percents: list[int] = []
    ahead = iter([30, 70, 10, 80])  # the third by a process that was begun again

    def go_on() -> None:
        percent = next(ahead, None)
        if percent is None:
            compilation.mark_compiled("tick")
        else:
            compilation.write_progress(percent)

    monkey = pytest.MonkeyPatch()
    with monkey.context() as patched:
        patched.setattr(compilation, "MAX_RESTARTS", 5)
        assert compilation.await_tick(threading.Event(), percents.append, go_on)

    assert percents == [0, 30, 70, 80, 100]


def test_a_line_tells_each_fifth_of_the_way(
    empty_cache: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    del empty_cache
    told: list[str] = []
    session = stand_in(told)

    def compile_(given_up: Any, tell: Callable[[int], None], again: Any) -> bool:
        del given_up, again
        for percent in (0, 3, 19, 20, 39, 61, 100):
            tell(percent)
        return False

    monkeypatch.setattr(compilation, "await_tick", compile_)
    run.await_code(session, lambda: None)
    session.conduct.work.finish()

    assert [text for text in told if "%" in text] == [
        f"preparing in the background: {percent} %" for percent in (20, 61, 100)
    ]


def stand_in(told: list[str]) -> Any:
    """Return what of a session waits for machine code; what it tells goes to the list."""
    work = BackgroundTask(lambda: None)
    log = SimpleNamespace(tell=lambda _kind, text: told.append(text))
    return SimpleNamespace(conduct=SimpleNamespace(work=work), event_log=log, boat=None)


def test_the_tick_comes_before_the_rest_and_has_its_mark_before_the_rest_begins(
    empty_cache: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    del empty_cache
    done: list[str] = []
    monkeypatch.setattr(warm_up, "limit_work", lambda niceness: done.append(f"nicer by {niceness}"))

    def compile_tick(_tell: Callable[[int], None]) -> None:
        done.append("tick")

    def try_out(_boat: Any) -> None:
        done.append("rest")
        assert compilation.is_tick_kept()
        assert not compilation.is_kept()

    monkeypatch.setattr("trainer.boat.first_tick.compile_tick", compile_tick)
    monkeypatch.setattr(warm_up, "try_out", try_out)
    warm_up.precompile()
    warm_up.precompile()

    assert done == ["nicer by 5", "tick", "nicer by 5", "rest"]
    assert compilation.is_kept()


@pytest.mark.slow
def test_the_tick_compiled_alone_is_what_a_run_goes_over_to(tmp_path: Path) -> None:
    trained(
        code="from trainer.boat import compilation, first_tick\n"
        "first_tick.compile_tick(compilation.write_progress)\ncompilation.mark_compiled('tick')",
        cache=tmp_path,
    )
    before = {path.name for path in tmp_path.rglob("*.nb*")}
    (mark,) = tmp_path.rglob("tick-*")
    assert (mark.parent / compilation.PROGRESS_NAME).read_text() == "100"

    exercise = ("run", "periscope-depth", "--headless", "--verbose", "--duration", "20", "--speed")
    with compiled_by_another_in(mark.parent):
        first = trained(*exercise, "20", "--csv", str(tmp_path / "first.csv"), cache=tmp_path)
    later = trained(*exercise, "max", "--csv", str(tmp_path / "later.csv"))

    assert "interpreted before tick" in first.stdout
    assert {path.name for path in tmp_path.rglob("*.nb*")} == before
    assert "interpreted" not in later.stdout
    assert (tmp_path / "first.csv").read_bytes() == (tmp_path / "later.csv").read_bytes()


def test_without_a_folder_that_lasts_nothing_is_compiled_for_later(
    started: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(first_start, "cache_lasts", lambda: False)

    assert "NUMBA_CACHE_DIR" in first_start.prepare_core(OPTIONS)
    assert started == ["interpreted"]


def test_a_cache_speaks_for_the_files_it_was_made_from_alone(
    started: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    del started
    compilation.mark_compiled()
    assert compilation.is_kept()

    monkeypatch.setenv("NUMBA_CPU_NAME", "x86-64")
    assert not compilation.is_kept()


@pytest.mark.slow
def test_the_process_beside_compiles_all_that_a_run_needs_and_ends(tmp_path: Path) -> None:
    trained(code="from trainer.session.warm_up import precompile; precompile()", cache=tmp_path)
    before = {path.name for path in tmp_path.rglob("*.nb*")}
    words = ("run", "steering-jam", "--headless", "--duration", "60", "--speed", "max")

    done = trained(*words, cache=tmp_path)

    assert done.stderr == ""
    assert {path.name for path in tmp_path.rglob("*.nb*")} == before
    assert not list(tmp_path.rglob(compilation.ERROR_LOG_NAME))


@pytest.mark.process
@pytest.mark.parametrize(
    ("words", "needed"),
    [
        (["--help"], set()),
        (["run", "--help"], set()),
        (["attach", "--help"], set()),
        (["exercises"], {"numpy", "numba", "trainer.core", "sqlite3"}),
        (
            ["run", "--headless", "--duration", "0.5", "--speed", "max"],
            {"numpy", "numba", "trainer.core", "sqlite3", "serial", "scipy.linalg"},  # numba's own
        ),
    ],
)
def test_a_command_loads_what_it_uses(words: list[str], needed: set[str]) -> None:
    code = BEHIND.format(words=words) + (
        f"except SystemExit: print([name for name in {ASKED} if name in sys.modules])"
    )

    loaded = trained(code=code).stdout.splitlines()[-1]

    assert set(eval(loaded)) <= needed  # noqa: S307  our own list
