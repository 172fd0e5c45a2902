"""The command ``trainer export``: a recording as tables."""

from collections.abc import Sequence
from pathlib import Path

import click
import numpy as np

from trainer.config import ConfigError
from trainer.io.export import Layout, export_csv, export_parquet
from trainer.io.recording import Recording, RecordingError
from trainer.log_book import layout_of, method_of


def export_file(path: Path, csv: Path | None, parquet: Path | None, branch: int | None) -> None:
    """Write the tables asked for and print their names; ConfigError if they cannot be."""
    if csv is None and parquet is None:
        raise ConfigError(f"{path}: export to what? say --csv FILE or --parquet FILE")
    try:
        recording = Recording.look(path)
    except RecordingError as error:
        raise ConfigError(str(error)) from None
    try:
        layout = table_layout(recording)
        written: list[Path] = []
        if csv is not None:
            written += export_csv(recording, layout, csv, branch)
        if parquet is not None:
            written += export_parquet(recording, layout, parquet, branch)
    except RecordingError as error:
        raise ConfigError(str(error)) from None
    finally:
        recording.close()
    click.echo("\n".join(map(str, written)))


def table_layout(recording: Recording) -> Layout:
    """Return how the recorded states are read, each number under its name."""
    header = recording.header()
    names = layout_of(header)
    wanted = [i for i, name in enumerate(names) if name != "tick"]

    def numbers(state: bytes) -> Sequence[float]:
        whole: list[float] = np.frombuffer(state).tolist()
        return [whole[i] for i in wanted]

    return Layout(tuple(names[i] for i in wanted), numbers, method_of(header).step)
