"""A search kept in a file, to be gone on with after a break."""

import contextlib
import hashlib
import json
import os
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any, Final

from trainer import __version__
from trainer.analysis.reduce.search import Need, Standing
from trainer.config.files import ConfigError, no_constant
from trainer.config.vessel import VesselFile
from trainer.core.cache import core_digest

ENDING: Final = ".partial.json"


def place(result: Path) -> Path:
    """Return where the search for that result is kept."""
    return result.with_name(result.name + ENDING)


def fingerprint(file: VesselFile) -> str:
    """Return what tells one search from another: the boat and the program."""
    text = f"{__version__}\n{core_digest()}\n{file.text}"
    return hashlib.sha256(text.encode()).hexdigest()


def save(path: Path, file: VesselFile, standings: Mapping[str, Standing]) -> None:
    """Write the standings by equation set, whole or not at all. ConfigError if that cannot be."""
    found = {"of": fingerprint(file), **{name: asdict(one) for name, one in standings.items()}}
    beside = path.with_name(path.name + ".new")
    try:
        beside.write_text(json.dumps(found), encoding="utf-8")
        os.replace(beside, path)  # noqa: PTH105 (atomic)
    except OSError as error:
        raise ConfigError(f"{path}: cannot be written: {error.strerror}") from None


def load(path: Path, file: VesselFile) -> dict[str, Standing]:
    """Return the standings kept, none if there are none of this boat by this program."""
    try:
        found = json.loads(path.read_text(encoding="utf-8"), parse_constant=no_constant)
        if found.pop("of") != fingerprint(file):
            return {}
        return {name: _standing(one) for name, one in found.items()}
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return {}


class Log:
    """How far the searches for one boat have come, by name. In a file, if there is one."""

    def __init__(self, file: VesselFile, path: Path | None) -> None:
        """Read what the file at ``path`` has of this boat."""
        self._file, self._path = file, path
        self._standings = load(path, file) if path else {}

    def standing(self, name: str) -> Standing | None:
        """Return how far a search has come; None: it has not begun."""
        return self._standings.get(name)

    def enter(self, name: str, standing: Standing) -> None:
        """Keep how far a search has come; ConfigError if the file cannot be written."""
        self._standings[name] = standing
        if self._path:
            save(self._path, self._file, self._standings)


def _standing(found: Mapping[str, Any]) -> Standing:
    """Return a standing as it was saved."""
    needed = tuple(Need(**need) for need in found["needed"])
    lists = {key: tuple(found[key]) for key in ("factors", "kept")}
    return Standing(**{**found, **lists, "needed": needed})


def discard(path: Path) -> None:
    """Take the file away, if it is there."""
    with contextlib.suppress(OSError):
        path.unlink()
