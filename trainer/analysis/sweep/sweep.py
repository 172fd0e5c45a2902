"""A study is carried out by this process, others, or those of a Dask cluster.

``trainer boat sweep`` calls it. The missing chunks are flown, each chunk is kept, and all are
joined to one result.
"""

from collections.abc import Callable, Iterator
from concurrent.futures import as_completed
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path
from typing import Any, Final

from trainer.analysis.sweep.job import Batch, Job, OpenJob, fly_chunk, open_job
from trainer.analysis.sweep.results import (
    folder_of,
    join_parts,
    result_of,
    schema_of,
    take_up,
    write_table,
    writing_alone,
)
from trainer.analysis.workers import worker_pool
from trainer.config.extras import require_library
from trainer.config.files import ConfigError

BatchChunks = Iterator[tuple[int, Batch]]
ChunkCrew = Callable[[Job, list[int]], BatchChunks]

SCHEDULER_TIMEOUT: Final = "10s"  # for a scheduler to answer
RESUME_NOTE: Final = "what is finished is kept: run the same command again"


def fly_alone(job: Job, indices: list[int]) -> BatchChunks:
    """Yield chunks flown here, one after the other."""
    for index in indices:
        yield index, fly_chunk(job, index)


def process_crew(count: int) -> ChunkCrew:
    """Return a crew of ``count`` processes; a single chunk, or process, is flown here."""

    def fly(job: Job, indices: list[int]) -> BatchChunks:
        if min(count, len(indices)) < 2:
            yield from fly_alone(job, indices)
            return
        pool = worker_pool(min(count, len(indices)))
        try:
            futures = {pool.submit(fly_chunk, job, index): index for index in indices}
            for future in as_completed(futures):
                yield futures[future], future.result()
        except BrokenProcessPool:
            raise ConfigError(f"a process that flew members has ended; {RESUME_NOTE}") from None
        finally:
            pool.shutdown(wait=True, cancel_futures=True)

    return fly


def cluster_crew(address: str) -> ChunkCrew:
    """Return the workers behind the Dask scheduler at ``address``."""

    def fly(job: Job, indices: list[int]) -> BatchChunks:
        client, library = _client(address)
        try:
            sent = client.scatter(job, broadcast=True, hash=False)
            futures = {client.submit(fly_chunk, sent, i, pure=False): i for i in indices}
            for future in library.as_completed(list(futures), loop=client.loop):
                yield futures[future], future.result()
                future.release()
        except (library.KilledWorker, library.CancelledError) as gone:
            raise ConfigError(f"the cluster has lost a chunk ({gone}); {RESUME_NOTE}") from None
        finally:
            client.close()

    return fly


def _client(address: str) -> tuple[Any, Any]:
    """Return a connection to a scheduler with workers, and its library; ConfigError without."""
    require_library("distributed", "--scheduler")
    import distributed  # noqa: PLC0415 - a second to import, and an extra

    library: Any = distributed
    try:
        client = library.Client(address, timeout=SCHEDULER_TIMEOUT, set_as_default=False)
    except (OSError, ValueError) as wrong:
        raise ConfigError(f"--scheduler {address}: no scheduler answers ({wrong})") from None
    if not client.scheduler_info()["workers"]:
        client.close()
        text = f"--scheduler {address}: it has no workers; start `dask worker {address}`"
        raise ConfigError(text)
    return client, library


ProgressCall = Callable[[int], None]  # takes how many members more are finished


def carry_out(job: Job, crew: ChunkCrew, out: Path, progress: ProgressCall) -> Any:
    """Return the result of a study, in the file ``out``; ConfigError if it cannot be.

    Members that an earlier call finished are not flown again, whoever flew them.
    """
    ready = open_job(job)
    result = result_of(job, out)
    if result is None:
        with writing_alone(out):
            result = result_of(job, out)  # who wrote there before may have finished
            if result is None:
                return _fly_missing(job, ready, crew, out, progress)
    progress(ready.members)
    return result


def _fly_missing(
    job: Job, ready: OpenJob, crew: ChunkCrew, out: Path, progress: ProgressCall
) -> Any:
    """Return the result of a study, flying the chunks that are missing; ConfigError."""
    schema = schema_of(ready)
    parts = take_up(job, schema, ready.chunks, out)
    done = parts.finished()
    size = ready.subject.chunk
    progress(sum(min(size, ready.members - index * size) for index in done))
    missing = [index for index in range(ready.chunks) if index not in done]
    try:
        for index, batch in crew(job, missing):
            parts.keep(index, batch)
            progress(len(batch.members))
        result = join_parts(parts.tables(), job, schema)
        write_table(result, out)
    except OSError as error:
        text = f"{folder_of(out)}: cannot be written: {error.strerror or error}"
        raise ConfigError(text) from None
    parts.clear()
    return result
