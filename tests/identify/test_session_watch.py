"""A watch joins a session as a client, tells its instructor, and harms nobody when it dies."""

import json
import subprocess
from pathlib import Path
from typing import Any, cast

import pytest
from helpers.fitted_bb2 import fitted_bb2
from helpers.nursery import run_trainer, start_trainer
from helpers.waiting import await_that

from trainer.cli.workshop.live_watch import SessionWatch
from trainer.config.boat.vessel import load_vessel
from trainer.config.files import ConfigError
from trainer.console.client import Client, LineLoss, RoleRefusal, RoleTaken
from trainer.identify.boat.live import LiveRecord
from trainer.identify.boat.vessel import FittedVessel
from trainer.identify.boat.watch import WatchFiles
from trainer.io.orders.sentences import Sentence

FLOODED_AT = 480  # [s] of the session
TOLD_WITHIN = 300  # [s]
SPEED = 20  # of time


def manoeuvres(path: Path) -> Path:
    """Write a schedule that moves every surface, and the speed."""
    orders = {1: "trim manual"}
    for k in range(30):
        orders[5 + 60 * k] = f"rudder {('right', 'left')[k % 2]} 10"
        orders[9 + 48 * k] = f"bow planes {('dive', 'rise')[k % 2]} 5"
        orders[31 + 120 * k] = f"turns {(9, 11)[k % 2]}"
    orders[FLOODED_AT] = "casualty flooding-centre 0.3"
    path.write_text("".join(f"{t} {orders[t]}\n" for t in sorted(orders)), encoding="utf-8")
    return path


@pytest.mark.process
@pytest.mark.slow
def test_the_instructor_is_told_of_flooding_and_the_recording_says_the_same(tmp_path: Path) -> None:
    fitted, where = fitted_bb2(tmp_path, 1), tmp_path / "s"
    turns = load_vessel("bb2").propulsion.rps_per_mps  # as the trials were logged
    own = next(line for line in fitted.read_text("utf-8").splitlines() if "rps_per_mps" in line)
    fitted.write_text(fitted.read_text("utf-8").replace(own, f"rps_per_mps = {turns}"), "utf-8")
    words = ["serve", "--vessel", "bb2", "--equations", "full", "--frozen", "--speed", str(SPEED)]
    words += ["--orders", str(manoeuvres(tmp_path / "orders")), "--socket", str(where)]
    words += ["--listen", "none", "--record", str(tmp_path / "day.trainer")]
    with start_trainer(*words, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL) as session:
        for line in session.stderr or ():
            if "listening" in line:
                break
        watch = start_trainer(
            *("boat", "watch", str(fitted), "--connect", str(where)),
            stderr=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
        )
        for line in watch.stderr or ():
            if "watching" in line:
                break
        instructor = Client(lambda: str(where), "instructor", {})
        instructor.start()
        marks, answered = list[tuple[float, str]](), list[str]()

        def hear() -> bool:
            for item in instructor.take():
                if isinstance(item, Sentence) and item.kind == "TRF" and item.fields[2] == "mark":
                    marks.append((float(item.fields[1]), item.fields[3]))
                if isinstance(item, Sentence) and item.kind == "TRA":
                    answered.append(item.fields[0])
            return bool(marks)

        await_that(lambda: instructor.order("run"))
        await_that(hear)
        told, text = marks[0]
        assert FLOODED_AT < told < FLOODED_AT + TOLD_WITHIN, marks
        assert text.startswith("watch: weight +")
        watch.kill()
        watch.communicate()
        answered.clear()
        instructor.order("rudder left 5")
        await_that(lambda: hear() and answered)
        assert answered == ["ok"]
        instructor.order("quit")
        session.communicate()
        assert session.returncode == 0
        instructor.close(1.0)
    done = run_trainer("boat", "watch", str(fitted), str(tmp_path / "day.trainer"), "--json")
    change = json.loads(done.stdout)["change"]
    assert change["parts"][0]["name"] == "weight"
    assert FLOODED_AT < change["told"]["seconds"] < told + TOLD_WITHIN


class HeardClient:
    """A client that only notes what is ordered."""

    def __init__(self) -> None:
        self.ordered: list[str] = []

    def order(self, words: str) -> str:
        self.ordered.append(words)
        return "1"


def watch_of_bb2() -> tuple[SessionWatch, list[str]]:
    """Return a watch of BB2 that has not been let in yet, and what it tells."""
    vessel, told = FittedVessel(load_vessel("bb2")), list[str]()
    files = WatchFiles(cast("Any", None), cast("Any", None), ())
    client = cast("Client", HeardClient())
    return SessionWatch(files, client, told.append, LiveRecord(vessel)), told


def fact(what: str, subject: str) -> Sentence:
    return Sentence("TRF", "", ("100", "50.000", what, subject))


def test_a_watch_follows_jumps_losses_and_the_end_of_its_session() -> None:
    watch, told = watch_of_bb2()
    watch.take(RoleTaken())
    assert cast("HeardClient", watch.client).ordered == ["name watch"]
    watch.take(fact("range", "length=70.2"))
    watch.record.rows[5] = {"depth": 60.0}
    watch.take(fact("back", "backtrack 2 min"))
    assert not watch.record.rows
    watch.take(LineLoss("gone"))
    watch.take(fact("over", ""))
    assert watch.over
    assert told == [
        "watching",
        "begins anew: time has jumped",
        "the line is lost: gone; it is tried again",
    ]


def test_a_session_of_another_boat_or_that_lets_nobody_in_is_refused() -> None:
    watch, _ = watch_of_bb2()
    with pytest.raises(ConfigError, match=r"boat is 1\.6 m long, and bb2\.toml is 70\.2 m"):
        watch.take(fact("range", "length=1.6"))
    with pytest.raises(ConfigError, match="does not let a watch in: wrong token"):
        watch.take(RoleRefusal("wrong token"))


def test_a_replay_is_no_reading_of_the_boat() -> None:
    watch, _ = watch_of_bb2()
    watch.take(Sentence("TRN", "", ("time", "time:", "replay:")))
    watch.take(Sentence("TRN", "", ("steering", "rudder:deg")))
    for replay, heard in (("yes", -1), ("no", 7)):
        watch.take(Sentence("TRS", "", ("time", "7", "3.5", "running", replay)))
        watch.take(Sentence("TRS", "", ("steering", "7", "3.5", "1.0")))
        assert watch.record.latest == heard
