"""The process that fuzzes one target: its readers are watched, so that new paths are looked for.

    python -m trainer.proving.fuzz_child TARGET [options of libFuzzer] FOLDER...

It never returns: the fuzzer ends the process.
"""

import sys
import warnings
from typing import Final

import atheris

WATCHED: Final = (
    *("tomllib", "json", "csv", "trainer.config", "trainer.arguments", "trainer.io"),
    *("trainer.files", "trainer.nmea", "trainer.stations", "trainer.scores", "trainer.records"),
    *("trainer.guide.trials", "trainer.guide.baseline", "trainer.screen.sight"),
    *("trainer.screen.picture", "trainer.screen.journal", "trainer.study.series"),
    *("trainer.study.evaluate", "trainer.identify.sources", "trainer.identify.study_file"),
    *("trainer.identify.nomoto_file", "trainer.identify.decca_file", "trainer.identify.decca"),
    "trainer.identify.checkpoint",
)


def main(name: str, *options: str) -> None:
    """Fuzz the target of that name."""
    with atheris.instrument_imports(include=list(WATCHED)):
        from trainer.proving.catalogue import TARGETS  # noqa: PLC0415
    take = TARGETS[name].take
    for seed in TARGETS[name].seeds():
        take(seed)  # imports, compiles and remembers what it needs before it is watched
    warnings.simplefilter("error")
    atheris.Setup([name, *options], take)
    atheris.Fuzz()


if __name__ == "__main__":
    main(*sys.argv[1:])
