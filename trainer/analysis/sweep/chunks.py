"""Finished members on disk: a folder, a file for each chunk, and a manifest.

A member is one run of a study, a chunk some members that one process flies. ``sweep`` keeps each
chunk when it is done, so that an interrupted sweep goes on where it was; the manifest says of which
study they are.
"""

import contextlib
import json
import shutil
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from trainer.analysis.sweep.job import Batch, Job, fact_differences
from trainer.analysis.sweep.results import facts_of, read_table, table_of, write_table
from trainer.config.files import ConfigError
from trainer.io.file_lock import holding
from trainer.io.outputs import renew_whole

MANIFEST_NAME: Final = "manifest.json"
LOCK_NAME: Final = "lock"  # held by the process that writes there


@dataclass(frozen=True)
class ChunkStore:
    """The chunks of one job that are on disk."""

    folder: Path
    schema: Any
    chunks: int

    def file(self, index: int) -> Path:
        """Return the path of a chunk's file."""
        return self.folder / f"{index:06d}.parquet"

    def finished(self) -> set[int]:
        """Return the numbers of the chunks on disk."""
        return {index for index in range(self.chunks) if self.file(index).exists()}

    def keep(self, index: int, batch: Batch) -> None:
        """Write a chunk; OSError if it cannot be."""
        write_table(table_of(batch, self.schema), self.file(index))

    def tables(self) -> Iterator[Any]:
        """Yield the chunks in their order; ConfigError naming one that cannot be read."""
        for index in range(self.chunks):
            try:
                yield read_table(self.file(index))
            except OSError as wrong:
                text = f"{self.file(index)}: cannot be read ({wrong}): delete it, and run again"
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
        folder.mkdir(exist_ok=True)
        with contextlib.ExitStack() as lock:
            if other := lock.enter_context(holding(folder / LOCK_NAME)):
                text = f"another sweep writes it, process {other}: wait for it, or give --out"
                raise ConfigError(f"{out}: {text} another name")
            yield
    except OSError as error:
        raise ConfigError(f"{out}: cannot be written: {error.strerror or error}") from None


def take_up(job: Job, schema: Any, chunks: int, out: Path) -> ChunkStore:
    """Return a job's folder, new or as it was left; ConfigError if another job's."""
    folder = folder_of(out)
    manifest = folder / MANIFEST_NAME
    try:
        folder.mkdir(exist_ok=True)
        if manifest.exists():
            _compare(json.loads(manifest.read_text(encoding="utf-8")), job, folder, "is of")
        else:
            renew_whole(manifest, json.dumps(job.facts, indent=1, sort_keys=True))
        for stray in (*folder.glob("*.part"), *folder.glob(".*/*")):  # of a writer that was killed
            stray.unlink(missing_ok=True)
    except OSError as error:
        raise ConfigError(f"{folder}: cannot be written: {error.strerror}") from None
    except (json.JSONDecodeError, UnicodeDecodeError):
        raise ConfigError(f"{manifest}: is no manifest: delete {folder}, or give --out") from None
    return ChunkStore(folder, schema, chunks)


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
