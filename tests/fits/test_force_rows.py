"""The wave filter's tables are those that their program makes."""

import numpy as np
import pytest
from helpers.typed import type_command

from fits.__main__ import fits
from trainer.core.sea.wave_filter import FORCE_ROWS, LENGTH_TABLE

pytestmark = pytest.mark.slow


def test_the_program_writes_them_as_they_stand_in_the_core() -> None:
    done = type_command(fits)

    rows = [line.split() for line in done.output.splitlines() if not line[0].isupper()]
    found = np.array([float(word) for row in rows[1:] for word in row])
    written = np.concatenate([np.swapaxes(FORCE_ROWS, 2, 3).ravel(), LENGTH_TABLE.ravel()])
    assert found == pytest.approx(written, rel=1e-9, abs=1e-9)
