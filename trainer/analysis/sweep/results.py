"""The results of a sweep: batches as Parquet in a folder, then one file."""

import contextlib
import json
import shutil
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np

from trainer.analysis.sweep.job import Batch, Job, Opened, differences
from trainer.config.extras import require_library
from trainer.config.files import ConfigError
from trainer.io.atomic_write import replacing, write_whole
from trainer.io.file_lock import holding

ROWS: Final = 65_536  # of a row group of the result
MEMBER, SEED, TROUBLE = "member", "seed", "trouble"
FACTS: Final = b"trainer.sweep"


def check_pyarrow() -> None:
    """Check that Parquet can be written; ConfigError saying what to install."""
    require_library("pyarrow", "trainer sweep")


def schema_of(opened: Opened) -> Any:
    """Return a result's columns: seeds, numbers drawn, outputs, and why there are none."""
    import pyarrow as pa  # noqa: PLC0415 - half a second, and not always there

    middle = opened.study.draws.middle()
    drawn = [
        pa.field(name, pa.string() if isinstance(value, str) else pa.float64())
        for name, value in middle.items()
    ]
    kept = [
        pa.field(output.name, pa.float64(), metadata={"unit": output.unit})
        for output in opened.subject.outputs
    ]
    first = [pa.field(MEMBER, pa.int64()), pa.field(SEED, pa.int64())]
    return pa.schema([*first, *drawn, *kept, pa.field(TROUBLE, pa.string())])


def table_of(batch: Batch, schema: Any) -> Any:
    """Return a batch as a table; what a member never came to is null."""
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


def write(table: Any, path: Path) -> None:
    """Write a table to a file that appears whole or not at all. OSError if it cannot be."""
    import pyarrow.parquet as pq  # noqa: PLC0415

    with replacing(path) as made:
        pq.write_table(table, made, row_group_size=ROWS)


def read(path: Path) -> Any:
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
    return whole.replace_schema_metadata({FACTS: facts})


def facts_of(table: Any) -> dict[str, Any]:
    """Return the facts that a result follows from. There are none if it is of no study."""
    found: dict[str, Any] = json.loads((table.schema.metadata or {}).get(FACTS, b"{}"))
    return found


# Finished members on disk: a folder, a file for each chunk, and a manifest.


MANIFEST: Final = "manifest.json"
LOCK: Final = "lock"  # held by the process that writes there


@dataclass(frozen=True)
class Parts:
    """The chunks of one job that are on disk."""

    folder: Path
    schema: Any
    chunks: int

    def file(self, place: int) -> Path:
        """Return the path of a chunk's file."""
        return self.folder / f"{place:06d}.parquet"

    def finished(self) -> set[int]:
        """Return the chunks that are there."""
        return {place for place in range(self.chunks) if self.file(place).exists()}

    def keep(self, place: int, batch: Batch) -> None:
        """Write a chunk; OSError if it cannot be."""
        write(table_of(batch, self.schema), self.file(place))

    def tables(self) -> Iterator[Any]:
        """Yield the chunks in their order; ConfigError naming one that cannot be read."""
        for place in range(self.chunks):
            try:
                yield read(self.file(place))
            except OSError as wrong:
                text = f"{self.file(place)}: cannot be read ({wrong}): delete it, and run again"
                raise ConfigError(text) from None

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
        folder.mkdir(parents=True, exist_ok=True)
        with contextlib.ExitStack() as lock:
            if other := lock.enter_context(holding(folder / LOCK)):
                text = f"another sweep writes it, process {other}: wait for it, or give --out"
                raise ConfigError(f"{out}: {text} another name")
            yield
    except OSError as error:
        raise ConfigError(f"{folder}: cannot be written: {error.strerror or error}") from None


def take_up(job: Job, schema: Any, chunks: int, out: Path) -> Parts:
    """Return the folder of a job, new or as it was left. ConfigError if it is another's."""
    folder = folder_of(out)
    manifest = folder / MANIFEST
    try:
        folder.mkdir(parents=True, exist_ok=True)
        if manifest.exists():
            _compare(json.loads(manifest.read_text(encoding="utf-8")), job, folder, "is of")
        else:
            write_whole(manifest, json.dumps(job.facts, indent=1, sort_keys=True))
        for stray in (*folder.glob("*.part"), *folder.glob(".*/*")):  # of a writer that was killed
            stray.unlink(missing_ok=True)
    except OSError as error:
        raise ConfigError(f"{folder}: cannot be written: {error.strerror}") from None
    except (json.JSONDecodeError, UnicodeDecodeError):
        raise ConfigError(f"{manifest}: is no manifest: delete {folder}, or give --out") from None
    return Parts(folder, schema, chunks)


def result_of(job: Job, out: Path) -> Any:
    """Return the result that is there already, None if none is. ConfigError if it is another's."""
    if not out.exists():
        return None
    try:
        table = read(out)
    except OSError:
        raise ConfigError(f"{out}: is there and no result of a study; give --out another") from None
    _compare(facts_of(table), job, out, "is the result of")
    return table


def _compare(facts: dict[str, Any], job: Job, path: Path, verb: str) -> None:
    """Check that facts on disk are the job's; ConfigError with what differs."""
    found = differences(facts, job.facts)
    if found:
        text = f"{path}: {verb} another study: delete it, or give --out another name"
        raise ConfigError(text, *found)
