"""Where the project and the data of its tests are, and how another process finds them."""

import os
from pathlib import Path

import trainer

TESTS = Path(__file__).parents[1]
ROOT = TESTS.parent
DATA = TESTS / "data"
PACKAGES = Path(trainer.__file__).parents[1]  # of the trainer that is tested, installed or not
CHECKOUT = os.pathsep.join((str(PACKAGES), str(ROOT)))  # where `python -m tests.NAME` finds both


def environment(**more: str) -> dict[str, str]:
    """Return the environment of a process that is to import the trainer that is tested here.

    One of another path would have its own compiled code, and would begin by making it.
    """
    found = filter(None, (str(PACKAGES), os.environ.get("PYTHONPATH")))
    return {**os.environ, "PYTHONPATH": os.pathsep.join(found), **more}


def tests_environment(**more: str) -> dict[str, str]:
    """Return the same for a process that is to import the packages of these tests as well."""
    whole = environment(**more)
    return whole | {"PYTHONPATH": os.pathsep.join((whole["PYTHONPATH"], str(TESTS)))}
