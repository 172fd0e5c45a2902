"""Files and the command line use these words for the method of computing a boat."""

from typing import Final

EQUATIONS: Final = ("full", "modified", "basic", "longitudinal")
TRIGONOMETRY: Final = ("exact", "report")
