"""The process that plays whole sessions on a tree that may have a fault.

    python -m mutation.child lines SEEDS SECONDS FILE ...
    python -m mutation.child hunt SEEDS SECONDS

Both print what is the first to be seen, the first before that which lines of some modules sessions
execute: to look at few costs little.
"""

import json
import math
import resource
import sys
from collections import defaultdict
from collections.abc import Sequence
from types import FrameType
from typing import Any, Final

from simulation.drawing import draw_script
from simulation.machine import Task
from simulation.play import play

MAX_MEMORY_BYTES: Final = 4 << 30  # a fault may gather without end
MAX_WORK_S: Final = 20, 2  # [s] of processor for the start and each seed, five times what they take


def list_lines(
    seeds: range, seconds: float, files: Sequence[str]
) -> tuple[dict[str, list[int]], str]:
    """Return the lines of each module that seeds execute, by processes so long [s].

    With it comes what the seeds are the first to see, "" for nothing.
    """
    executed: defaultdict[str, set[int]] = defaultdict(set)
    watched = frozenset(files)

    def note(frame: FrameType, event: str, _given: Any) -> Any:
        if event == "call" and frame.f_code.co_filename not in watched:
            return None
        executed[frame.f_code.co_filename].add(frame.f_lineno)
        return note

    run = Task._run  # noqa: SLF001  each greenlet is traced by itself

    def run_traced(task: Task, *given: Any) -> None:
        sys.settrace(note)
        run(task, *given)

    Task._run = run_traced  # type: ignore[method-assign, assignment]  # noqa: SLF001
    seen = hunt(seeds, seconds)
    return {file: sorted(lines) for file, lines in executed.items()}, seen


def hunt(seeds: range, seconds: float) -> str:
    """Return what the seeds are the first to see, "" for nothing."""
    for seed in seeds:
        try:
            breaches = play(draw_script(seed, seconds)).breaches
        except Exception as error:  # noqa: BLE001  whatever a fault leads to is seen
            return f"seed {seed}: {error!r}"
        if breaches:
            return f"seed {seed}: {breaches[0].law.value.partition(':')[0]}"
    return ""


if __name__ == "__main__":
    resource.setrlimit(resource.RLIMIT_DATA, (MAX_MEMORY_BYTES, MAX_MEMORY_BYTES))
    what, count, longest, *modules = sys.argv[1:]
    most = MAX_WORK_S[0] + MAX_WORK_S[1] * math.ceil(int(count) * max(float(longest) / 3.0, 1.0))
    if what == "hunt":
        resource.setrlimit(resource.RLIMIT_CPU, (most, most))
    numbers = range(1, 1 + int(count))
    if what == "lines":
        print(json.dumps(list_lines(numbers, float(longest), modules)))
    else:
        print(json.dumps(hunt(numbers, float(longest))))
