"""The pages' styles, joined: each cut of the screen has a name, in ``css/forms.css`` alone.

``@custom-media`` is of CSS Media Queries 5, which browsers do not know yet, so names are replaced
here.
"""

import re
from collections.abc import Iterable
from typing import Final

from trainer.web import modules

NAMED_FORM: Final = re.compile(r"^@custom-media (--[\w-]+) (.+);\n", re.MULTILINE)
SHEET_COMMENT: Final = re.compile(r"^[ \t]*/\*(?:(?!\*/).)*\*/\n", re.MULTILINE | re.DOTALL)
FORM_IN_CONDITION: Final = re.compile(r"(?<=[ ,(])\((--[\w-]+)\)")  # and not of ``var(--name)``


def join_styles(paths: Iterable[str]) -> str:
    """Return these sheets as one, with the condition of each named form; KeyError."""
    folder = modules.ASSETS_FOLDER
    sheet = "".join((folder / path).read_text(encoding="utf-8") for path in paths)
    forms = dict(NAMED_FORM.findall(sheet))
    sheet = SHEET_COMMENT.sub("", NAMED_FORM.sub("", sheet))
    return FORM_IN_CONDITION.sub(lambda found: f"({forms[found[1]]})", sheet)
