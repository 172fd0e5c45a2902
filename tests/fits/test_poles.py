"""The wave filter's poles, its rows for the elevation and its fading are what programs make."""

import numpy as np
import pytest

from fits.fading import fitted_fading
from fits.poles import poles_of, searched_numbers, stored_poles, wave_rows
from trainer.core.sea.forces import FADING_FIT
from trainer.core.sea.wave_filter import WAVE_ROWS

pytestmark = pytest.mark.slow
BANKS = (0, 1)


@pytest.mark.parametrize("bank", BANKS)
def test_the_search_ends_where_the_stored_poles_are(bank: int) -> None:
    made = poles_of(searched_numbers(bank))
    assert np.abs(made - stored_poles(bank)).max() < 1e-4


@pytest.mark.parametrize("bank", BANKS)
def test_the_rows_of_the_elevation_are_made_again(bank: int) -> None:
    assert pytest.approx(WAVE_ROWS[bank], rel=1e-9, abs=1e-9) == wave_rows(bank).T


def test_the_fading_of_the_suction_is_made_again() -> None:
    assert fitted_fading() == pytest.approx(FADING_FIT, rel=1e-5)  # it stands with six digits
