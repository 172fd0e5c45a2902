"""A study is carried out. It flies what is missing, keeps each chunk, and joins one result."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

from trainer.analysis.sweep.job import Job, open_job
from trainer.analysis.sweep.parquet import join_parts, schema_of, write
from trainer.analysis.sweep.parts import folder_of, result_of, take_up
from trainer.analysis.sweep.workers import Crew
from trainer.config.files import ConfigError

Progress = Callable[[int], None]  # takes how many members more are finished


def carry_out(job: Job, crew: Crew, out: Path, progress: Progress) -> Any:
    """Return the result of a study, in the file ``out``; ConfigError if it cannot be.

    Members that an earlier call finished are not flown again, whoever flew them.
    """
    ready = open_job(job)
    there = result_of(job, out)
    if there is not None:
        progress(ready.members)
        return there
    schema = schema_of(ready)
    parts = take_up(job, schema, ready.chunks, out)
    done = parts.finished()
    size = ready.subject.chunk
    progress(sum(min(size, ready.members - place * size) for place in done))
    missing = [place for place in range(ready.chunks) if place not in done]
    try:
        for place, batch in crew(job, missing):
            parts.keep(place, batch)
            progress(len(batch.members))
        result = join_parts(parts.tables(), job, schema)
        write(result, out)
    except OSError as error:
        text = f"{folder_of(out)}: cannot be written: {error.strerror or error}"
        raise ConfigError(text) from None
    parts.clear()
    return result
