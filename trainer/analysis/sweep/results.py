"""The results of a sweep: batches as Parquet in a folder, then one file.

``chunks`` writes batches and ``sweep`` joins them. The facts of the study lie in the file itself,
so that a result can be flown again and is never taken for another study's.
"""

import json
from collections.abc import Iterable
from pathlib import Path
from typing import Any, Final

import numpy as np

from trainer.analysis.sweep.job import Batch, Job, OpenJob
from trainer.config.extras import require_library
from trainer.io.outputs import replacing

ROW_GROUP_ROWS: Final = 65_536  # of a row group of the result
MEMBER_COLUMN, SEED_COLUMN, TROUBLE_COLUMN = "member", "seed", "trouble"
FACTS_KEY: Final = b"trainer.sweep"


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
