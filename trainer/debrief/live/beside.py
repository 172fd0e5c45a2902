"""A debrief that is written beside a session: python -m trainer.debrief.live.beside FILE BRANCH.

It prints the share of its work that is done, a line each, and at last a line of JSON: the page, and
what each minute cost. ``session/aside`` hears it; so the session's memory and answers do not feel
it.
"""

import gc
import json
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Final

import numpy as np

from trainer.config.files import ConfigError
from trainer.debrief.attainable.words import change_words
from trainer.debrief.page.data import DebriefData
from trainer.debrief.page.page import default_page_path, write_beside

SHARE_STEP: Final = 0.01  # of the work, after which the share is printed again


def minutes_told(debrief: DebriefData) -> list[tuple[float, str]]:
    """Return each change of what could still be earned: its time [s], and its sentence."""
    curve = debrief.compared.curve if debrief.compared else None
    changes = curve.changes if curve else ()
    return [(each.told_at * debrief.step, change_words(each, debrief.step)) for each in changes]


def share_printer() -> Callable[[float], None]:
    """Return a function that prints a share where it has grown by SHARE_STEP."""
    printed = 0.0

    def show(share: float) -> None:
        nonlocal printed
        if share >= printed + SHARE_STEP:
            printed = share
            sys.stdout.write(f"{share:.2f}\n")
            sys.stdout.flush()

    return show


def main() -> None:
    """Write one debrief; leave with a line that says why there is none."""
    path, branch = Path(sys.argv[1]), int(sys.argv[2])
    try:
        with np.errstate(all="ignore"):  # a state may hold any number
            debrief = write_beside(path, branch, share_printer())
    except (ConfigError, OSError) as error:
        sys.exit(f"trainer: {error}")
    page = str(default_page_path(path, branch))
    sys.stdout.write(json.dumps({"page": page, "minutes": minutes_told(debrief)}) + "\n")


if __name__ == "__main__":
    gc.disable()  # little of a debrief is garbage before its end
    main()
    gc.freeze()
