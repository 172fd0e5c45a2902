"""A notebook run without Jupyter: its code cells, one after the other, and what they print.

python -m helpers.notebooks, from the folder of the tests, writes what they print into each.
"""

import contextlib
import io
import json
import os
import tempfile
from pathlib import Path
from typing import Any

from helpers.places import ROOT

NOTEBOOKS = [
    ROOT / "docs" / name for name in ("first-hour.ipynb", "identification.ipynb", "own-boat.ipynb")
]


def cells(path: Path) -> list[dict[str, Any]]:
    """Return the code cells of a notebook."""
    found = json.loads(path.read_text(encoding="utf-8"))["cells"]
    return [cell for cell in found if cell["cell_type"] == "code"]


def outputs_of(cell: dict[str, Any]) -> str:
    """Return what a cell has printed, as the notebook keeps it."""
    return "".join(line for output in cell["outputs"] for line in output["text"])


def run(path: Path) -> list[str]:
    """Run a notebook's code in the present folder; return what each cell prints."""
    names: dict[str, Any] = {"__name__": "__main__"}
    printed = []
    for cell in cells(path):
        with contextlib.redirect_stdout(io.StringIO()) as heard:
            exec("".join(cell["source"]), names)  # noqa: S102  our own
        printed.append(heard.getvalue())
    return printed


def write(path: Path) -> None:
    """Renew what the cells of a notebook have printed."""
    notebook = json.loads(path.read_text(encoding="utf-8"))
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
        printed = iter(run(path))
    count = 0
    for cell in notebook["cells"]:
        if cell["cell_type"] == "code":
            count += 1
            cell["execution_count"] = count
            lines = next(printed).splitlines(keepends=True)
            output = {"name": "stdout", "output_type": "stream", "text": lines}
            cell["outputs"] = [output] if lines else []
    text = json.dumps(notebook, indent=1, ensure_ascii=False)
    path.write_text(text + os.linesep, encoding="utf-8")


if __name__ == "__main__":
    for notebook in NOTEBOOKS:
        write(notebook)
