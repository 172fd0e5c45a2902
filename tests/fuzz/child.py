"""The process that fuzzes one target. Its readers are watched, so that new paths are looked for.

    python -m fuzz.child TARGET MODULES [options of libFuzzer] FOLDER

It never returns: the fuzzer ends the process.
"""

import importlib
import pkgutil
import sys
import warnings
from typing import Final

import atheris

WATCHED: Final = "trainer", "tomllib", "json"  # whole packages, whatever part is named
COMPILED: Final = "trainer.core", "trainer.identify.kernels"


def import_all(package: str) -> None:
    """Import every module of a package."""
    home = importlib.import_module(package)
    for module in pkgutil.iter_modules(home.__path__):
        importlib.import_module(f"{package}.{module.name}")


def main(name: str, spared: str, *options: str) -> None:
    """Fuzz the target of that name, with no look at the modules named, commas between."""
    for package in COMPILED:
        import_all(package)  # first, since what is watched cannot be compiled
    for module in filter(None, spared.split(",")):
        importlib.import_module(module)
    with atheris.instrument_imports(include=list(WATCHED)):
        from fuzz.catalogue import TARGETS  # noqa: PLC0415
    take = TARGETS[name].take
    for seed in TARGETS[name].seeds():
        take(seed)  # imports, compiles and remembers what it needs before it is watched
    warnings.simplefilter("error")
    atheris.Setup([name, *options], take)
    atheris.Fuzz()


if __name__ == "__main__":
    main(*sys.argv[1:])
