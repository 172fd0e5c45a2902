"""A study on a cluster: a real scheduler and two workers give the file of a run here."""

import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack
from importlib.util import find_spec
from pathlib import Path

import pytest
from click.testing import CliRunner

import trainer
from trainer.analysis.sweep.job import job_of
from trainer.analysis.sweep.sweep import cluster_crew
from trainer.api.subjects import subject_of
from trainer.cli.main import cli
from trainer.config.files import ConfigError

pytestmark = pytest.mark.skipif(not find_spec("distributed"), reason="distributed is missing")
STUDY = """
schema = "sweep/1"
name = "Turns on a cluster"
[manoeuvre]
name = "turn"
duration_s = 20.0
[sample]
plan = "monte-carlo"
members = 1500
seed = 3
[[vary]]
name = "N_v"
key = "vessel.coefficients.N_v"
distribution = "normal"
mean = 1.0
std = 0.1
relative = true
"""


@pytest.fixture
def scheduler(tmp_path: Path) -> Iterator[str]:
    """Yield the address of a scheduler with two worker processes, all on loopback."""
    told = tmp_path / "scheduler.json"
    found = str(Path(trainer.__file__).parents[1]), str(Path(__file__).parents[2])  # and this test
    environment = os.environ | {
        "PYTHONPATH": os.pathsep.join(found),
        "DASK_TEMPORARY_DIRECTORY": str(tmp_path),
    }

    def started(stack: ExitStack, *words: str) -> None:
        program = subprocess.Popen(
            [sys.executable, "-m", *words, "--scheduler-file", str(told), "--no-dashboard"],
            env=environment,
            cwd=tmp_path,
            stderr=subprocess.DEVNULL,
        )
        stack.callback(program.wait)
        stack.callback(program.terminate)

    from distributed import Client  # noqa: PLC0415

    with ExitStack() as stack:
        here = ("--host", "127.0.0.1")
        started(stack, "distributed.cli.dask_scheduler", *here, "--port", "0")
        for _ in range(2):
            one = ("--nthreads", "1", "--nworkers", "1")
            started(stack, "distributed.cli.dask_worker", *here, *one)
        with Client(scheduler_file=str(told), timeout="60s", set_as_default=False) as client:  # type: ignore[no-untyped-call]
            client.wait_for_workers(2, timeout=60)
            address = client.scheduler.address
        yield address


@pytest.mark.process
@pytest.mark.slow
def test_two_workers_behind_a_scheduler_give_the_file_of_a_run_here(
    scheduler: str, tmp_path: Path
) -> None:
    path = tmp_path / "study.toml"
    path.write_text(STUDY)
    here, there = tmp_path / "here.parquet", tmp_path / "there.parquet"

    words = ["sweep", str(path), "--out"]
    ran = CliRunner().invoke(cli, [*words, str(there), "--scheduler", scheduler])
    assert ran.exit_code == 0, ran.output
    assert CliRunner().invoke(cli, [*words, str(here), "--jobs", "1"]).exit_code == 0

    assert there.read_bytes() == here.read_bytes()
    # who flew opened the study once; a worker late to begin may find nothing left to fly
    assert 1 in openings(scheduler).values()
    assert set(openings(scheduler).values()) <= {0, 1}


def openings(address: str) -> dict[str, int]:
    """Return how many studies each worker has opened."""
    from distributed import Client  # noqa: PLC0415

    with Client(address, set_as_default=False) as client:  # type: ignore[no-untyped-call]
        return dict(client.run(opened_here))


def opened_here() -> int:
    """Return how many studies this process has opened."""
    from trainer.analysis.sweep.job import open_job  # noqa: PLC0415

    return open_job.cache_info().misses


def test_a_scheduler_that_is_not_there_is_told(tmp_path: Path) -> None:
    path = tmp_path / "study.toml"
    path.write_text(STUDY)
    job = job_of(str(path), None, subject_of)

    with pytest.raises(ConfigError, match="--scheduler wrong://x: no scheduler answers"):
        next(cluster_crew("wrong://x")(job, [0]))
