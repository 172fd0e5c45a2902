"""A policy that learns by numbers: how soon it is good, and that a seed learns the same."""

import time

import numpy as np
import pytest

from trainer.analysis.learning import Policies, baselines, lines, shared_ranks

MOST_S = 60.0  # [s] of one core
GOOD_PERCENT = 90.0


def test_equal_marks_share_the_mean_of_their_ranks() -> None:
    ranks = shared_ranks(np.array([3.0, 1.0, 1.0, 9.0, 1.0]))

    assert ranks.tolist() == [0.25, -0.25, -0.25, 0.5, -0.25]
    assert shared_ranks(np.full(4, 7.0)).tolist() == [0.0] * 4


def test_a_policy_acts_by_its_own_weights_within_its_limits() -> None:
    policies = Policies(18, 2)
    weights = np.zeros((3, policies.ends[-1]))
    weights[1, -2:] = 0.5, -50.0

    actions = policies.act(weights, np.ones((3, 18)))

    assert actions.tolist() == [[0.0, 0.0], [np.tanh(0.5), -1.0], [0.0, 0.0]]


@pytest.mark.slow
def test_a_seed_learns_the_first_depth_change_in_a_minute_and_the_same_again() -> None:
    begun = time.process_time()
    first = baselines("first-depth-change", 1, 40)
    taken = time.process_time() - begun
    again = baselines("first-depth-change", 1, 40)

    marks = {row.who: min(row.marks) for row in first.rows}
    assert marks["learned by seed 1"] >= GOOD_PERCENT
    assert marks["nobody aboard"] == 0.0
    assert taken <= MOST_S
    assert first == again
    assert first != baselines("first-depth-change", 2, 2)
    assert "reference crew" in "\n".join(lines(first))
