"""How often actions are drawn follows from what seeds reached."""

import tomllib
from collections import Counter

from simulation.milestones import MILESTONES, SAID_MILESTONES
from simulation.weights import (
    MOST_CHANGE,
    WEIGHTS_PATH,
    Sample,
    find_unweighed,
    given_weights,
    read_weights,
    weigh,
)


def test_the_weights_are_of_the_present_actions_and_milestones() -> None:
    assert not find_unweighed(), "run `python -m tests.simulation --weigh`"
    table = tomllib.loads(WEIGHTS_PATH.read_text(encoding="utf-8"))
    assert table["reached"].keys() == {*MILESTONES, *SAID_MILESTONES}
    assert table["seeds"] > 0
    for kind, words in given_weights().items():
        for word, given in words.items():
            weight = read_weights()[kind][word]
            assert given / MOST_CHANGE - 0.001 <= weight <= given * MOST_CHANGE + 0.001


def test_what_leads_to_a_rare_milestone_is_drawn_more_often() -> None:
    common, rare = "L3: a jump in a freeze", "L3: a replay within a replay"
    often = Sample({"instructor": Counter({"run": 5, "plans": 1})}, frozenset({common}))
    seldom = Sample({"instructor": Counter({"run": 1, "hint": 5})}, frozenset({common, rare}))
    before = given_weights()

    after = weigh([*(20 * [often]), seldom], before)

    gain = {
        word: after["instructor"][word] / before["instructor"][word] for word in ("hint", "run")
    }
    assert gain["hint"] > 1.2
    assert gain["run"] < 1.0
    assert after["helm"] == before["helm"]  # nobody said anything
