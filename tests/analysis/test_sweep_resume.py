"""What is finished of a study stays finished, and the result is the same however it was flown."""

import contextlib
import json
import os
import random
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pyarrow.parquet as pq
import pytest
from helpers.nursery import start_trainer
from helpers.waiting import await_that

from trainer.analysis.sweep.job import Batch, Job, fact_differences, fly_chunk, job_of
from trainer.analysis.sweep.sweep import BatchChunks, carry_out, fly_alone, folder_of, process_crew
from trainer.api.subjects import subject_of
from trainer.cli.main import main
from trainer.config.files import ConfigError
from trainer.core import digest

pytestmark = pytest.mark.process  # fits are compiled, and studies flown in processes

TURNS = """
schema = "sweep/1"
name = "Short turns"
measures = ["advance", "steady speed"]
[manoeuvre]
name = "turn"
duration_s = {seconds}
[sample]
plan = "latin-hypercube"
members = {members}
seed = 3
[[vary]]
name = "N_v"
key = "vessel.coefficients.N_v"
distribution = "normal"
mean = 1.0
std = 0.1
relative = true
"""


HOLDER = """
import sys, threading
from pathlib import Path
from trainer.analysis.sweep.sweep import writing_alone

with writing_alone(Path(sys.argv[1])):
    print("holds it", flush=True)
    threading.Event().wait()
"""


def study(folder: Path, members: int = 1600, seconds: float = 20.0) -> Path:
    """Write a study of short turns, 512 members a chunk."""
    path = folder / "turns.toml"
    path.write_text(TURNS.format(members=members, seconds=seconds))
    return path


def nothing(count: int) -> None:
    """Take the progress."""


def fly(name: Path, out: Path, crew: object = fly_alone) -> list[int]:
    """Carry a study out; return the chunks that were flown for it."""
    flown: list[int] = []

    def counting(job: Job, places: list[int]) -> BatchChunks:
        for place, batch in crew(job, places):  # type: ignore[operator]
            flown.append(place)
            yield place, batch

    carry_out(job_of(str(name), None, subject_of), counting, out, nothing)
    return sorted(flown)


def breaking(after: int) -> object:
    """Return a crew that goes down after so many chunks."""

    def crew(job: Job, places: list[int]) -> Iterator[tuple[int, Batch]]:
        for place in reversed(places):
            if len(places) - place > after:
                raise InterruptedError
            yield place, fly_chunk(job, place)

    return crew


def begun(folder: Path) -> tuple[Path, Path]:
    """Return a study, and its result of which one chunk is finished."""
    path, out = study(folder), folder / "a.parquet"
    with pytest.raises(ConfigError):
        fly(path, out, breaking(1))
    return path, out


def test_members_finished_before_an_interruption_are_not_flown_again(tmp_path: Path) -> None:
    path, out, whole = study(tmp_path), tmp_path / "a.parquet", tmp_path / "b.parquet"
    with pytest.raises(ConfigError):
        fly(path, out, breaking(2))
    assert sorted(file.name for file in folder_of(out).glob("*.parquet")) == [
        "000002.parquet",
        "000003.parquet",
    ]

    assert fly(path, out) == [0, 1]
    assert fly(path, whole) == [0, 1, 2, 3]
    assert out.read_bytes() == whole.read_bytes()
    assert not folder_of(out).exists()
    assert fly(path, out) == []  # the result is there


def test_processes_in_any_order_give_the_file_of_one(tmp_path: Path) -> None:
    path, one, two = study(tmp_path), tmp_path / "one.parquet", tmp_path / "two.parquet"
    fly(path, one)

    assert fly(path, two, process_crew(2)) == [0, 1, 2, 3]
    assert two.read_bytes() == one.read_bytes()


def test_a_chunk_half_written_is_flown_again(tmp_path: Path) -> None:
    path, out = begun(tmp_path)
    half = folder_of(out) / "000002.parquet.77.part"
    half.write_bytes(b"PAR1")

    assert fly(path, out) == [0, 1, 2]
    assert pq.read_table(out).column("member").to_pylist() == list(range(1600))


def test_a_changed_study_is_refused_with_what_differs(tmp_path: Path) -> None:
    path, out = begun(tmp_path)
    path.write_text(path.read_text().replace("std = 0.1", "std = 0.2"))

    with pytest.raises(ConfigError) as refused:
        fly(path, out)
    assert refused.value.problems[0].startswith(f"{folder_of(out)}: is of another study")
    assert refused.value.problems[1:] == ("turns.toml, line 17: 'std = 0.1' then, 'std = 0.2' now",)


def test_a_study_is_the_same_from_wherever_it_is_typed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = study(tmp_path, members=600)
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path)
    results: list[bytes] = []
    for typed in ("turns.toml", "./turns.toml", "elsewhere/../turns.toml", str(path)):
        out = tmp_path / f"{len(results)}.parquet"
        with pytest.raises(ConfigError):
            fly(Path("turns.toml"), out, breaking(1))
        assert carry_out(job_of(typed, None, subject_of), fly_alone, out, nothing).num_rows == 600
        results.append(out.read_bytes())
    assert set(results) == {results[0]}


def test_what_an_earlier_version_began_under_a_path_goes_on(tmp_path: Path) -> None:
    path, out = begun(tmp_path)
    manifest = folder_of(out) / "manifest.json"
    facts = json.loads(manifest.read_text())
    facts["files"][str(path)] = facts["files"].pop("turns.toml")
    manifest.write_text(json.dumps({**facts, "study": str(path)}))

    assert fly(path, out) == [0, 1, 2]


def test_a_second_sweep_that_would_write_the_same_result_is_told_which_process_does(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    path, out = study(tmp_path), tmp_path / "a.parquet"
    ends: list[object] = []

    def meanwhile(job: Job, places: list[int]) -> BatchChunks:
        for place, batch in fly_alone(job, places):
            if not ends:
                with pytest.raises(SystemExit) as end:
                    main()
                ends.append(end.value.code)
            yield place, batch

    monkeypatch.setattr(sys, "argv", ["trainer", "sweep", str(path), "--out", str(out)])
    assert fly(path, out, meanwhile) == [0, 1, 2, 3]
    assert ends == [2]
    told = f"another sweep writes it, process {os.getpid()}: wait for it, or give --out another"
    assert capsys.readouterr().err == f"trainer: {out}: {told} name\n"
    assert pq.read_table(out).num_rows == 1600
    assert not folder_of(out).exists()


def test_a_sweep_that_is_killed_keeps_nobody_from_its_result(tmp_path: Path) -> None:
    path, out = study(tmp_path, members=600), tmp_path / "a.parquet"
    holder = subprocess.Popen(
        [sys.executable, "-c", HOLDER, str(out)], stdout=subprocess.PIPE, text=True
    )
    assert holder.stdout
    assert holder.stdout.readline() == "holds it\n"
    with pytest.raises(ConfigError, match=f"process {holder.pid}: wait for it"):
        fly(path, out)
    holder.kill()
    holder.communicate(timeout=60)

    assert fly(path, out) == [0, 1]


def test_a_folder_that_is_not_there_is_told_and_not_made(tmp_path: Path) -> None:
    out = tmp_path / "none" / "a.parquet"
    with pytest.raises(ConfigError, match=r"a\.parquet: cannot be written: No such file"):
        fly(study(tmp_path), out)
    assert not out.parent.exists()


def test_another_core_is_refused_and_told(tmp_path: Path) -> None:
    path, out = begun(tmp_path)
    manifest = folder_of(out) / "manifest.json"
    facts = json.loads(manifest.read_text())
    manifest.write_text(json.dumps({**facts, "core": "0123456789abcdef"}))

    with pytest.raises(ConfigError, match="core: '0123456789abcdef' then, "):
        fly(path, out)


def test_a_result_of_another_study_is_not_written_over(tmp_path: Path) -> None:
    path, out = study(tmp_path), tmp_path / "a.parquet"
    fly(path, out)
    before = out.read_bytes()
    path.write_text(path.read_text().replace("seed = 3", "seed = 4"))

    with pytest.raises(ConfigError, match="is the result of another study: delete it"):
        fly(path, out)
    assert out.read_bytes() == before
    out.write_text("my notes")
    with pytest.raises(ConfigError, match="no result of a study"):
        fly(path, out)
    assert out.read_text() == "my notes"


def test_a_result_tells_all_it_follows_from(tmp_path: Path) -> None:
    path, out = study(tmp_path, members=10), tmp_path / "a.parquet"
    fly(path, out)
    schema = pq.read_schema(out)

    facts = json.loads(schema.metadata[b"trainer.sweep"])
    assert facts["study"] == "turns"
    assert facts["files"]["turns.toml"] == path.read_text()
    assert "configs/vessels/bb2.toml" in facts["files"]
    assert schema.names == ["member", "seed", "N_v", "advance", "steady speed", "trouble"]
    assert schema.field("steady speed").metadata == {b"unit": b"m/s"}


def test_a_study_is_flown_from_what_was_read_and_no_file_else(tmp_path: Path) -> None:
    path = study(tmp_path, members=10)
    job = job_of(str(path), None, subject_of)
    path.unlink()

    assert fly_chunk(job, 0).troubles == (None,) * 10


def test_another_machines_core_does_not_fly_along(tmp_path: Path) -> None:
    job = job_of(str(study(tmp_path, members=10)), None, subject_of)
    other = Job(job.name, job.members, job.texts, job.version, "0123456789abcdef", job.make)

    with pytest.raises(ConfigError, match="update it"):
        fly_chunk(other, 0)


def start(path: Path, out: Path, jobs: int) -> subprocess.Popen[bytes]:
    """Start the program."""
    words = [sys.executable, "-m", "trainer", "sweep", str(path), "--out", str(out)]
    return subprocess.Popen(
        [*words, "--jobs", str(jobs)],
        cwd=path.parent,
        stdout=subprocess.DEVNULL,
    )


def children(pid: int) -> set[int]:
    """Return the processes that a process has started, by Linux."""
    found = set()
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = stat.read_text().rpartition(")")[2].split()
        except OSError:
            continue
        if int(fields[1]) == pid and fields[0] != "Z":
            found.add(int(stat.parent.name))
    return found


def kept(out: Path) -> dict[str, int]:
    """Return the finished chunks and when they were written; all go once they are joined."""
    found = {}
    for file in folder_of(out).glob("*.parquet"):
        with contextlib.suppress(FileNotFoundError):
            found[file.name] = file.stat().st_mtime_ns
    return found


@pytest.mark.slow
@pytest.mark.long
def test_killed_at_any_instant_and_run_again_no_finished_member_is_lost(tmp_path: Path) -> None:
    path = study(tmp_path, members=6000, seconds=40.0)
    out, dice = tmp_path / "killed.parquet", random.Random(8)  # noqa: S311
    before: dict[str, int] = {}
    for _ in range(int(os.environ.get("TRAINER_KILLS", "3"))):
        program = start(path, out, jobs=2)
        found = len(before)
        await_that(lambda: len(kept(out)) > found or program.poll() is not None)  # noqa: B023
        time.sleep(dice.uniform(0.0, 0.2))  # any instant of what comes then
        crew = children(program.pid)
        program.kill()
        program.wait()
        if out.exists():
            break
        after = kept(out)
        assert before.items() <= after.items()
        before = after
        # the crew goes with its captain
        await_that(lambda: not any(Path(f"/proc/{pid}").exists() for pid in crew))  # noqa: B023
    assert before or out.exists()  # a fast machine may be through

    program = start(path, out, jobs=1)
    assert program.wait() == 0
    whole = tmp_path / "whole.parquet"
    fly(path, whole)
    assert out.read_bytes() == whole.read_bytes()


@pytest.mark.slow
@pytest.mark.long
def test_an_interrupt_says_how_to_go_on(tmp_path: Path) -> None:
    path, out = study(tmp_path, members=6000, seconds=40.0), tmp_path / "a.parquet"
    program = start_trainer(
        "sweep",
        str(path),
        "--out",
        str(out),
        "--jobs",
        "2",
        stderr=subprocess.PIPE,
        stdout=subprocess.DEVNULL,
    )
    await_that(lambda: kept(out) or program.poll() is not None)
    program.send_signal(signal.SIGINT)
    _, said = program.communicate(timeout=60)

    assert program.returncode == 130
    assert "what is finished is kept: run the same command again" in said
    assert "Traceback" not in said
    assert kept(out)


def test_a_chunk_whose_writing_fails_does_not_count(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path, out = study(tmp_path, members=600), tmp_path / "a.parquet"
    job = job_of(str(path), None, subject_of)
    job_folder = folder_of(out)

    def full(_descriptor: int) -> None:
        raise OSError(28, "No space left on device")

    with pytest.raises(ConfigError):
        fly(path, out, breaking(0))  # the manifest is there
    with monkeypatch.context() as disk:
        disk.setattr("os.fsync", full)
        with pytest.raises(ConfigError, match="cannot be written: No space left on device"):
            carry_out(job, fly_alone, out, nothing)
    assert not list(job_folder.glob("*.parquet"))
    assert fly(path, out) == [0, 1]


def test_a_sweep_of_a_core_that_computes_the_same_bits_goes_on(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    now = {"study": "s", "members": 3, "version": "1", "core": digest.core_digest(), "files": {}}
    then = now | {"core": "of yesterday", "files": {"configs/terms_2510.toml": "long ago"}}
    assert fact_differences(then, now) == [
        f"core: 'of yesterday' then, {digest.core_digest()!r} now"
    ]

    monkeypatch.setattr(digest, "SAME_BITS", frozenset({"of yesterday"}))

    assert fact_differences(then, now) == []
