"""How a crew worked, told from its journal: made crews, some with one planted fault each."""

from dataclasses import dataclass, field, replace
from pathlib import Path
from random import Random
from typing import Final

import pytest
from helpers.givers import giver_at
from helpers.recorded import record

from trainer.debrief.page.data import debrief_figures
from trainer.debrief.page.page import read_dossier, render
from trainer.debrief.passage.crew_work import WHOLE_CREW, CrewWork, judge_crew
from trainer.debrief.passage.episodes import spoken_orders
from trainer.debrief.passage.watches import Watch
from trainer.io.recording.facts import NO_CREW_FACT, CrewFact, CrewNews
from trainer.io.recording.recording import RecordedOrder

STEP: Final = 0.1
SPACING: Final = 150.0  # [s] between two orders
KINDS: Final = (
    *(
        "not repeated",
        "repeated late",
        "repeated wrong",
        "not reported",
        "taken in silence",
        "busy",
    ),
)
AXES: Final = {"course": "helm", "speed": "helm", "depth": "planes"}


@dataclass
class MadeCrew:
    """A crew of helm, planes, ballast and an officer, with its journal."""

    lines: list[tuple[float, str, str, CrewFact]] = field(default_factory=list)
    carried_out: dict[str, float] = field(default_factory=dict)
    end: float = 0.0

    def say(self, seconds: float, role: str, text: str, fact: CrewFact = NO_CREW_FACT) -> None:
        self.lines.append((seconds, role, text, fact))

    @property
    def work(self) -> CrewWork:
        """Return what is told of it."""
        journal = [
            RecordedOrder(
                n,
                1,
                round(t / STEP),
                giver_at(f"{role} at x"),
                text,
                None,
                accepted=True,
                answer="",
                crew=c,
            )
            for n, (t, role, text, c) in enumerate(sorted(self.lines, key=lambda each: each[0]), 1)
        ]
        spoken = [
            replace(each, carried_out=round(self.carried_out[each.told] / STEP))
            for each in spoken_orders(journal)
        ]
        found = judge_crew(journal, spoken, STEP, round(self.end / STEP))
        assert found
        return found


def make_crew(seed: int, fault: str = "") -> tuple[MadeCrew, str]:
    """Return a sound crew, or one with that fault, and the role of who is to blame."""
    draw, crew = Random(seed), MadeCrew()  # noqa: S311  choices, not secrets
    count = draw.randint(3, 8)
    planted, blamed = draw.randrange(count), ""
    for i in range(count):
        at, axis = 20.0 + SPACING * i, draw.choice(list(AXES))
        role, number = AXES[axis], 10 + 7 * i + draw.randint(0, 6)
        told = f"{axis} {number:03d}" if axis == "course" else f"{axis} {number}"
        now = fault if i == planted else ""
        blamed = role if i == planted else blamed
        crew.say(at, draw.choice(["deck", "diving", "instructor"]) if axis != "depth" else "deck",
                 f"order {told}", CrewFact(CrewNews.ORDERED, told))  # fmt: skip
        crew.carried_out[told] = done = at + draw.uniform(20.0, 70.0)
        if now == "repeated wrong":
            wrong = CrewFact(CrewNews.WRONG_REPEAT, told)
            crew.say(at + draw.uniform(1.0, 3.0), role, f"{axis} {number + 1} aye", wrong)
        wait = draw.uniform(10.5, 30.0) if now == "repeated late" else draw.uniform(3.5, 9.5)
        if now != "not repeated":
            crew.say(at + wait, role, f"{told} aye", CrewFact(CrewNews.REPEATED, told))
        if now not in ("not reported", "not repeated"):
            crew.say(done + draw.uniform(0.5, 40.0), role, f"report at {number}")
        work(crew, draw, at, done, axis)
        if now == "taken in silence":
            blamed = "pilot"
            crew.say(done + 5.0, "pilot", "rudder left 3" if role == "helm" else "bow planes zero")
        if now == "busy":
            for _ in range(draw.randint(24, 40)):
                crew.say(at + draw.uniform(5.0, 60.0), role, hand_order(draw, role))
    crew.end = 20.0 + SPACING * count
    return crew, blamed


def hand_order(draw: Random, role: str) -> str:
    """Return an order by hand of a helmsman or planesman."""
    if role == "helm":
        return f"rudder {draw.choice(['left', 'right'])} {draw.randint(1, 20)}"
    return f"stern planes {draw.choice(['dive', 'rise'])} {draw.randint(1, 20)}"


def work(crew: MadeCrew, draw: Random, at: float, done: float, axis: str) -> None:
    """Let hands work as sound ones do, a relief and a control taken by a word included."""
    for role in ("helm", "planes"):
        for _ in range(draw.randint(2, 12)):
            crew.say(draw.uniform(at + 4.0, done), role, hand_order(draw, role))
    if draw.random() < 0.3:
        crew.say(done + 45.0, "planes", "relief Berg")
    if draw.random() < 0.3:
        crew.say(done + 46.0, "diving", "have planes")
        crew.say(done + 47.0, "diving", "bow planes dive 5")
        crew.say(done + 50.0, "planes", "have planes")
    if axis == "depth" and draw.random() < 0.5:
        crew.say(done + 20.0, "ballast", "report trim pumped")


def found_share(seeds: range) -> float:
    """Return the share of planted faults that are told, of the right station or of the crew."""
    found = 0
    for seed in seeds:
        kind = KINDS[seed % len(KINDS)]
        crew, role = make_crew(seed, kind)
        told = {(each.kind, each.role) for each in crew.work.faults}
        found += (kind, role) in told or (kind, WHOLE_CREW) in told
    return found / len(seeds)


def blamed_crews(seeds: range) -> list[int]:
    """Return the sound crews of which a fault is told."""
    return [seed for seed in seeds if make_crew(seed)[0].work.faults]


def test_a_planted_fault_is_found_and_a_sound_crew_is_not_blamed() -> None:
    assert found_share(range(24)) >= 0.95
    assert not blamed_crews(range(1000, 1012))


@pytest.mark.slow
def test_faults_of_200_crews_are_found_and_none_of_100_sound_ones_is_blamed() -> None:
    assert found_share(range(100, 300)) >= 0.95
    assert not blamed_crews(range(2000, 2100))


@pytest.mark.parametrize("kind", KINDS)
def test_a_fault_is_told_alone(kind: str) -> None:
    crew, role = make_crew(8, kind)

    assert {(each.kind, each.role) for each in crew.work.faults} == {(kind, role)}


def loop(*more: tuple[float, str, str]) -> MadeCrew:
    """Return a crew that has had one order, with what else was said."""
    crew = MadeCrew(carried_out={"depth 80": 40.0}, end=200.0)
    crew.say(10.0, "deck", "order depth 80", CrewFact(CrewNews.ORDERED, "depth 80"))
    for seconds, role, text in more:
        news = CrewNews.REPEATED if text == "aye" else CrewNews.NOTHING
        crew.say(seconds, role, text, CrewFact(news, "depth 80") if text == "aye" else NO_CREW_FACT)
    return crew


def test_a_loop_is_closed_by_a_report_of_its_number() -> None:
    told = loop((14.0, "planes", "aye"), (50.0, "planes", "report at 80 metres")).work

    assert (told.orders, told.repeated, told.closed, told.latency_s) == (1, 1, 1, 4.0)
    assert told.informed == (("planes", "deck", 2),)
    assert loop((14.0, "planes", "aye"), (50.0, "planes", "report at 70")).work.closed == 0
    assert loop((14.0, "planes", "aye"), (50.0, "helm", "report at 80")).work.closed == 0


def test_what_either_of_two_stations_should_have_repeated_is_the_crew_s_fault() -> None:
    told = loop((20.0, "planes", "bow planes zero"), (30.0, "diving", "report heavy")).work

    assert [(each.kind, each.role) for each in told.faults] == [("not repeated", WHOLE_CREW)]
    assert told.informed == (("diving", "all", 1),)


def test_who_works_what_another_has_is_told_once_until_somebody_says_he_has_it() -> None:
    turns = [(20.0 + i, ("planes", "pilot")[i % 2], "bow planes zero") for i in range(6)]
    words = [(30.0, "pilot", "have planes"), (31.0, "planes", "stern planes zero")]
    words += [(32.0, "planes", "have planes"), (33.0, "pilot", "bow planes zero")]
    told = loop((14.0, "planes", "aye"), *turns, *words).work

    taken = [(each.role, each.what) for each in told.faults if each.kind == "taken in silence"]
    assert taken == [
        ("pilot", "the planes, which planes had"),
        ("planes", "the planes, which pilot had"),
        ("pilot", "the planes, which planes had"),
    ]


def test_a_debrief_has_a_section_of_a_crew_s_work(tmp_path: Path) -> None:
    said = {1.0: "order depth 75", 2.0: "stern planes dive 2", 3.0: "aye"}
    alone = record(tmp_path / "alone.trainer", "first-depth-change", said, duration=30.0)
    debrief = read_dossier(alone, None)
    assert debrief_figures(debrief)["crew_work"] is None
    assert "How this crew worked" not in render(debrief)

    other = loop((14.0, "planes", "aye"), (15.0, "pilot", "bow planes zero")).work
    watches = (Watch("planes", "Ott", 0, 150), Watch("planes", "Berg", 150))
    page = render(replace(debrief, crew_work=other, watches=watches))

    assert "1 orders to the crew 1 were repeated, half of them within 4 s" in page
    assert "<td>planes (Berg)</td><td>not reported</td>" in page.replace("\n", "")
