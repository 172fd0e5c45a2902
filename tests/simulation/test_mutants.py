"""Each fault put back into the product breaks a law, so the laws that hold say something."""

from typing import Final

import pytest
from helpers.places import TESTS

from simulation.mutants import FAULTS, FOUND, Fault, with_fault
from simulation.play import play
from simulation.script import draw_script, read_script

SEEDS: Final = 100  # within which each is found
LONGEST_S: Final = 10.0  # that a process lives
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
