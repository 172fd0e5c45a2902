"""The command ``trainer export``: a recording as tables, or for Rerun's viewer."""

from collections.abc import Mapping, Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import Final

import click

from trainer.config.files import ConfigError
from trainer.io.recording.recording import Recording
from trainer.io.tables import Layout, export_csv, export_parquet
from trainer.session.header import layout_of, method_of, reading
from trainer.session.layout import numbers_of
from trainer.session.rerun.request import MISSING


def export_file(path: Path, wanted: Mapping[str, Path | None], branch: int | None) -> None:
    """Write the forms ``wanted``, csv, parquet or rrd, and print the names of the files.

    ConfigError if they cannot be written.
    """
    chosen = {form: out for form, out in wanted.items() if out is not None}
    if not chosen:
        raise ConfigError(f"{path}: export to what? say --csv FILE, --parquet FILE or --rrd FILE")
    written: list[Path] = []
    with reading(path) as recording:
        for form, out in chosen.items():
            written += WRITERS[form](recording, out, branch)
    click.echo("\n".join(map(str, written)))


def csv_files(recording: Recording, path: Path, branch: int | None) -> list[Path]:
    """Write a branch as CSV; return the files written."""
    return export_csv(recording, table_layout(recording), path, branch)


def parquet_files(recording: Recording, path: Path, branch: int | None) -> list[Path]:
    """Write a branch as Parquet; return the files written."""
    return export_parquet(recording, table_layout(recording), path, branch)


def rrd_file(recording: Recording, path: Path, branch: int | None) -> list[Path]:
    """Write a branch as a file for Rerun; return the file written."""
    if find_spec("rerun") is None:
        raise ConfigError(f"--rrd {MISSING}")
    from trainer.session.rerun.conversion import write_record  # noqa: PLC0415  a second to import

    try:
        write_record(recording, path, recording.branch if branch is None else branch)
    except OSError as error:
        raise ConfigError(f"--rrd {path}: {error.strerror}") from None
    return [path]


WRITERS: Final = {"csv": csv_files, "parquet": parquet_files, "rrd": rrd_file}


def table_layout(recording: Recording) -> Layout:
    """Return how the recorded states are read, each number under its name.

    Its ``numbers`` raises ConfigError if a state is damaged.
    """
    header = recording.header()
    names = layout_of(header)
    wanted = [i for i, name in enumerate(names) if name != "tick"]

    def numbers(state: bytes) -> Sequence[float]:
        whole: list[float] = numbers_of(state, names).tolist()
        return [whole[i] for i in wanted]

    return Layout(tuple(names[i] for i in wanted), numbers, method_of(header).step)
