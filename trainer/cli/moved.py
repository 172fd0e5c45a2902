"""Commands that were removed, and what to type now. The list stays for one release.

``main`` asks it before it reads a command line, so that an old script is told the new command, and
not that there is none.
"""

from collections.abc import Sequence
from typing import Final

BENCH_COMPARISONS: Final = (
    *("--against-c", "--footprint", "--peers", "--identify"),
    *("--same-bits", "--numbers", "--web", "--class", "--on-time"),
)
# By the command and its removed option, "" for the whole command: what to type now. An option comes
# before its whole command, because the first match is taken.
MOVED_COMMANDS: Final = {
    ("soak", "--faults"): "from a checkout, python -m tests.faults",
    ("soak", "--damaged"): "from a checkout, python -m tests.faults --damaged",
    ("soak", ""): "from a checkout, python -m tests.soak",
    ("fuzz", ""): "from a checkout, python -m tests.fuzz",
    **{
        ("bench", part): f"from a checkout, python -m tests.bench {part}"
        for part in BENCH_COMPARISONS
    },
    ("bench", "--exported"): "from a checkout, python -m tests.bench --wasm",
    ("identify", "--selftest"): "from a checkout, python -m tests.cases",
    ("run", "--core"): "link its library into your own program, see docs/exported-core.md",
}


def name_successor(words: Sequence[str]) -> str:
    """Return what to type instead of a removed command, "" for any other."""
    words = words[1:] if words[:1] == ["dev"] else words
    options = {word.partition("=")[0] for word in words[1:]}
    for (command, option), now in MOVED_COMMANDS.items():
        if words[:1] == [command] and (not option or option in options):
            return f"{' '.join(filter(None, (command, option)))} is gone: {now}"
    return ""
