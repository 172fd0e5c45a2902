"""A script that breaks a law is made smaller, and what is left comes when it came."""

import dataclasses

import pytest
from helpers.places import TESTS

from simulation.laws import Law
from simulation.mutants import FOUND, with_fault
from simulation.script import Act, Life, Script, draw_script, read_script
from simulation.seeds import breaks_law
from simulation.shrink import shrink, smaller

pytestmark = pytest.mark.filterwarnings("ignore::ResourceWarning")  # who is killed closes nothing


def acts_of(script: Script) -> list[Act]:
    return [
        act
        for life in script.lives
        for player in life.players
        for visit in player.visits
        for act in visit.acts
    ]


def test_what_breaks_nothing_is_taken_away() -> None:
    script = next(
        script
        for script in map(draw_script, range(100))
        if len(script.lives) > 2 and script.acts > 50
    )
    culprit = acts_of(script)[script.acts // 2].words

    small = shrink(script, lambda each: culprit in [act.words for act in acts_of(each)], 10_000)

    assert [act.words for act in acts_of(small)] == [culprit]
    assert len(small.lives) == 1
    assert not small.lives[0].mishaps


def test_what_is_left_comes_when_it_came() -> None:
    script = next(script for script in map(draw_script, range(100)) if script.acts > 20)

    def last_at(life: Life) -> float:
        visit = life.players[0].visits[0]
        return visit.after + sum(act.after + act.pause for act in visit.acts)

    first = script.lives[0].players[0].visits[0]
    shorter = [
        each
        for each in smaller(script)
        if len(each.lives) == len(script.lives)
        and each.lives[0].players
        and each.lives[0].players[0].visits
        and 0 < len(each.lives[0].players[0].visits[0].acts) < len(first.acts)
        and each.lives[0].players[0].visits[0].acts[-1].words == first.acts[-1].words
        and each.lives[0].players[0].visits[0].after == first.after
    ]

    assert shorter
    assert all(
        last_at(each.lives[0]) == pytest.approx(last_at(script.lives[0])) for each in shorter
    )


def test_no_more_scripts_are_played_than_are_allowed() -> None:
    played: list[Script] = []

    def breaks_none(script: Script) -> bool:
        played.append(script)
        return False

    shrink(draw_script(2), breaks_none, tries=7)

    assert len(played) == 7


def test_a_script_that_breaks_a_law_is_shrunk_to_what_breaks_it() -> None:
    fault = with_fault(FOUND["question-kills"])
    script = read_script(TESTS / "simulation" / "kept" / "question-kills.json")
    life = script.lives[0]
    visit = life.players[0].visits[0]
    wordy = dataclasses.replace(visit, acts=(Act(0.0, "who"), *visit.acts, Act(0.1, "status")))
    player = dataclasses.replace(life.players[0], visits=(wordy,))
    script = dataclasses.replace(
        script, lives=(dataclasses.replace(life, players=(player,), slow_disk=True),)
    )

    small = shrink(script, lambda each: breaks_law(each, Law.LIVES, fault))

    assert [act.words for act in acts_of(small)] == ["branches"]
    assert not small.lives[0].slow_disk
