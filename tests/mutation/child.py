"""The process that plays whole sessions on a tree that may have a fault.

    python -m mutation.child lines SEEDS SECONDS ROOT
    python -m mutation.child hunt SEEDS SECONDS ROOT

The first prints which lines of the rooms sessions execute, the second what is the first to be seen.
"""

import json
import resource
import sys
from collections import defaultdict
from pathlib import Path
from types import FrameType
from typing import Any, Final

from simulation.drawing import draw_script
from simulation.machine import Task
from simulation.play import play

from mutation.places import ROOMS

MAX_MEMORY_BYTES: Final = 4 << 30  # a fault may gather without end


def list_lines(seeds: range, seconds: float, root: Path) -> dict[str, list[int]]:
    """Return the lines of each module that seeds execute, by processes so long [s]."""
    folders = tuple(str(root / "trainer" / room) for room in ROOMS)
    executed: defaultdict[str, set[int]] = defaultdict(set)

    def note(frame: FrameType, event: str, _given: Any) -> Any:
        if event == "call" and not frame.f_code.co_filename.startswith(folders):
            return None
        executed[frame.f_code.co_filename].add(frame.f_lineno)
        return note

    run = Task._run  # noqa: SLF001  each greenlet is traced by itself

    def run_traced(task: Task, *given: Any) -> None:
        sys.settrace(note)
        run(task, *given)

    Task._run = run_traced  # type: ignore[method-assign, assignment]  # noqa: SLF001
    for seed in seeds:
        play(draw_script(seed, seconds))
    return {
        Path(file).relative_to(root).as_posix(): sorted(lines) for file, lines in executed.items()
    }


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
    what, count, longest, tree = sys.argv[1:]
    numbers = range(1, 1 + int(count))
    if what == "lines":
        print(json.dumps(list_lines(numbers, float(longest), Path(tree))))
    else:
        print(json.dumps(hunt(numbers, float(longest))))
