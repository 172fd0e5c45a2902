"""Sessions without a command line."""

import math
import threading
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from trainer.boat.boat import Boat
from trainer.boat.limits import LimitMonitor
from trainer.config.exercise.exercise import ConditionalCasualty
from trainer.config.files import remembering
from trainer.io.orders.schedule import ScheduledOrder
from trainer.io.recording.absence import NoRecording
from trainer.io.recording.recording import Recording
from trainer.io.tables import ColumnSink, NoFile
from trainer.session.attendance import Introduction
from trainer.session.crew.agenda import Agenda
from trainer.session.crew.crew import CrewTalk
from trainer.session.crew.manning import HandWork
from trainer.session.exercise.terms import Terms
from trainer.session.parts import Monitors
from trainer.session.past.header import header_of
from trainer.session.past.history import History
from trainer.session.past.options import RunOptions
from trainer.session.past.plan import Plan, plan_run
from trainer.session.session import ColumnFile, Session
from trainer.session.stations.subscriptions import PromptSender, Roster, Sender
from trainer.session.stations.view import Frame, Pace, Picture, StateReader
from trainer.session.time.ledger import Ledger
from trainer.session.time.pacer import MonotonicClock, Policy
from trainer.session.time.timekeeping import Timekeeping

TROUBLED_SEA = """
schema = "exercise/1"
name = "All at once"
briefing = "A sea, things that break, and everything automatic."
sea = "sea-state-5"
seed = 23

[initial]
depth_m = 40
speed_kn = 8
"""  # the head of an exercise; casualties are added
NOISE_AND_FLOODING = """
[[casualties]]
at_s = 5
name = "depth-gauge-noisy"

[[casualties]]
at_s = 10
name = "flooding-aft"
severity = 0.2
ramp_s = 25
"""
TIME_TO_65_M = """
[[scores]]
name = "Time to 65 m"
measure = "time-to"
quantity = "depth_m"
target = 65
band = 2
full = 30
zero = 300
"""


def session_over(
    boat: Boat,
    time: Timekeeping,
    history: History,
    sending: Sender,
    *,
    rows: tuple[ColumnSink, tuple[str, ...]] = (NoFile(), ()),
    schedule: Sequence[ScheduledOrder] = (),
    armed: Sequence[ConditionalCasualty] = (),
    monitor: LimitMonitor | None = None,
    introduction: Introduction = Introduction(),  # noqa: B008  frozen
    wake: threading.Event | None = None,
    by_hand: dict[str, Any] | None = None,
    terms: Terms = Terms(),  # noqa: B008  frozen
) -> Session:
    """Return a session of a boat; ``by_hand`` is what HandWork is told of the exercise."""
    return Session(
        *(boat, time, history, sending),
        Agenda(boat, schedule, armed),
        CrewTalk(boat, HandWork(boat, **(by_hand or {}))),
        Monitors.over(boat, monitor or LimitMonitor()),
        wake or threading.Event(),
        terms,
        introduction,
        ColumnFile(*rows),
    )


def prompt_sender(boat: Boat, clock: Callable[[], float] = time.monotonic) -> PromptSender:
    """Return what shows a boat to stations at once."""
    return PromptSender(Roster(state_reader(boat)), clock)


def state_reader(boat: Boat) -> StateReader:
    """Return what reads a boat's states for its stations."""
    return StateReader(boat, Ledger(boat.method.step).summary)


def frame_of(boat: Boat, pace: Pace = Pace()) -> Frame:  # noqa: B008  frozen
    """Return what is seen of a boat at this tick."""
    return state_reader(boat).frame(Picture(boat.ticks, boat.records.state.tobytes(), pace))


def free_session(
    boat: Boat, recording: Recording | NoRecording, sending: Sender, **more: Any
) -> Session:
    """Return a session that goes as fast as it can; ``more`` is as for session_over."""
    time = Timekeeping.at(MonotonicClock(), boat.method.step, math.inf, Policy.CATCH_UP)
    return session_over(boat, time, History(boat, recording), sending, **more)


def start_plan(plan: Plan) -> Boat:
    """Return the boat of a plan at its start."""
    boat = Boat(plan.file, plan.method)
    plan.start(boat)
    return boat


def start_exercise(path: Path) -> Boat:
    """Return the boat of an exercise at its start."""
    return start_plan(plan_run(RunOptions(exercise=str(path))))


def begin_run(options: RunOptions) -> tuple[Plan, Boat, dict[str, str]]:
    """Return the plan of the options, its boat started, and the header of its recording."""
    with remembering() as texts:
        plan = plan_run(options)
    boat = start_plan(plan)
    return plan, boat, header_of(options, texts, boat)
