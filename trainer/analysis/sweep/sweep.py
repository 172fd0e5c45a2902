"""A study is carried out by this process, others, or those of a Dask cluster.

``trainer boat sweep`` calls it. A member is one run of a study, a chunk some members that one
process flies. The missing chunks are flown, each is kept when it is done, so that an interrupted
sweep goes on where it was, and all are joined to one file; a manifest says of which study they are.
The facts of the study lie in the file itself, so that a result can be flown again and is never
taken for another study's.

Machines without a scheduler of ours fly a share of the chunks each (``fly_share``), into one
folder; ``join_chunks`` makes the file of it that one process would have made.
"""

import contextlib
import json
import shutil
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import as_completed
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np

from trainer.analysis.sweep.job import Batch, Job, OpenJob, fact_differences, fly_chunk, open_job
from trainer.config.extras import require_library
from trainer.config.files import ConfigError
from trainer.io.file_lock import holding
from trainer.io.outputs import renew_whole, replacing
from trainer.workers import worker_pool

ROW_GROUP_ROWS: Final = 65_536  # of a row group of the result
MEMBER_COLUMN, SEED_COLUMN, TROUBLE_COLUMN = "member", "seed", "trouble"
FACTS_KEY: Final = b"trainer.sweep"
DIGEST_KEY: Final = b"trainer.sweep.job"  # of a chunk
MANIFEST_NAME: Final = "manifest.json"
LOCK_NAME: Final = "lock"  # held by the process that writes there

BatchChunks = Iterator[tuple[int, Batch]]
ChunkCrew = Callable[[Job, list[int]], BatchChunks]
MAX_NAMED_CHUNKS: Final = 8
SCHEDULER_TIMEOUT: Final = "10s"  # for a scheduler to answer
RESUME_NOTE: Final = "what is finished is kept: run the same command again"


def check_pyarrow() -> None:
    """Check that Parquet can be written; ConfigError saying what to install."""
    require_library("pyarrow", "trainer boat sweep")


def schema_of(opened: OpenJob) -> Any:
    """Return a result's columns: seeds, numbers drawn, outputs, and why there are none."""
    import pyarrow as pa  # noqa: PLC0415 - half a second, and not always there

    middle = opened.study.draws.middle()
    drawn = [
        pa.field(name, pa.string() if isinstance(value, str) else pa.float64())
        for name, value in middle.items()
    ]
    output_fields = [
        pa.field(output.name, pa.float64(), metadata={"unit": output.unit})
        for output in opened.subject.outputs
    ]
    first = [pa.field(MEMBER_COLUMN, pa.int64()), pa.field(SEED_COLUMN, pa.int64())]
    return pa.schema([*first, *drawn, *output_fields, pa.field(TROUBLE_COLUMN, pa.string())])


def table_of(batch: Batch, schema: Any) -> Any:
    """Return a batch as a table. An output that a member never came to is null."""
    import pyarrow as pa  # noqa: PLC0415

    columns = [
        batch.members,
        batch.seeds,
        *batch.drawn.values(),
        *np.ascontiguousarray(batch.outputs.T),
        list(batch.troubles),
    ]
    arrays = [
        pa.array(column, field.type, from_pandas=True)
        for column, field in zip(columns, schema, strict=True)
    ]
    return pa.table(arrays, schema=schema)


def write_table(table: Any, path: Path) -> None:
    """Write a table to a file that appears whole or not at all. OSError if it cannot be."""
    import pyarrow.parquet as pq  # noqa: PLC0415

    with replacing(path) as made:
        pq.write_table(table, made, row_group_size=ROW_GROUP_ROWS)


def read_table(path: Path) -> Any:
    """Return the table of a file; OSError if it is none, or not whole."""
    import pyarrow as pa  # noqa: PLC0415
    import pyarrow.parquet as pq  # noqa: PLC0415

    try:
        return pq.ParquetFile(path).read()
    except pa.ArrowInvalid as wrong:
        raise OSError(str(wrong)) from None


def join_parts(tables: Iterable[Any], job: Job, schema: Any) -> Any:
    """Return the result: all chunks in their order, and the facts they follow from."""
    import pyarrow as pa  # noqa: PLC0415

    facts = json.dumps(job.facts, sort_keys=True).encode()
    whole = pa.concat_tables([schema.empty_table(), *tables]).combine_chunks()
    return whole.replace_schema_metadata({FACTS_KEY: facts})


def facts_of(table: Any) -> dict[str, Any]:
    """Return the facts that determine a result; none if the file is no study's result."""
    facts: dict[str, Any] = json.loads((table.schema.metadata or {}).get(FACTS_KEY, b"{}"))
    return facts


@dataclass(frozen=True)
class ChunkStore:
    """The chunks of one job that are on disk."""

    folder: Path
    schema: Any
    chunks: int
    digest: str  # of the job

    def file(self, index: int) -> Path:
        """Return the path of a chunk's file."""
        return self.folder / f"{index:06d}.parquet"

    def finished(self) -> set[int]:
        """Return the numbers of the chunks on disk."""
        return {index for index in range(self.chunks) if self.file(index).exists()}

    def keep(self, index: int, batch: Batch) -> None:
        """Write a chunk; OSError if it cannot be."""
        table = table_of(batch, self.schema)
        signed = table.replace_schema_metadata({DIGEST_KEY: self.digest.encode()})
        write_table(signed, self.file(index))

    def tables(self) -> Iterator[Any]:
        """Yield the chunks in their order; ConfigError naming one that is not to be had."""
        for index in range(self.chunks):
            try:
                table = read_table(self.file(index))
            except OSError as wrong:
                text = f"{self.file(index)}: cannot be read ({wrong}): delete it, and run again"
                raise ConfigError(text) from None
            if (table.schema.metadata or {}).get(DIGEST_KEY) != self.digest.encode():
                raise ConfigError(
                    f"{self.file(index)}: is of another study: delete it, and run again"
                )
            yield table

    def clear(self) -> None:
        """Remove the folder, the result being there."""
        shutil.rmtree(self.folder, ignore_errors=True)


def folder_of(out: Path) -> Path:
    """Return where the finished members of a result are while it grows."""
    return out.with_name(f"{out.name}.parts")


@contextlib.contextmanager
def writing_alone(out: Path) -> Iterator[None]:
    """Keep other sweeps from a result inside the block; ConfigError if one writes it."""
    folder = folder_of(out)
    try:
        folder.mkdir(exist_ok=True)
        with contextlib.ExitStack() as lock:
            if other := lock.enter_context(holding(folder / LOCK_NAME)):
                text = f"another sweep writes it, process {other}: wait for it, or give --out"
                raise ConfigError(f"{out}: {text} another name")
            yield
    except OSError as error:
        raise ConfigError(f"{out}: cannot be written: {error.strerror or error}") from None


def take_up(job: Job, folder: Path) -> ChunkStore:
    """Return a job's folder, new or as it was left; ConfigError if another job's."""
    ready = open_job(job)
    manifest = folder / MANIFEST_NAME
    try:
        folder.mkdir(exist_ok=True)
        if manifest.exists():
            _compare(json.loads(manifest.read_text(encoding="utf-8")), job, folder, "is of")
        else:
            renew_whole(manifest, json.dumps(job.facts, indent=1, sort_keys=True))
    except OSError as error:
        raise ConfigError(f"{folder}: cannot be written: {error.strerror}") from None
    except (json.JSONDecodeError, UnicodeDecodeError):
        raise ConfigError(f"{manifest}: is no manifest: delete {folder}, or give --out") from None
    return ChunkStore(folder, schema_of(ready), ready.chunks, job.digest)


def result_of(job: Job, out: Path) -> Any:
    """Return the job's finished result, None without one; ConfigError if it is another job's."""
    if not out.exists():
        return None
    try:
        table = read_table(out)
    except OSError:
        raise ConfigError(f"{out}: is there and no result of a study; give --out another") from None
    _compare(facts_of(table), job, out, "is the result of")
    return table


def _compare(facts: dict[str, Any], job: Job, path: Path, verb: str) -> None:
    """Check that facts on disk are the job's; ConfigError with what differs."""
    problems = fact_differences(facts, job.facts)
    if problems:
        text = f"{path}: {verb} another study: delete it, or give --out another name"
        raise ConfigError(text, *problems)


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
                return _fly_and_join(job, crew, out, progress)
    progress(ready.members)
    return result


def _fly_and_join(job: Job, crew: ChunkCrew, out: Path, progress: ProgressCall) -> Any:
    """Return the result of a study, flying the chunks that are missing; ConfigError."""
    parts = take_up(job, folder_of(out))
    for stray in (*parts.folder.glob("*.part"), *parts.folder.glob(".*/*")):  # a writer was killed
        stray.unlink(missing_ok=True)
    _fly_missing(job, crew, parts, range(parts.chunks), progress)
    result = _join(job, parts, out)
    parts.clear()
    return result


def _fly_missing(
    job: Job, crew: ChunkCrew, parts: ChunkStore, wanted: Sequence[int], progress: ProgressCall
) -> None:
    """Fly those of the chunks wanted that are not on disk, and keep them; ConfigError."""
    done = parts.finished() & set(wanted)
    progress(sum(members_in(job, index) for index in done))
    missing = [index for index in wanted if index not in done]
    try:
        for index, batch in crew(job, missing):
            parts.keep(index, batch)
            progress(len(batch.members))
    except OSError as error:
        text = f"{parts.folder}: cannot be written: {error.strerror or error}"
        raise ConfigError(text) from None


def members_in(job: Job, chunk: int) -> int:
    """Return how many members a chunk has."""
    ready = open_job(job)
    return min(ready.subject.chunk, ready.members - chunk * ready.subject.chunk)


def _join(job: Job, parts: ChunkStore, out: Path) -> Any:
    """Write the result of chunks that are all on disk, and return it; ConfigError."""
    result = join_parts(parts.tables(), job, parts.schema)
    try:
        write_table(result, out)
    except OSError as error:
        raise ConfigError(f"{out}: cannot be written: {error.strerror or error}") from None
    return result


@dataclass(frozen=True)
class Share:
    """One of so many shares of a study's chunks, counted from 1."""

    number: int
    count: int

    def __str__(self) -> str:
        return f"{self.number}/{self.count}"

    def chunks(self, job: Job) -> range:
        """Return the chunks of the share."""
        return range(self.number - 1, open_job(job).chunks, self.count)


def fly_share(
    job: Job, crew: ChunkCrew, share: Share, folder: Path, progress: ProgressCall
) -> None:
    """Fly a share of a study's chunks into a folder that others share.

    What is there is not flown again. ConfigError if the folder is another study's.
    """
    _fly_missing(job, crew, take_up(job, folder), share.chunks(job), progress)


def join_chunks(job: Job, folder: Path, out: Path) -> Any:
    """Write the result of the chunks in a folder; ConfigError naming what lacks."""
    if not (folder / MANIFEST_NAME).exists():
        raise ConfigError(f"{folder}: has no parts of a study: fly them with --part and --parts")
    parts = take_up(job, folder)
    if lacking := sorted(set(range(parts.chunks)) - parts.finished()):
        names = ", ".join(f"{index:06d}" for index in lacking[:MAX_NAMED_CHUNKS])
        more = f" and {len(lacking) - MAX_NAMED_CHUNKS} more" * (len(lacking) > MAX_NAMED_CHUNKS)
        raise ConfigError(
            f"{folder}: {len(lacking)} of {parts.chunks} chunks are missing: {names}{more}; run "
            "the parts again that were interrupted, they fly what is missing"
        )
    return _join(job, parts, out)
