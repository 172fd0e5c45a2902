"""Test depth called out in a session; the collapse of the hull stops the run, which can go back."""

import contextlib
import math
import threading
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from helpers.line import ScriptedLine
from helpers.nursery import Done, run_trainer
from helpers.sessions import free_session, prompt_sender

from trainer.boat.assemble import Method
from trainer.boat.boat import Boat
from trainer.boat.depths import hull_depth
from trainer.config.boat.vessel import load_vessel
from trainer.config.files import ConfigError
from trainer.io.orders.sentences import order_sentence
from trainer.io.recording.recording import Recording
from trainer.session.past.options import RunOptions
from trainer.session.past.plan import plan_run
from trainer.session.stations.roles import Access
from trainer.session.stations.station import Station
from trainer.units import KNOT

STEP = 0.5  # [s]
TEST_DEPTH, COLLAPSE = 85.0, 120.0  # [m]
DIVE = "stern dive 10"
GONE = "this boat cannot go on: {}; backtrack or reset"
CALLS = [
    "Passing test depth, 85 m",
    "Passing 110 m, 25 m beyond test depth",
    "collapse at 12",
]


class Typist(ScriptedLine):
    """A line whose orders come from the test, each once the last is done."""

    ended = False

    def __init__(self, wake: threading.Event, stepping: Callable[[], bool]) -> None:
        super().__init__(wake)
        self.typed: Iterator[str] = iter(())
        self.stepping = stepping

    def take(self, _most: int) -> list[str]:
        if self.stepping():  # on a busy machine lines are heard between the steps
            self.wake.set()
            return []
        self.ended = True
        for line in self.typed:
            self.ended = False
            self.wake.set()
            return [line]
        return []

    def said(self, words: str) -> list[str]:
        return [line for line in self.heard if words in line]


class Watch:
    """A session of BB2 at 60 m, her hull as given, with an instructor and a helm."""

    def __init__(self, test_depth: float | None, collapse_depth: float | None) -> None:
        file = load_vessel("bb2")
        hull = replace(file.hull, test_depth_m=test_depth, collapse_depth_m=collapse_depth)
        file = replace(file, hull=hull)
        self.boat = Boat(file, Method("modified", "lagged", "exact", "adams2", STEP))
        self.boat.start(10.0 * KNOT, 60.0, 0.0)
        self.recording = Recording.create(None, {}, self.boat.records.state.tobytes())
        sending = prompt_sender(self.boat)
        self.session = free_session(self.boat, self.recording, sending)
        control, wake = self.session.control, self.session.wake
        self.instructor, self.helm = (Typist(wake, lambda: control.steps > 0) for _ in range(2))
        for role, line in (("instructor", self.instructor), ("helm", self.helm)):
            station = Station(line, Access(role), sending, self.session.event_log.log)  # type: ignore[arg-type]
            self.session.event_log.stations.append(station)

    def sail(self, typed: Iterator[str]) -> None:
        """Run, frozen at first, on what the instructor types, to its end."""
        self.instructor.typed = typed
        self.session.wake.set()
        with np.errstate(all="ignore"):
            self.session.run(frozen=True)

    @property
    def tick(self) -> int:
        return self.boat.ticks

    @property
    def failure(self) -> str:
        return self.session.control.failure

    def events(self) -> list[str]:
        """Return the recorded events of depth."""
        self.recording.flush()
        return [event.text for event in self.recording.events() if event.kind == "depth"]


@pytest.fixture
def watch() -> Iterator[Watch]:
    made = Watch(TEST_DEPTH, COLLAPSE)
    with contextlib.closing(made.recording):
        yield made


def test_depths_passed_are_told_to_the_instructor_the_crew_and_the_log(watch: Watch) -> None:
    watch.sail(iter([DIVE, "step 1000"]))

    for heard in (watch.instructor.said("Passing "), watch.helm.said("Passing ")):
        assert [line.partition(": ")[2] for line in heard] == [
            f"{CALLS[0]} [2]",  # 1: near test depth, where the boat begins
            f"{CALLS[1]} [3]",
        ]
    told = [line.partition(": ")[2] for line in watch.events()]
    assert [*told[:2], told[2][: len(CALLS[2])]] == CALLS
    assert all(line.startswith("tick ") for line in watch.events())
    assert watch.session.monitors.depths.times.keys() == {"test depth passed"}


def test_programs_are_told_the_depth_passed_and_the_collapse_in_fields(watch: Watch) -> None:
    watch.sail(iter([order_sentence(DIVE), order_sentence("step 1000")]))

    facts = [line.partition("*")[0].split(",") for line in watch.instructor.said("$TRF,")]
    ranks = [fact[5] for fact in facts if fact[3] == "alert-rank"]
    assert ranks[-2:] == ["emergency", "emergency"]
    assert "emergency" not in ranks[:-2]
    told = [fact[3:] for fact in facts if fact[3] in ("depth", "collapse")]
    assert told[:2] == [["depth", "85"], ["depth", "110"]]
    assert told[2][0] == "collapse"
    assert COLLAPSE <= float(told[2][1]) < COLLAPSE + 3.0


def test_at_collapse_depth_the_boat_freezes_and_everybody_is_told(watch: Watch) -> None:
    def typed() -> Iterator[str]:
        yield from (DIVE, "step 1000")
        stopped = watch.tick
        yield from ("run", "step 5", "step 5")
        assert watch.tick == stopped

    watch.sail(typed())

    assert watch.failure.startswith("collapse at 12")
    assert watch.session.time.frozen
    assert watch.session.control.steps == 0
    assert len(watch.instructor.said(f"? {GONE.format(watch.failure)}")) == 3
    for line in (watch.instructor, watch.helm):
        assert len(line.said(f"({watch.boat.time:g} s): {watch.failure}")) == 1
    (last,) = [each.tick for each in watch.recording.flown(1)][-1:]
    assert last == watch.tick


def test_after_a_backtrack_the_run_goes_on(watch: Watch) -> None:
    def typed() -> Iterator[str]:
        yield from (DIVE, "step 1000", "backtrack 30 s")
        assert watch.failure == ""
        before = watch.tick
        yield from ("depth 60", "step 400")
        assert watch.tick == before + 400

    watch.sail(typed())

    assert watch.failure == ""
    assert watch.boat.state.z == pytest.approx(60.0, abs=2.0)
    assert [branch.id for branch in watch.recording.branches()] == [1, 2]


def test_a_depth_passed_is_called_again_after_going_back_to_before_it(watch: Watch) -> None:
    def typed() -> Iterator[str]:
        yield DIVE
        while not watch.helm.said("Passing test depth"):
            yield "step 1"
        yield from ("backtrack 1 s", "step 2")

    watch.sail(typed())

    assert len(watch.helm.said("Passing test depth")) == 2
    assert hull_depth(watch.boat) < TEST_DEPTH + 5.0


def test_while_the_depth_is_frozen_nothing_happens() -> None:
    watch = Watch(TEST_DEPTH, 100.0)
    with contextlib.closing(watch.recording):
        watch.boat.state.z = 90.0
        watch.sail(iter(["freeze depth", DIVE, "step 200"]))

        assert (watch.failure, watch.events()) == ("", [])
        assert watch.tick == 200
        assert watch.boat.state.theta < math.radians(-18.0)


def test_a_boat_without_these_depths_goes_on_down_and_nothing_is_told() -> None:
    watch = Watch(None, None)
    with contextlib.closing(watch.recording):
        watch.sail(iter([DIVE, "step 400"]))

        assert watch.boat.state.z > 180.0
        assert (watch.failure, watch.events(), watch.session.monitors.depths.times) == ("", [], {})
        assert watch.instructor.said("Passing") == []


# As its user has it


def trainer(folder: Path, *words: str, typed: str = "") -> Done:
    """Return what the command did."""
    return run_trainer(*words, cwd=folder, typed=typed, timeout=120)


@pytest.fixture(scope="module")
def wreck(tmp_path_factory: pytest.TempPathFactory) -> "tuple[Path, str, str, int]":
    """Return the folder, output, complaints and exit code of BB2's headless dive to collapse."""
    folder = tmp_path_factory.mktemp("wreck")
    (folder / "dive.txt").write_text("1 stern dive 10\n1 bow dive 10\n")
    words = ("--speed", "max", "--duration", "1h", "--orders", "dive.txt")
    ran = trainer(
        *(folder, "run", "--headless", *words),
        "--record",
        "dive.trainer",
        "--csv",
        "dive.csv",
        "--verbose",
    )
    return folder, ran.stdout, ran.stderr, ran.returncode


@pytest.mark.process
def test_a_headless_run_past_collapse_depth_ends_with_exit_code_1_and_says_so(
    wreck: tuple[Path, str, str, int],
) -> None:
    folder, out, err, code = wreck
    assert code == 1
    assert "trainer: frozen: collapse at 45" in err
    assert "events      test depth passed 1 time (first at " in out
    lines = (folder / "dive.csv").read_text().splitlines()
    column = lines[0].split(",").index("z")
    deepest = [float(line.split(",")[column]) for line in lines[1:]]
    assert 400.0 < deepest[-1] == max(deepest) < 455.0


@pytest.mark.process
def test_a_collapse_resumed_is_a_collapse_until_somebody_goes_back(
    wreck: tuple[Path, str, str, int],
) -> None:
    folder = wreck[0]
    alone = trainer(folder, "resume", "dive.trainer", "--headless", "--speed", "max")
    assert alone.returncode == 1
    assert "in 0 ticks" in alone.stdout
    assert "trainer: frozen: collapse at 45" in alone.stderr
    typed = "run\nbacktrack 2 min\nautopilot on\ndepth 100\nrun\n"
    ran = trainer(
        *(folder, "resume", "dive.trainer", "--speed", "max", "--duration", "10m"), typed=typed
    )
    assert ran.returncode == 0, ran.stderr
    assert "? this boat cannot go on: collapse at 45" in ran.stdout
    assert "simulated   600.0 s" in ran.stderr


@pytest.mark.process
def test_a_run_that_is_resumed_has_the_alerts_that_were_acknowledged(tmp_path: Path) -> None:
    exercise_at(tmp_path, 230.0)
    words = ("run", "deep.toml", "--record", "deep.trainer", "--duration", "60", "--frozen")
    ran = trainer(tmp_path, *words, typed="step 4\nack 1\nstep 2\nquit\n")
    assert ran.returncode == 0, ran.stderr
    resumed = trainer(tmp_path, "resume", "deep.trainer", "--frozen", typed="alerts\nquit\n")
    seen = "1 alarm at 00:00:00, acknowledged: Near test depth: 30 m above it; acknowledged by "
    assert f"{seen}instructor after 2 s" in resumed.stdout, resumed.stdout
    assert "00:00:03, active" not in resumed.stdout


def exercise_at(folder: Path, depth: float) -> RunOptions:
    """Return the options of an exercise of BB2 that begins at a depth [m]."""
    path = folder / "deep.toml"
    heading = 'schema = "exercise/1"\nname = "Deep"\nbriefing = "Deep."\nvessel = "bb2"\n'
    path.write_text(f"{heading}[initial]\ndepth_m = {depth:g}\n")
    return RunOptions(exercise=str(path))


def test_an_exercise_must_not_begin_where_the_hull_is_lost(tmp_path: Path) -> None:
    with pytest.raises(ConfigError) as caught:
        plan_run(exercise_at(tmp_path, 450.0))
    assert str(caught.value) == (
        "deep.toml: [initial] depth_m = 450 m: must be less than collapse_depth_m = 450 m "
        "of bb2.toml"
    )
    assert plan_run(exercise_at(tmp_path, 449.0)).initial.depth_m == 449.0
