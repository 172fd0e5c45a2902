"""How near the filter's push comes to the strips' sum, and would with a phase for each strip."""

from itertools import product

import pytest

from fits.strips import HEADINGS, HEIGHTS_M, SPEEDS_KN, ratios


@pytest.mark.parametrize(
    ("state", "heave", "pitch"), [(4, 0.60, 1.09), (5, 0.88, 1.15), (6, 0.95, 1.14)]
)
def test_the_push_in_a_head_sea_is_what_the_page_says(
    state: int, heave: float, pitch: float
) -> None:
    found = ratios(state, "head", 4.0, own_phase=False)

    assert found[:2] == pytest.approx((heave, pitch), abs=0.015)
    assert found.heave_frequency == pytest.approx(1.17, abs=0.025)


def test_strips_of_their_own_phase_would_be_near_but_in_one_following_sea() -> None:
    cases = product(HEIGHTS_M, HEADINGS, SPEEDS_KN)
    off = {case for case in cases if any(abs(r - 1.0) > 0.1 for r in ratios(*case, own_phase=True))}

    assert off == {(4, "following", 10.0)}
    worst = ratios(4, "following", 10.0, own_phase=True)
    assert worst[:2] == pytest.approx((1.06, 0.99), abs=0.01)
    assert worst[2:] == pytest.approx((1.14, 1.13), abs=0.01)
