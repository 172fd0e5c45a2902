"""All that is fuzzed, by name."""

from collections.abc import Mapping
from pathlib import Path
from typing import Final

from fuzz import files, lines, recordings
from fuzz.fuzz import Target
from trainer.config.files import ConfigError, nearest

TARGETS: Final[Mapping[str, Target]] = {
    target.name: target for target in (*lines.TARGETS, *files.TARGETS, *recordings.TARGETS)
}


def choose_targets(names: tuple[str, ...]) -> list[Target]:
    """Return the targets of those names, all for none; ConfigError naming the nearest."""
    for name in names:
        if name not in TARGETS:
            known = ", ".join(TARGETS)
            raise ConfigError(f"no target {name}{nearest(name, TARGETS)}; there are: {known}")
    return [TARGETS[name] for name in names or TARGETS]


def corpus(folder: Path, target: Target) -> list[bytes]:
    """Return the inputs kept for a target, its seeds first."""
    kept = sorted((folder / target.name).glob("*")) if folder.is_dir() else []
    return [*target.seeds(), *(path.read_bytes() for path in kept)]
