"""The findings of a proof as a table or JSON, and its progress bar."""

import json
import sys
import threading
from collections.abc import Sequence
from dataclasses import asdict
from types import TracebackType
from typing import Any, Self

import click

from trainer.verify.fuzz.fuzz import Found


def table(head: Sequence[str], rows: Sequence[Sequence[object]]) -> str:
    """Return a table in columns. The first is to the left, the rest to the right."""
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


class Bar:
    """How much is done of a whole; any thread may tell."""

    def __init__(self, label: str, whole: int) -> None:
        self._done: dict[str, int] = {}
        self._lock = threading.Lock()
        self._bar: Any = None
        if sys.stderr.isatty():
            self._bar = click.progressbar(length=whole, label=label, file=sys.stderr)

    def __enter__(self) -> Self:
        if self._bar:
            self._bar.__enter__()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._bar:
            self._bar.__exit__(kind, error, trace)

    def at(self, task: str, done: int) -> None:
        """Show that so much of one task is done."""
        with self._lock:
            more = done - self._done.get(task, 0)
            self._done[task] = max(done, self._done.get(task, 0))
            if self._bar and more > 0:
                self._bar.update(more)
