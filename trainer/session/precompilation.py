"""The core compiled for later starts: ``python -m trainer.session.precompilation``."""

import os
from typing import Final

from trainer.boat import compilation
from trainer.boat.assemble import Method
from trainer.boat.boat import Boat
from trainer.config.vessel import load_vessel
from trainer.core.cache import cache_folder
from trainer.session.warm_up import try_out

LONGEST: Final = 600  # [s] of processor time: whatever happens, it ends


def main() -> None:
    """Compile what a run needs, unless another process does so or has done so."""
    if os.name == "posix":
        import resource  # noqa: PLC0415  not everywhere

        os.nice(19)
        resource.setrlimit(resource.RLIMIT_CPU, (LONGEST, LONGEST))
    with compilation.compiling() as alone:
        if alone and not compilation.is_kept():
            try_out(Boat(load_vessel("bb2"), Method("modified", "lagged", "exact", "adams2", 0.5)))
            compilation.keep()
            (cache_folder() / compilation.COMPLAINTS).unlink(missing_ok=True)


if __name__ == "__main__":
    main()
