"""The findings of a proof as JSON, and its progress bar."""

import json
import sys
import threading
from collections.abc import Sequence
from dataclasses import asdict
from types import TracebackType
from typing import Any, Self

import click


def as_json(findings: Sequence[Any]) -> str:
    """Return records as JSON."""
    return json.dumps([asdict(each) for each in findings], indent=1)


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
