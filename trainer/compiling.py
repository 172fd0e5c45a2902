"""The core compiled for later starts, out of the way of others: ``python -m trainer.compiling``."""

import os
import resource
from typing import Final

from trainer import compilation
from trainer.boat import Boat
from trainer.files.vessel_file import load_vessel
from trainer.fitout import Method
from trainer.machine_code import cache_folder
from trainer.readiness import try_out

LONGEST: Final = 600  # [s] of processor time: whatever happens, it ends


def main() -> None:
    """Compile what a run needs, unless another process does so or has done so."""
    os.nice(19)
    resource.setrlimit(resource.RLIMIT_CPU, (LONGEST, LONGEST))
    with compilation.compiling() as alone:
        if alone and not compilation.kept():
            try_out(Boat(load_vessel("bb2"), Method("modified", "lagged", "exact", "adams2", 0.5)))
            compilation.keep()
            (cache_folder() / compilation.COMPLAINTS).unlink(missing_ok=True)


if __name__ == "__main__":
    main()
