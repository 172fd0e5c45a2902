"""The first start of a version: at once and interpreted, while another process compiles.

``cli/run`` calls it. Compiling takes a minute of a processor. The interpreter computes a tick in
some milliseconds, with the same bits. A run in real time therefore begins without machine code. A
process beside it first compiles the tick alone, because the run goes over to that; then all that
the next start needs. A run that wants ticks faster than the interpreter makes them waits for the
compiler. All this is decided before a kernel is imported.
"""

import math
import os
import subprocess
import sys
import threading
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

import trainer
from trainer.boat import compilation
from trainer.config.files import ConfigError, is_path, parse_toml, read_text, shipped_path
from trainer.core.cache import cache_folder, cache_lasts
from trainer.session.options import RunOptions

# [s] of the clock for an evaluation of the rates, on the safe side: docs/timing.md measures
# 2 to 5 ms for a whole tick
EVALUATION_TIME_S: Final = 0.02
TICK_EVALUATIONS: Final = {  # evaluations of the rates in a tick, one with other integrators
    **dict.fromkeys(("heun", "abm2", "abm3", "abm4", "hamming4", "o30c31", "bdf2", "bdf3"), 2.0),
    "rk2": 2.0,
    "rk3": 3.0,
    "rk4": 4.0,
    "rkv": math.inf,
}
PREPARING_TEXT: Final = (
    "First start: still preparing in the background ({percent} %). You can sail now; "
    "only fast time has to wait."
)
NEARLY_READY: Final = "First start: the last parts are still being prepared. You can sail now."


def prepare_core(options: RunOptions) -> str:
    """Choose machine code or the interpreter for a run. Return the notice for its user."""
    if os.name != "posix" or compilation.is_settled() or compilation.is_interpreted():
        return ""
    if compilation.is_kept() or is_hurried(options) or complaints():
        return ""
    compilation.use_interpreter()
    if not cache_lasts():
        return (
            "No folder for prepared code can be written to: you can sail, but not in fast time. "
            "NUMBA_CACHE_DIR names a folder that can be written to"
        )
    compile_beside()
    if compilation.is_tick_kept():
        return NEARLY_READY
    return PREPARING_TEXT.format(percent=compilation.tick_progress())


def is_hurried(options: RunOptions) -> bool:
    """Return whether ticks are to come faster than the interpreter surely makes them."""
    exercise = load_table("exercises", options.exercise)
    said = {"step": "step_s", "vessel": "vessel", "integrator": "integrator"}  # option: file's key
    chosen = {
        name: getattr(options, name)
        if name in options.given
        else exercise.get(key, getattr(options, name))
        for name, key in said.items()
    }
    step = chosen["step"] or load_table("vessels", chosen["vessel"]).get("run", {}).get("step_s")
    if not isinstance(step, int | float):
        return True
    least = EVALUATION_TIME_S * TICK_EVALUATIONS.get(str(chosen["integrator"]), 1.0)
    return bool(step / options.speed < least)


def load_table(kind: str, name: Any) -> Mapping[str, Any]:
    """Return the tables of a shipped file or a user's. {}: it cannot be read.

    No error is raised here, because the plan reads the file again and says what is wrong.
    """
    if name is None:
        return {}
    try:
        text = read_text(Path(name) if is_path(str(name)) else shipped_path(kind, str(name)))
        return parse_toml(text, str(name))
    except ConfigError:
        return {}


def complaints() -> bool:
    """Return whether compiling beside a run has failed. The next run then compiles in sight."""
    with compilation.compilation_lock() as free:
        return free is not None and compilation.has_complained()


def compile_beside() -> None:
    """Start a process that fills the cache, unless there is one. It ends by itself.

    It may outlive this process. It inherits the lock, so that there is never a second one. It
    compiles the trainer that runs, not one whose sources lie in the present folder.
    """
    ours = str(Path(trainer.__file__).parents[1])
    search_path = os.pathsep.join(filter(None, (ours, os.environ.get("PYTHONPATH"))))
    with compilation.compilation_lock() as lock:
        if lock is None:
            return
        if not compilation.is_tick_kept():
            compilation.write_progress(0)
        with (cache_folder() / compilation.ERROR_LOG_NAME).open("wb") as said:
            process = subprocess.Popen(  # noqa: S603  our own words
                [sys.executable, "-P", "-m", "trainer.session.warm_up", str(lock)],
                env=os.environ | {"PYTHONPATH": search_path},
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=said,
                start_new_session=True,  # the terminal's keys are for the run
                pass_fds=(lock,),
            )
    threading.Thread(target=process.wait, name="compiling", daemon=True).start()
