"""What a maintainer has to take over: lines, words and options, beside those of the last release.

    python -m helpers.budget        in tests/

``.ci/run`` prints it. They are a direction, and no test reads them but the words by hand
(tests/test_document_tables.py); rooms have limits of their own (tests/test_rooms.py).
"""

from collections.abc import Mapping
from typing import Final

import click

from helpers.exit_codes import commands
from helpers.made_pages import words_by_hand
from helpers.places import ROOT
from trainer.cli.main import cli

RELEASE: Final = "0.3.0"
RELEASED: Final = {
    "lines of trainer/": 128_012,
    "words of docs/": 126_338,
    "words by hand": 90_048,
    "commands": 55,
    "options": 489,
}


def measure() -> Mapping[str, int]:
    """Return what there is now, by its name."""
    found = [each for _, each in commands(cli)]
    return {
        "lines of trainer/": sum(
            path.read_text(encoding="utf-8").count("\n")
            for path in (ROOT / "trainer").rglob("*.py")
        ),
        "words of docs/": sum(
            len(path.read_text(encoding="utf-8").split()) for path in (ROOT / "docs").glob("*.md")
        ),
        "words by hand": sum(words_by_hand().values()),
        "commands": len(found),
        "options": sum(isinstance(given, click.Option) for each in found for given in each.params),
    }


if __name__ == "__main__":
    for name, count in measure().items():
        print(f"{count:7,} {name} ({RELEASE}: {RELEASED[name]:,})")
