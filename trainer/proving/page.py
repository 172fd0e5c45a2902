"""What a proof found, as a table or JSON."""

import json
from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

from trainer.proving.fuzz import Found


def table(head: Sequence[str], rows: Sequence[Sequence[object]]) -> str:
    """Return a table in columns, the first to the left and the rest to the right."""
    texts = [[str(cell) for cell in row] for row in (head, *rows)]
    widths = [max(len(row[i]) for row in texts) for i in range(len(head))]
    lines = [
        "  ".join(
            cell.ljust(width) if i == 0 else cell.rjust(width)
            for i, (cell, width) in enumerate(zip(row, widths, strict=True))
        ).rstrip()
        for row in texts
    ]
    return "\n".join(lines)


def fuzz_page(found: Sequence[Found]) -> str:
    """Return what came of each target, and the failures in full."""
    head = ("target", "inputs", "paths", "kept", "seconds", "verdict")
    rows = [
        (
            *(each.target, f"{each.inputs:,}", each.paths, each.kept, f"{each.seconds:.0f}"),
            "FAILED" if each.failure else "no exception but the declared",
        )
        for each in found
    ]
    failures = [
        f"\n{each.target}: {each.saved or 'no input saved'}\n{each.failure}"
        for each in found
        if each.failure
    ]
    return "\n".join([table(head, rows), *failures])


def as_json(found: Sequence[Any]) -> str:
    """Return records as JSON."""
    return json.dumps([asdict(each) for each in found], indent=1)
