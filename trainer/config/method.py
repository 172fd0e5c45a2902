"""The words for how a boat is computed, as files and the command line take them."""

from typing import Final

EQUATIONS: Final = ("full", "modified", "basic", "longitudinal")
TRIGONOMETRY: Final = ("exact", "report")
