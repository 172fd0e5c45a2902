"""What a session that is played has beside sockets: cables, pages, instruments, older files."""

import contextlib
import sqlite3
from typing import Final

import pytest

from simulation.instruments import CABLE
from simulation.laws import Docket
from simulation.play import Stage, folder_in_memory
from simulation.script import Act, Ending, Farewell, Life, Player, Script, Visit, Way
from trainer.io.recording.file import FILE_FORMAT

pytestmark = pytest.mark.filterwarnings("ignore::ResourceWarning")  # who is killed closes nothing
ORDERS: Final = tuple(Act(0.5, words) for words in ("rudder left 10", "depth 70", "status", "who"))


def begin(*players: Player, seconds: float = 30.0, instruments: bool = False) -> Stage:
    """Return the stage of one life with these players."""
    life = Life(1, seconds, Ending.SIGNAL, 1, players, instruments=instruments)
    return Stage(Script("", 0.0, 1.0, (life,)))


def play(stage: Stage) -> Docket:
    """Play what is on a stage."""
    with folder_in_memory():
        return stage.play()


def test_a_panel_on_a_cable_has_an_answer_for_each_order() -> None:
    docket = play(begin(Player("helm", (Visit(0.1, ORDERS),), way=Way.CABLE)))

    assert not docket.breaches
    assert docket.answers == 1 + len(ORDERS)  # its role is asked for too
    assert [promise.what for promise, _ in docket.promises] == ["rudder left 10"]


def test_a_cable_that_was_pulled_out_is_taken_up_again() -> None:
    visits = Visit(0.1, ORDERS, farewell=Farewell.RESET), Visit(0.1, ORDERS)
    docket = play(begin(Player("helm", visits, way=Way.CABLE)))

    assert not docket.breaches
    assert docket.answers == 2 * (1 + len(ORDERS)) - 1  # the last before the pull is not heard
    assert len(docket.promises) == 2


def test_a_page_comes_by_the_pages_server_to_the_socket_of_this_machine() -> None:
    stage = begin(Player("helm", (Visit(0.1, ORDERS),), way=Way.PAGE))
    docket = play(stage)

    assert not docket.breaches
    assert docket.answers == 1 + len(ORDERS)
    ((promise, _),) = docket.promises
    assert promise.who == "helm at local 1"


def test_a_plotter_hears_and_steers() -> None:
    stage = begin(seconds=60.0, instruments=True)
    docket = play(stage)

    assert not docket.breaches
    steered = {promise.what for promise, _ in docket.promises if CABLE in promise.who}
    assert steered == {"course 045", "rudder left 5", "rudder right 10"}


def test_a_session_without_a_recording_is_played_and_leaves_none() -> None:
    life = Life(1, 20.0, Ending.KILLED, 1, (Player("helm", (Visit(0.1, ORDERS),)),))
    stage = Stage(Script("", 0.0, 1.0, (life, life), recorded=False))
    docket = play(stage)

    assert not docket.breaches
    assert docket.life == 1
    assert docket.answers == 1 + len(ORDERS)
    assert not stage.disk.path.exists()


def test_a_recording_of_format_1_is_gone_on_with() -> None:
    helm = Player("helm", (Visit(0.1, ORDERS),))
    first = Life(1, 10.0, Ending.KILLED, 1, (helm,))
    second = Life(2, 10.0, Ending.SIGNAL, 1, (helm,), aged=True)
    stage = Stage(Script("", 0.0, 1.0, (first, second)))
    with folder_in_memory():
        docket = stage.play()
        with contextlib.closing(sqlite3.connect(stage.disk.path)) as recording:
            (version,) = recording.execute("PRAGMA user_version").fetchone()

    assert not docket.breaches
    assert docket.life == 2
    assert version == FILE_FORMAT
    assert [promise.what for promise, _ in docket.promises] == 2 * ["rudder left 10"]


@pytest.mark.slow
def test_who_reads_slowly_for_an_hour_holds_nobody_up() -> None:
    sips = (Act(1.0, "subscribe gauges"), Act(1.0, "subscribe motion"), Act(3590.0, "who"))
    slow = Player("observer", (Visit(0.1, sips, sip=100),))
    steady = Player("helm", (Visit(0.1, tuple(Act(60.0, "rudder left 10") for _ in range(58))),))
    docket = play(begin(slow, steady, seconds=3600.0))

    assert not docket.breaches
    assert docket.ticks == pytest.approx(7200, abs=2)
    assert len(docket.promises) == 58
