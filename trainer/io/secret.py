"""The token that a line may give with a role, kept out of all that is told or logged.

It is found by its place in the line, before anything is understood, so that no answer repeats it
where the words before it are misspelt.
"""

import re

from trainer.io.order_table import SETS, spellings

HIDDEN = "***"
BEGINNINGS = "|".join(sorted({said[:2] for said, _ in spellings(SETS["ROLE"])}))
TOKEN = re.compile(
    rf"((?:^|,)\s*r(?:o\S*\s+\S+|\S*\s+(?:{BEGINNINGS})\S*)\s+)(\S.*?)\s*$", re.IGNORECASE
)


def hide(text: str) -> str:
    """Return `text` with a token in it hidden."""
    return TOKEN.sub(rf"\1{HIDDEN}", text)


def hidden(text: str) -> str:
    """Return the token in `text`, "" when there is none."""
    found = TOKEN.search(text)
    return found[2] if found else ""
