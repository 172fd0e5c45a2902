"""The changes of a guide since an earlier one.

``trainer boat guide --baseline`` compares with an earlier guide of the same boat, so that a change
of the boat or of the program shows in each number that it moved.
"""

import json
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from trainer.config.files import ConfigError, no_constant, quote

EMBEDDED_GUIDE: Final = re.compile(
    r'<script type="application/json" id="guide">(.*?)</script>', re.DOTALL
)
SAME_NUMBER_RATIO: Final = 1e-6  # [-] relative difference that is none
TINY_NUMBER: Final = 1e-12  # [SI] a change that is rounding about zero, where no ratio can tell
MAX_GUIDE_BYTES: Final = 50_000_000  # [byte] of an earlier guide


@dataclass(frozen=True)
class GuideMove:
    """One number or verdict that is not what it was."""

    what: str
    before: float | str | None  # None: it was not there
    after: float | str | None

    @property
    def percent(self) -> float | None:
        """Return the change [%] of what it was; None if that cannot be told."""
        if isinstance(self.before, float) and isinstance(self.after, float) and self.before:
            return 100.0 * (self.after - self.before) / abs(self.before)
        return None


def load_earlier(path: Path, vessel: str) -> Mapping[str, Any]:
    """Return an earlier guide, JSON or HTML; ConfigError if it is none of that boat."""
    try:
        if path.stat().st_size > MAX_GUIDE_BYTES:
            raise ConfigError(f"--baseline {path}: is larger than any guide; not read")
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or "is not UTF-8 text"
        raise ConfigError(f"--baseline {path}: {reason}") from None
    embedded = EMBEDDED_GUIDE.search(text)
    try:
        written = embedded[1].replace("<\\/", "</") if embedded else text
        guide = json.loads(written, parse_constant=no_constant)
        name = guide["vessel"]
        dict(leaves(guide))
    except (ValueError, KeyError, TypeError, AttributeError):
        raise ConfigError(
            f"--baseline {path}: is no guide; give the file of --json or of --html"
        ) from None
    if name != vessel:
        raise ConfigError(f"--baseline {path}: is a guide of {quote(name)}, not of {quote(vessel)}")
    return guide  # type: ignore[no-any-return]


def leaves(guide: Mapping[str, Any]) -> Iterator[tuple[str, float | str | None]]:
    """Yield every number and verdict of a guide with its name."""
    for sheet in guide["sheets"]:
        for equations, rows in sheet["judgements"].items():
            for row in rows:
                name = f"{sheet['title']}: {row['quantity']}"
                yield f"{name} [{row['unit']}], full", row["full"]
                yield f"{name} [{row['unit']}], {equations}", row["other"]
                yield f"{name}, {equations}: verdict", row["verdict"]
    for one in guide["findings"]:
        yield f"finding {one['title']}: verdict", one["verdict"]
    for run in guide["steps"]:
        name = f"{run['case']}, {run['scheme']} {run['rates']} {run['step_s']:.3g} s"
        yield f"{name} [%]", run["percent"]
    for trial in guide["trials"]:
        if "trial" in trial:  # a guide of before there were verdicts on published figures
            results = trial["trial"]["results"]
            for result, value in zip(results, trial["ours"], strict=True):
                yield f"{trial['trial']['title']}: {result['quantity']} [{result['unit']}]", value
        for row in trial.get("rows", ()):
            figure = row["figure"]
            yield f"{trial['title']}: {figure['quantity']} [{figure['unit']}]", row["ours"]


def compare_guides(earlier: Mapping[str, Any], now: Mapping[str, Any]) -> tuple[GuideMove, ...]:
    """Return what differs between two guides, the largest change first."""
    before, after = dict(leaves(earlier)), dict(leaves(now))
    moves = [
        GuideMove(name, before.get(name), after.get(name))
        for name in dict.fromkeys([*before, *after])
        if not _same(before.get(name), after.get(name))
    ]
    return tuple(sorted(moves, key=lambda one: -_size(one)))


def _same(before: float | str | None, after: float | str | None) -> bool:
    """Return whether two entries are the same, numbers but for rounding."""
    if isinstance(before, float) and isinstance(after, float):
        return abs(after - before) <= SAME_NUMBER_RATIO * max(abs(before), abs(after)) + TINY_NUMBER
    return before == after


def _size(one: GuideMove) -> float:
    """Return the sort key of a change: verdicts first, then by relative change."""
    if isinstance(one.before, str) or isinstance(one.after, str):
        return float("inf")
    return abs(one.percent) if one.percent is not None else 1e9
