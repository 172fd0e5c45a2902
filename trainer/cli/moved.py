"""What was typed until 0.1 and has gone elsewhere, told for one release."""

from collections.abc import Sequence
from typing import Final

MOVED: Final = {  # a command, and its option that has gone or "" for the whole; what to type now
    ("run", "--core"): "link its library into your own program, see docs/exported-core.md",
}


def tell_what_is_typed_now(words: Sequence[str]) -> str:
    """Return what takes the place of a command that has gone, "" for one that is still here."""
    options = {word.partition("=")[0] for word in words[1:]}
    for (command, option), now in MOVED.items():
        if words[:1] == [command] and (not option or option in options):
            return f"{' '.join(filter(None, (command, option)))} is gone: {now}"
    return ""
