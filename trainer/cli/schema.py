"""The command ``trainer dev schema``: JSON Schemas by which editors check files.

A schema is made by the module that reads the kind of file, in a function of its name
(``vessel_schema``). The module is imported when its schema is asked for, because some take long to
load.
"""

import json
from importlib import import_module
from pathlib import Path
from typing import Any, Final

import click

from trainer.cli.types import Choice, Output
from trainer.report.progress import write_text

SCHEMA_MODULES: Final = {  # the module that makes the schema of a kind of file
    **dict.fromkeys(
        ("vessel", "hull", "exercise", "sea", "casualties"), "config.exercise.file_schemas"
    ),
    "study": "analysis.sweep.study",
    "identification": "identify.record.study",
    "ship": "config.ship.ship",
    "case": "config.exercise.check_case",
    "class": "config.exercise.class_file",
}


def schema_of(kind: str) -> dict[str, Any]:
    """Return the JSON Schema of a kind of file."""
    made: dict[str, Any] = getattr(
        import_module(f"trainer.{SCHEMA_MODULES[kind]}"), f"{kind}_schema"
    )()
    return made


@click.command()
@click.argument("kind", type=Choice(tuple(SCHEMA_MODULES)), metavar="KIND")
@click.option("-o", "--output", type=Output(".json"), metavar="FILE", help="Write it there.")
def schema(kind: str, output: Path | None) -> None:
    """Print the JSON Schema of a kind of file, by which editors complete and underline.

    \b
    Example:  trainer dev schema exercise -o exercise.schema.json
              trainer dev schema vessel

    A study is what `trainer boat sweep` flies, an identification what `trainer identify` fits, a
    ship what its models linear to mmg take and write.
    """
    text = json.dumps(schema_of(kind), indent=1)
    if output is None:
        click.echo(text)
        return
    write_text(output, f"{text}\n")
    click.echo(f"{output} written; first line of your file: #:schema ./{output.name}")
