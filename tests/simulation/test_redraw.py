"""A script is played again up to a point, exactly, and goes on with other chance."""

import random
from pathlib import Path

import pytest

from simulation.chains import compare, draw_chains, plant
from simulation.drawing import draw_script, redraw
from simulation.exploring import Explorer
from simulation.milestones import MILESTONES
from simulation.play import play
from simulation.script import (
    Act,
    Ending,
    Life,
    Player,
    Point,
    Script,
    Visit,
    read_script,
    write_script,
)
from simulation.seeds import explore

pytestmark = pytest.mark.filterwarnings("ignore::ResourceWarning")  # who is killed closes nothing


@pytest.mark.long
@pytest.mark.parametrize("seed", [2, 3, 5])
def test_what_was_reached_before_a_point_is_reached_again_at_the_same_turn(
    seed: int, tmp_path: Path
) -> None:
    script = draw_script(seed, 5.0)
    reached = play(script).log.reached
    points = sorted(p for p in reached.values() if p and p.turns)
    point = random.Random(seed).choice(points)  # noqa: S311  no secret
    before = {n: (p.life, p.turns) for n, p in reached.items() if p and p[:2] <= point[:2]}

    others = [redraw(script, point, other, 3.0) for other in (1, 2)]

    write_script(others[0], tmp_path / "script.json")
    assert read_script(tmp_path / "script.json") == others[0]
    for other in others:
        again = play(other).log.reached
        assert {n: (p.life, p.turns) for n in before if (p := again[n])} == before
    assert others[0] != others[1]


def test_a_new_pair_in_order_is_a_place_to_go_on_from_and_a_cheaper_way_replaces_it() -> None:
    first, second = MILESTONES[:2]
    explorer, script = Explorer(1, 5.0), draw_script(1, 5.0)
    early, late = Point(1, 10, 1.0), Point(1, 90, 9.0)

    assert explorer.learn(script, {first: early, "word run": early, second: late}) == [
        (first,),
        (second,),
        (first, second),
    ]
    assert not explorer.learn(script, {first: early, second: late})
    assert explorer.places[first, second].point == late
    explorer.learn(script, {first: early, second: early})
    assert explorer.places[first, second].point == early
    assert explorer.learn(script, {second: early, first: late}) == [(second, first)]
    assert explorer.counts[first, second] == 3


@pytest.mark.long
def test_scripts_go_on_from_where_others_came_and_hold_every_law() -> None:
    played = list(explore(1, 12, 3.0))

    assert not [(each.seed, *map(str, each.breaches)) for each in played if each.breaches]
    went_on = [each for each in played if any(life.redrawn for life in each.script.lives)]
    assert went_on
    assert len(went_on) < len(played)


@pytest.mark.long
def test_a_chain_of_three_events_breaks_a_law_where_it_is_planted_alone() -> None:
    words = ("freeze", "snapshot A", "step 2", "restore A", "in 9 s depth 80", "run", "step 2")
    chain = (
        "L3: a jump in a freeze",
        "L17: a plan is made in a freeze",
        "L17: a plan is cancelled",
    )
    rows = [[*chain[:2]], [*chain[1:]]]
    assert draw_chains(rows, 1, 1) == [chain]
    acts = tuple(Act(0.3, each) for each in (*words, "cancel all", "step 3", "who"))
    life = Life(1, 5.0, Ending.SIGNAL, 1, (Player("instructor", (Visit(0.1, acts),)),))
    script = Script("", 0.0, 1.0, (life,))

    assert play(script, plant(chain)).breaches
    assert not play(script, plant(chain[::-1])).breaches


@pytest.mark.long
def test_two_ways_are_compared_by_the_same_chains() -> None:
    *lines, last = compare(0.5, 1)

    assert len(lines) == 10
    assert all(line.startswith("plain ") and line.count(", then ") == 2 for line in lines)
    assert " of 10 in " in last
