"""Each fault put back into the product breaks a law, so the laws that hold say something."""

import dataclasses
from typing import Final

import pytest
from helpers.places import TESTS

from simulation.drawing import draw_script
from simulation.laws import Law
from simulation.mutants import FAULTS, FOUND, Fault, with_fault
from simulation.play import play
from simulation.script import Act, read_script
from simulation.seeds import breaks_law
from simulation.shrink import shrink

SEEDS: Final = 100  # within which each is found
LONGEST_S: Final = 5.0  # that a process lives
pytestmark = pytest.mark.filterwarnings("ignore::ResourceWarning")  # who is killed closes nothing


@pytest.mark.slow
@pytest.mark.parametrize("fault", FAULTS.values(), ids=FAULTS)
def test_a_fault_put_back_is_found_within_a_hundred_seeds(fault: Fault) -> None:
    scripts = (draw_script(seed, LONGEST_S) for seed in range(1, 1 + SEEDS))

    assert any(play(script, with_fault(fault)).breaches for script in scripts)


@pytest.mark.long
@pytest.mark.parametrize("name", FOUND)
def test_the_script_of_a_fault_that_was_found_shows_it(name: str) -> None:
    script = read_script(TESTS / "simulation" / "kept" / f"{name}.json")

    assert play(script, with_fault(FOUND[name])).breaches
    assert not play(script).breaches


def test_a_script_that_breaks_a_law_is_shrunk_to_what_breaks_it() -> None:
    script = read_script(TESTS / "simulation" / "kept" / "question-kills.json")
    life = script.lives[0]
    visit = life.players[0].visits[0]
    wordy = dataclasses.replace(visit, acts=(Act(0.0, "who"), *visit.acts, Act(0.1, "status")))
    player = dataclasses.replace(life.players[0], visits=(wordy,))
    wordy_life = dataclasses.replace(life, players=(player,), slow_disk=True)
    fault = with_fault(FOUND["question-kills"])

    small = shrink(
        dataclasses.replace(script, lives=(wordy_life,)),
        lambda each: breaks_law(each, Law.LIVES, fault),
    )

    ((visit,),) = (player.visits for player in small.lives[0].players)
    assert [act.words for act in visit.acts] == ["branches"]
    assert not small.lives[0].slow_disk
