"""Which cases of a test every commit tries, and which are left to the night."""

from collections.abc import Iterable
from typing import Any

import pytest


def sample_cases(cases: Iterable[Any], *often: object) -> list[Any]:
    """Return the cases of a test; those that are not among ``often`` are marked slow."""
    cases = list(cases)
    assert set(often) <= set(cases), f"no such case among {cases}"
    return [each if each in often else pytest.param(each, marks=pytest.mark.slow) for each in cases]
