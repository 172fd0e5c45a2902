"""Model people: what an operator does, what its marks are worth, and where that is told."""

import json
import re
from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner, Result
from helpers.places import ROOT

from trainer.authoring import people, validation
from trainer.authoring.exercise_page import baseline_of, plan_exercise, study_exercise
from trainer.authoring.operators import (
    FORGOTTEN_S,
    WRONG_WAY_S,
    PerceivedGauges,
    Person,
    fly_person,
    person_of,
)
from trainer.authoring.people import (
    SKILLS,
    better_share,
    course_figures,
    cronbach_alpha,
    figures_of,
    fly_people,
    item_rests,
    people_data,
    people_text,
    standard_error,
)
from trainer.boat.casualties import InstrumentReadings
from trainer.cli.main import cli
from trainer.config.exercise.baseline import kept_baseline
from trainer.config.files import ConfigError, path_named, read_text, shipped_names
from trainer.core.kernel import Numbers
from trainer.debrief.marks.rehearsal import Rehearsal, fly_rehearsal

DRILL = "heavy-boat"  # by rules alone
BY_HAND = "steady-course"
FAULTLESS = Person(
    number=1,
    skill=1.0,
    react_s=0.0,
    look_s=4.0,
    delay_s=0.0,
    lead=1.0,
    gain=1.0,
    noise_m=0.0,
    wrong_share=0.0,
    omitted_share=0.0,
)


def orders_of(flight: Rehearsal) -> list[tuple[float, str]]:
    """Return the times [s] and orders of the crew."""
    step = flight.plan.method.step
    return [(e.tick * step, e.text) for e in flight.trajectory.orders if e.entry is None]


def flown(person: Person, name: str = DRILL, seed: int = 3) -> list[tuple[float, str]]:
    return orders_of(fly_person(plan_exercise(name), person, seed))


@pytest.fixture
def few() -> Iterator[None]:
    """Have three persons only."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(people, "SKILLS", np.array([0.2, 0.6, 1.0]))
        yield


# An operator


def test_a_faultless_operator_gives_the_reference_crew_s_orders() -> None:
    plan = plan_exercise(DRILL)
    assert flown(FAULTLESS) == orders_of(fly_rehearsal(plan, plan.crew))


def test_an_operator_reacts_later_than_the_rules_and_less_so_to_the_next_step_of_a_chain() -> None:
    prompt = flown(FAULTLESS, "flooding-aft")
    slow = replace(FAULTLESS, react_s=10.0)
    runs = [flown(slow, "flooding-aft", seed) for seed in range(15)]
    assert {tuple(text for _, text in run[:2]) for run in runs} == {(prompt[0][1], prompt[1][1])}
    first, second = np.median([[run[0][0], run[1][0] - run[0][0]] for run in runs], axis=0)
    assert first - prompt[0][0] == pytest.approx(10.0, abs=2.0)
    assert second - (prompt[1][0] - prompt[0][0]) == pytest.approx(3.0, abs=1.0)


def test_an_operator_looks_by_its_own_time_which_varies() -> None:
    times = [seconds for seconds, _ in flown(replace(FAULTLESS, look_s=8.0), BY_HAND)]
    gaps = [after - before for before, after in pairwise(times)]
    assert min(gaps) > 4.0
    assert len({gap % min(gaps) for gap in gaps}) > 3  # they are no multiples of one


@pytest.mark.parametrize("trait", ["gain", "lead", "noise_m", "delay_s"])
def test_each_trait_changes_what_a_hand_orders(trait: str) -> None:
    changed: dict[str, Any] = {trait: 0.5 if trait in ("gain", "lead") else 2.0}
    assert flown(replace(FAULTLESS, **changed), BY_HAND) != flown(FAULTLESS, BY_HAND)


def test_a_gauge_is_perceived_as_it_was_a_delay_ago() -> None:
    boat = plan_exercise(DRILL).launch_boat()
    person = replace(FAULTLESS, delay_s=3.0)
    gauges = PerceivedGauges(boat, person, np.random.default_rng(1))
    gauges.remember((0.5 * i, InstrumentReadings(float(i), 0.1 * i, 0.0, 0.0)) for i in range(21))
    assert gauges.mean("depth", 0.0) == 14.0  # of 20
    assert gauges.now().heading == pytest.approx(1.4)
    assert gauges.rate("depth", 2.0) == pytest.approx(2.0)
    noisy = PerceivedGauges(boat, replace(person, noise_m=2.0), np.random.default_rng(1))
    noisy.seen = gauges.seen
    read = [noisy.mean("depth", 0.0) for _ in range(400)]
    assert np.std(read) == pytest.approx(2.0, rel=0.1)
    assert np.mean(read) == pytest.approx(14.0, abs=0.4)


def test_an_order_the_wrong_way_is_put_right_once_that_is_seen() -> None:
    first_time, first = flown(FAULTLESS)[0]
    wrong, right = flown(replace(FAULTLESS, wrong_share=1.0))[:2]
    assert first.startswith("pump trim aft")
    assert wrong == (first_time, first.replace("aft", "forward"))
    assert right == (first_time + WRONG_WAY_S, first)


def test_a_hand_goes_the_wrong_way_at_first_and_then_the_right_one() -> None:
    right, wrong = (
        [order for order in flown(person, BY_HAND) if order[1].startswith("rudder")]
        for person in (FAULTLESS, replace(FAULTLESS, wrong_share=1.0))
    )
    assert right[0][1].startswith("rudder right")
    assert wrong[0][1].startswith("rudder left")
    turned = next(seconds for seconds, text in wrong if text.startswith("rudder right"))
    assert 0.0 < turned - wrong[0][0] <= WRONG_WAY_S


def test_a_forgotten_order_comes_later() -> None:
    prompt, late = flown(FAULTLESS), flown(replace(FAULTLESS, omitted_share=1.0))
    assert late[0] == (prompt[0][0] + FORGOTTEN_S, prompt[0][1])
    assert len(late) == len(prompt)


def test_a_forgotten_order_never_comes_once_its_control_was_to_be_ordered_anew() -> None:
    bells = {
        share: [
            text
            for _, text in flown(replace(FAULTLESS, omitted_share=share), "stern-plane-jam")
            if text.startswith("bell")
        ]
        for share in (0.0, 1.0)
    }
    assert bells[0.0][0] == "bell astern full"
    assert bells[1.0][0] != "bell astern full"
    assert bells[1.0][-1] == bells[0.0][-1]


def test_a_person_keeps_its_traits_and_others_of_its_skill_have_others() -> None:
    assert person_of(3, 0.4) == person_of(3, 0.4)
    assert person_of(3, 0.4).react_s != person_of(4, 0.4).react_s
    reactions = [
        np.mean([person_of(i, skill).react_s for i in range(50)]) for skill in (0.2, 0.6, 1.0)
    ]
    assert reactions == sorted(reactions, reverse=True)


def test_runs_are_the_same_by_their_seed_and_differ_by_it() -> None:
    person = person_of(3, 0.4)
    assert flown(person, BY_HAND) == flown(person, BY_HAND)
    assert flown(person, BY_HAND) != flown(person, BY_HAND, 4)


# What is made of marks


def test_the_better_has_more_in_a_share_of_the_pairs_and_a_tie_is_half() -> None:
    skills, marks = np.array([1.0, 1.0, 2.0, 3.0]), np.array([5.0, 7.0, 7.0, 6.0])
    # of the pairs (2, 1): won, tied; (3, 1): won, lost; (3, 2): lost
    assert better_share(skills, marks) == pytest.approx((1.0 + 0.5 + 1.0 + 0.0 + 0.0) / 5.0)


def test_the_standard_error_is_the_spread_of_one_person_s_runs() -> None:
    draws = np.random.default_rng(1)
    persons = draws.normal(50.0, 20.0, 4000)
    marks = persons + draws.normal(0.0, 6.0, (2, 4000))
    assert standard_error(marks) == pytest.approx(6.0, rel=0.05)


def test_cronbach_s_alpha_is_that_of_its_other_form() -> None:
    draws = np.random.default_rng(2)
    items = draws.normal(0.0, 1.0, (5, 300)) + draws.normal(0.0, 1.0, 300)
    table = np.cov(items)
    expected = 5.0 / 4.0 * (1.0 - np.trace(table) / table.sum())
    assert cronbach_alpha(items) == pytest.approx(expected)
    assert cronbach_alpha(items) == pytest.approx(5.0 * 0.5 / (1.0 + 4.0 * 0.5), abs=0.05)
    assert cronbach_alpha(np.ones((5, 300))) == 0.0


def test_an_exercise_is_correlated_with_the_others_and_not_with_itself() -> None:
    draws = np.random.default_rng(3)
    skill = draws.normal(0.0, 1.0, 500)
    alike, other = skill + draws.normal(0.0, 0.1, 500), draws.normal(0.0, 1.0, 500)
    runs = {"a": skill, "b": alike, "c": other, "d": np.ones(500)}
    rests = item_rests({name: np.array([first, -first]) for name, first in runs.items()})
    assert rests["c"] == pytest.approx(0.0, abs=0.12)
    assert (rests["a"] or 0.0) > 0.7
    assert rests["d"] is None
    assert item_rests({"a": np.array([skill, skill])}) == {"a": None}


def made_marks(noise: float, names: int = 7, slope: float = 40.0) -> dict[str, Numbers]:
    """Return made-up marks that follow skill, with noise from run to run."""
    draws = np.random.default_rng(4)
    rows = 50.0 + slope * SKILLS + draws.normal(0.0, noise, (names, 2, SKILLS.size))
    return dict(zip(shipped_names("exercises"), rows, strict=False))


def test_a_course_orders_people_by_skill_and_not_by_skills_dealt_by_chance() -> None:
    found = course_figures(made_marks(5.0))
    assert found
    assert found["size"] == 6
    assert found["correlation"] > 0.97
    assert found["better_has_more"] > 0.97
    assert found["alpha"] > 0.9
    assert abs(found["shuffled"]) < 0.05
    assert found["shuffled_spread"] == pytest.approx(1.0 / np.sqrt(39.0), rel=0.2)


def test_marks_by_chance_order_nobody() -> None:
    found = course_figures(made_marks(5.0, slope=0.0))
    assert found
    assert abs(found["correlation"]) < 0.35
    assert found["alpha"] < 0.5


def grades(names: dict[str, Numbers]) -> list[validation.Validation]:
    """Return validations of which the correlation alone is used."""
    return [validation.Validation(name, (1,), {}, {}, 0.97, 0.97, 0.0, "digest") for name in names]


def test_the_text_says_which_exercises_miss_the_bar_and_why() -> None:
    marks = made_marks(1.0, 3)
    easy, loose, good = marks
    marks[easy] = np.full_like(marks[easy], 99.0)
    marks[loose] = np.random.default_rng(5).uniform(0.0, 80.0, marks[loose].shape)
    told = people_text(grades(marks), people_data(marks))
    said = " ".join(told.split())
    assert "1 of 3 exercises order people by 0.85 or more" in said
    assert f"Too easy, most runs have 95 marks or more: {easy}." in said
    assert f"Decided too much by the chances of one run: {loose}." in said
    assert re.search(rf"{good} \d+ \d+ % 0\.97 (0\.9\d|1\.00) ", said)
    assert max(map(len, told.splitlines())) <= 79
    assert told.index(easy) < told.index(good) < told.index(loose)  # the easiest first


def test_one_exercise_alone_has_no_course() -> None:
    marks = made_marks(1.0, 1)
    assert people_data(marks)["course"] is None
    assert "Cronbach" not in people_text(grades(marks), people_data(marks))


# Flown


@pytest.mark.usefixtures("few")
def test_each_person_flies_twice_and_the_seeds_give_the_same_marks() -> None:
    moved: list[int] = []
    found = fly_people([BY_HAND], 1, moved.append)[BY_HAND]
    assert found.shape == (2, 3)
    assert moved == [1, 1]
    assert not np.array_equal(found[0], found[1])
    assert found.mean(axis=0)[0] < found.mean(axis=0)[2]
    assert np.array_equal(found, fly_people([BY_HAND], 1, moved.append)[BY_HAND])


@pytest.mark.slow
def test_the_figures_of_people_that_are_kept_and_told_are_those_that_are_flown() -> None:
    marks = fly_people(shipped_names("exercises"), 1, lambda _: None)
    for name, each in marks.items():
        baseline, now = kept_baseline(path_named(name, "exercises")), figures_of(each)
        assert baseline
        assert baseline.people
        kept, stale = baseline.people, f"trainer exercise validate {name} --keep"
        assert kept.standard_error == pytest.approx(now.standard_error, abs=1.0), stale
        assert kept.correlation == pytest.approx(now.correlation, abs=0.02), stale
        assert kept.mean == pytest.approx(now.mean, abs=1.0), stale
    found, page = course_figures(marks), (ROOT / "docs" / "validation.md").read_text("utf-8")
    assert found
    assert f"| {found['correlation']:.2f} and {found['better_has_more']:.2f} |" in page
    assert f"| {found['alpha']:.2f} |" in page
    rests = [each or 0.0 for each in item_rests(marks).values()]
    assert f"| {min(rests):.2f} (`heavy-boat`) to {max(rests):.2f} |" in page


# Kept, and told


def own_drill(folder: Path) -> str:
    """Return the path of a shipped exercise's copy, without a baseline."""
    path = folder / "drill.toml"
    path.write_text(read_text(path_named("visitor-dive", "exercises")), encoding="utf-8")
    return str(path)


def typed(*words: str) -> Result:
    return CliRunner().invoke(cli, ["exercise", *words])


def test_nothing_is_flown_where_the_figures_could_not_be_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = own_drill(tmp_path)
    monkeypatch.setattr(validation, "validate_exercises", lambda *_: pytest.fail("flown"))
    result = typed("validate", path, "--keep")
    assert isinstance(result.exception, ConfigError)
    assert f"first: trainer exercise baseline {path}" in str(result.exception)


@pytest.mark.usefixtures("few")
def test_the_command_tells_of_people_and_keeps_their_figures(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = own_drill(tmp_path)
    assert typed("baseline", path).exit_code == 0
    monkeypatch.setattr(validation, "validate_exercises", lambda *_: iter(grades({path: SKILLS})))
    monkeypatch.setattr(validation, "validation_data", lambda _: {})
    monkeypatch.setattr(validation, "exercise_text", str)
    monkeypatch.setattr(validation, "summary_text", str)
    monkeypatch.setattr(validation.Validation, "faults", ())
    result = typed("validate", path, "--json", "--cores", "1", "--keep")
    assert result.exception is None or isinstance(result.exception, SystemExit), result.exception
    told = json.loads(result.stdout)["people"]["exercises"][path]
    baseline = kept_baseline(Path(path))
    assert baseline
    assert baseline.people
    assert baseline.people.standard_error == pytest.approx(told["standard_error"], abs=0.05)
    assert baseline.people.persons == 3

    again = baseline_of(study_exercise(path, 1))
    assert again.people == baseline.people
    changed = Path(path).read_text(encoding="utf-8").replace("duration_s", "# an end\nduration_s")
    Path(path).write_text(changed, encoding="utf-8")
    assert baseline_of(study_exercise(path, 1)).people == baseline.people  # a comment flies nothing
    Path(path).write_text(changed.replace("full = 95", "full = 94"), encoding="utf-8")
    assert baseline_of(study_exercise(path, 1)).people is None


@pytest.mark.parametrize("name", shipped_names("exercises"))
def test_a_shipped_exercise_has_the_figures_of_people(name: str) -> None:
    baseline = kept_baseline(path_named(name, "exercises"))
    assert baseline
    assert baseline.people
    assert baseline.people.persons == SKILLS.size


def test_the_page_says_how_many_order_people() -> None:
    found = [kept_baseline(path_named(name, "exercises")) for name in shipped_names("exercises")]
    figures = [each.people for each in found if each and each.people]
    held = sum(min(each.correlation, each.better_has_more) >= 0.85 for each in figures)
    text = (ROOT / "docs" / "validation.md").read_text(encoding="utf-8")
    assert f"{held} of the {len(figures)} exercises" in " ".join(text.split())
