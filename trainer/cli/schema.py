"""The command that gives editors what a file may say."""

import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Final

import click

from trainer.cli.answers import write_text
from trainer.cli.shared_options import FILE
from trainer.cli.types import Choice


def _of_config(name: str) -> Callable[[], dict[str, Any]]:
    """Return what makes the schema of a file that a session reads."""

    def make() -> dict[str, Any]:
        from trainer.config import file_schemas  # noqa: PLC0415

        made: dict[str, Any] = getattr(file_schemas, f"{name}_schema")()
        return made

    return make


def _study() -> dict[str, Any]:
    from trainer.analysis.sweep.study import study_schema  # noqa: PLC0415

    return study_schema()


def _identification() -> dict[str, Any]:
    from trainer.identify.study import identification_schema  # noqa: PLC0415

    return identification_schema()


def _ship() -> dict[str, Any]:
    from trainer.identify.ships.ship_file import ship_schema  # noqa: PLC0415

    return ship_schema()


SCHEMAS: Final[Mapping[str, Callable[[], dict[str, Any]]]] = {
    **{name: _of_config(name) for name in ("vessel", "hull", "exercise", "sea", "casualties")},
    "study": _study,
    "identification": _identification,
    "ship": _ship,
}


@click.command()
@click.argument("kind", type=Choice(tuple(SCHEMAS)))
@click.option("-o", "--output", type=FILE, default=None, metavar="FILE", help="Write it there.")
def schema(kind: str, output: Path | None) -> None:
    """Print the JSON Schema of a kind of file, by which editors complete and underline.

    \b
    Example:  trainer schema exercise -o exercise.schema.json
              trainer schema vessel

    A study is what `trainer sweep` flies, an identification what `trainer identify` fits, a
    ship what its models linear to mmg take and write.
    """
    text = json.dumps(SCHEMAS[kind](), indent=1)
    if output is None:
        click.echo(text)
        return
    write_text(output, f"{text}\n")
    click.echo(f"{output} written; first line of your file: #:schema ./{output.name}")
