"""A study flown in parts, by as many machines as one has, is the file of one process."""

import re
import shutil
from pathlib import Path

import pytest
from click.testing import Result
from helpers.typed import type_command

from trainer.analysis.sweep.job import Job, fly_chunk, job_of
from trainer.analysis.sweep.sweep import (
    BatchChunks,
    Share,
    carry_out,
    fly_alone,
    fly_share,
    join_chunks,
)
from trainer.api.subjects import subject_of
from trainer.cli.workshop.sweep import sweep
from trainer.config.files import ConfigError

pytestmark = pytest.mark.process  # a library is imported that takes half a second

MEANDERS = """
schema = "sweep/1"
name = "Short meanders"
measures = ["last z", "largest theta"]
[manoeuvre]
name = "meander"
angle_deg = 10.0
execute_deg = 5.0
duration_s = 20.0
[sample]
plan = "latin-hypercube"
members = {members}
seed = {seed}
[[vary]]
name = "N_v"
key = "vessel.coefficients.N_v"
distribution = "normal"
mean = 1.0
std = 0.1
relative = true
"""
MEMBERS = 100  # in 7 chunks


def write_study(folder: Path, seed: int = 3, members: int = MEMBERS) -> Path:
    path = folder / f"meanders{seed}.toml"
    path.write_text(MEANDERS.format(members=members, seed=seed))
    return path


def job(path: Path) -> Job:
    return job_of(str(path), None, subject_of)


def fly_parts(study: Job, folder: Path, count: int) -> list[int]:
    """Fly all parts, the last one first; return how many members were told of each."""
    told = []
    for number in range(count, 0, -1):
        members: list[int] = []
        fly_share(study, fly_alone, Share(number, count), folder, members.append)
        told.append(sum(members))
    return told


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with a study and its result by one process."""
    folder = tmp_path_factory.mktemp("whole")
    carry_out(job(write_study(folder)), fly_alone, folder / "one.parquet", lambda _count: None)
    return folder


@pytest.mark.parametrize("count", [1, 7, 64])
def test_parts_joined_are_the_file_of_one_process(whole: Path, tmp_path: Path, count: int) -> None:
    study, out = job(whole / "meanders3.toml"), tmp_path / "joined.parquet"
    told = fly_parts(study, tmp_path / "parts", count)
    assert sum(told) == MEMBERS
    assert len([each for each in told if each]) == min(count, 7)

    join_chunks(study, tmp_path / "parts", out)

    assert out.read_bytes() == (whole / "one.parquet").read_bytes()


def test_a_part_that_was_killed_flies_what_is_missing(whole: Path, tmp_path: Path) -> None:
    study, parts = job(whole / "meanders3.toml"), tmp_path / "parts"
    flown: list[int] = []

    def dying(_job: Job, indices: list[int]) -> BatchChunks:
        for index in indices:
            if len(flown) == 2:
                raise KeyboardInterrupt
            flown.append(index)
            yield index, fly_chunk(study, index)

    with pytest.raises(KeyboardInterrupt):
        fly_share(study, dying, Share(1, 2), parts, lambda _count: None)
    (parts / "000004.parquet.77.part").write_bytes(b"PAR1")
    fly_share(study, fly_alone, Share(2, 2), parts, lambda _count: None)
    with pytest.raises(
        ConfigError, match=r"2 of 7 chunks are missing: 000004, 000006; run the par"
    ):
        join_chunks(study, parts, tmp_path / "joined.parquet")
    flown.clear()

    fly_share(study, dying, Share(1, 2), parts, lambda _count: None)

    assert flown == [4, 6]
    join_chunks(study, parts, tmp_path / "joined.parquet")
    assert (tmp_path / "joined.parquet").read_bytes() == (whole / "one.parquet").read_bytes()


def test_parts_of_another_study_and_a_file_that_was_cut_are_named(
    whole: Path, tmp_path: Path
) -> None:
    study, other = job(whole / "meanders3.toml"), job(write_study(tmp_path, seed=4))
    parts, out = tmp_path / "parts", tmp_path / "joined.parquet"
    fly_parts(study, parts, 2)
    with pytest.raises(ConfigError, match="parts: is of another study"):
        fly_share(other, fly_alone, Share(1, 2), parts, lambda _count: None)
    with pytest.raises(ConfigError, match="parts: is of another study"):
        join_chunks(other, parts, out)
    fly_parts(other, tmp_path / "others", 1)
    shutil.copy(tmp_path / "others" / "000003.parquet", parts)
    with pytest.raises(ConfigError, match=r"000003.parquet: is of another study: delete it"):
        join_chunks(study, parts, out)
    data = (parts / "000002.parquet").read_bytes()
    (parts / "000002.parquet").write_bytes(data[: len(data) // 2])
    with pytest.raises(ConfigError, match=r"000002.parquet: cannot be read .* delete it"):
        join_chunks(study, parts, out)
    assert not out.exists()


def type_sweep(*words: object) -> Result:
    return type_command(sweep, *words)


def test_the_command_flies_parts_and_joins_them(
    whole: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    study = whole / "meanders3.toml"
    for number, members in ((1, 52), (2, 48)):
        done = type_sweep(study, "--part", f"{number}/2", "--parts", "parts", "--jobs", 1)
        assert f"part {number}/2: {members} members in {5 - number} chunks are in parts" in (
            done.stdout
        )
    assert not [*tmp_path.glob("*.parquet")]
    done = type_sweep(study, "--join", "parts", "--out", "r.parquet")
    assert "100" in done.stdout
    assert Path("r.parquet").read_bytes() == (whole / "one.parquet").read_bytes()
    assert Path("parts").exists()  # they are the user's


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["--part", "1/2"], "--part I/N and --parts FOLDER go together"),
        (["--parts", "parts"], "--part I/N and --parts FOLDER go together"),
        (["--part", "3/2", "--parts", "parts"], '--part "3/2": must be such as 3/64'),
        (["--part", "0/2", "--parts", "parts"], '--part "0/2": must be such as 3/64'),
        (["--part", "one", "--parts", "parts"], '--part "one": must be such as 3/64'),
        (["--part", "1/2", "--parts", "parts", "--out", "a.parquet"], "--out is for --join"),
        (["--join", "nothing"], "nothing: has no parts of a study"),
    ],
)
def test_what_is_asked_wrongly_is_told_before_anything_is_flown(
    whole: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, words: list[str], told: str
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(ConfigError, match=re.escape(told)):
        type_sweep(whole / "meanders3.toml", *words)
    assert [*tmp_path.iterdir()] == []
