"""A script is played: its processes one after the other, each until its end."""

import contextlib
import io
import itertools
import os
import re
import tempfile
import traceback
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from threading import Event
from typing import Final

import pytest

from simulation.admission import secrets_of
from simulation.disk import Disk, Image, Trouble
from simulation.instruments import NMEA_OPTIONS, Plotter
from simulation.laws import (
    FOREVER_NS,
    SAFE_AFTER_NS,
    Docket,
    Law,
    Witness,
    check_debriefs,
    check_kept,
    check_secrets,
    check_whole,
)
from simulation.machine import LADEN_TURN_NS, SECOND_NS, TURN_NS, Machine, Task
from simulation.network import Network
from simulation.script import Ending, Life, Point, Script, Way
from simulation.seam import played_on
from simulation.stations import Program
from simulation.traffic import Air, fleet_text
from simulation.wires import Wires
from trainer.config.exercise.outcome import Outcome
from trainer.config.files import ConfigError, read_text, shipped_path
from trainer.io.recording import recording as recordings
from trainer.io.recording.recording import Recording
from trainer.session import resume as resume_module
from trainer.session import run as run_module
from trainer.session.exercise.marks import DebriefSource, Judgement, WrittenDebrief
from trainer.session.past.options import RunOptions
from trainer.session.resume import resume_boat
from trainer.session.run import run_boat

END_TIMEOUT_NS: Final = 60 * SECOND_NS  # for a session to end, once it is asked to
KILL_TIMEOUT_NS: Final = 10 * SECOND_NS  # for the turns until a kill
MAX_AWAKE_NS: Final = 3 * SECOND_NS // 2  # after which a machine that slept has asked its disk
DEBRIEFED_EVERY: Final = 8  # scripts, by their first seed: a debrief takes as long as a play does
JUDGE_TIMES_S: Final = (0.0, 0.1, 1.0, 3.0)  # that marks take
EVALUATOR_WORDS: Final = ("evaluator",)  # what is begun by it is ``seam``'s
WRITE_TIME_S: Final = 0.5  # that a debrief takes
RAM_FOLDER: Final = Path("/dev/shm")  # noqa: S108  where there is one: files that no disk waits for
AIDS: Final = 'aids = ["ghost", "predictor"]'  # that an exercise with a duration of ours allows
RECORDING: Final = "it.trainer"
LOCAL_SOCKET: Final = "here.sock"
NARROW_BYTES: Final = 100_000  # that wait at most on a narrow machine: some seconds of ticks
NOTHING_LEFT: Final = Image(b"", b"")

Change = Callable[[], contextlib.AbstractContextManager[object]]  # of the product


def play(script: Script, *changes: Change) -> Docket:
    """Play a script on a machine of its own. Return what was seen.

    The product is changed as ``changes`` say, as long as it is played.
    """
    with folder_in_memory(), contextlib.ExitStack() as stack:
        for change in changes:
            stack.enter_context(change())
        return Stage(script).play()


@contextlib.contextmanager
def folder_in_memory() -> Iterator[None]:
    """Stand in a new folder, which is gone afterwards: no path is on any line."""
    where = RAM_FOLDER if os.access(RAM_FOLDER, os.W_OK) else None
    folder = tempfile.TemporaryDirectory(prefix="trainer-s-", dir=where, ignore_cleanup_errors=True)
    with folder as name, contextlib.chdir(name):
        yield


def exercise_of(script: Script) -> str:
    """Return the exercise of a script, "" for none.

    Where the script has a duration or a fleet, it is a file with that.
    """
    if script.fleet:
        path = Path("fleet.toml")
        path.write_text(fleet_text(script.fleet, script.duration))
        return str(path)
    if not script.duration:
        return script.exercise
    text = read_text(shipped_path("exercises", script.exercise))
    path = Path(f"{script.exercise}.toml")
    lines = f"duration_s = {script.duration}\n{AIDS}"
    path.write_text(re.sub(r"(?m)^duration_s = .*$", lines, text))
    return str(path)


def has_unanswered(path: Path) -> bool:
    """Return whether a recording has an order that nobody was answered."""
    with contextlib.closing(Recording.look(path)) as recording:
        orders = recording.orders(recording.last_branch())
    return any(order.accepted is None for order in orders)


@contextlib.contextmanager
def room_for(life: Life) -> Iterator[None]:
    """Let a narrow process keep little in memory while its disk is out of reach."""
    with pytest.MonkeyPatch.context() as patch:
        if life.narrow:
            patch.setattr(recordings, "MAX_WAITING_BYTES", NARROW_BYTES)
        yield


def cable_of(number: int) -> str:
    """Return the URL of the cable of a program."""
    return f"cable {number}"


@dataclass
class Stage:
    """The machine on which one script is played, and who looks on."""

    script: Script
    machine: Machine = field(default_factory=Machine)
    network: Network = field(init=False)
    wires: Wires = field(init=False)
    disk: Disk = field(init=False)
    docket: Docket = field(init=False)
    witness: Witness = field(init=False)
    air: Air = field(default_factory=Air)
    _programs: list[Program] = field(default_factory=list)
    _mishaps: int = 0  # that have begun
    _booted: int = 0  # [ns] the present process
    _ended: bool = False  # the present process
    _left: Image = NOTHING_LEFT  # of the recording, by the process before
    at_end: Callable[["Stage"], bool] = lambda _: (
        False
    )  # asked when a process's time is over: more?
    _others: list[Task] = field(default_factory=list)  # of the programs, then of the mishaps
    _idle_since: int = 0  # [ns] when the last mishap was over

    def __post_init__(self) -> None:
        self.network, self.disk = Network(self.machine), Disk(self.machine)
        self.wires = Wires(self.network)
        self.docket = Docket(self.machine)
        self.witness = Witness(self.docket, self.machine)
        self.docket.log.where = self.where
        self.disk.is_amidst = lambda: self.witness.amidst

    def play(self) -> Docket:
        """Play all processes, then look at the file.

        None follows one that ends by itself or breaks a law.
        """
        with played_on(self.machine, self.network, self.disk, self.wires) as patch:
            self.witness.watch(patch)
            self.air.watch(patch)
            for module in (run_module, resume_module):  # `next`: it has another recording
                patch.setattr(module, "run_following", lambda ended, *_: ended.code)
            for number in itertools.count(1):
                self.docket.life = number
                with room_for(self.life):
                    goes_on = self._live(self.life)
                if not goes_on or self.docket.breaches or number == len(self.script.lives):
                    break
        if self.script.recorded and not self.docket.breaches:
            check_kept(self.docket, self.disk.path, until=FOREVER_NS)
            check_whole(self.docket, self.disk.path)
            check_secrets(self.docket, self.disk.path, secrets_of(self.script.tokens))
            if self.script.lives[0].seed % DEBRIEFED_EVERY == 0:
                check_debriefs(self.docket, self.disk.path)
        return self.docket

    @property
    def life(self) -> Life:
        """Return the present process of the script."""
        return self.script.lives[self.docket.life - 1]

    def go_on(self, script: Script) -> None:
        """Go on by another script, which is the same up to here."""
        self.script, machine = script, self.machine
        machine.redraw(self.life.redrawn)
        for program, player, task in zip(
            self._programs, self.life.players, self._others, strict=False
        ):
            program.go_on(player, task)
        befallen, mishaps = self._others[len(self._programs) :], self.life.mishaps
        if befallen and befallen[0].is_idle and self._mishaps < len(mishaps):
            befallen[0].wake_at(self._idle_since, mishaps[self._mishaps].after)
            self._mishaps += 1

    def where(self) -> Point:
        """Return the present point; the beginning of the next process where this one has ended."""
        life, machine = self.docket.life, self.machine
        if self._ended:
            return Point(life + 1, 0, 0.0)
        places = tuple(program.place for program in self._programs)
        seconds = (machine.now - self._booted) / SECOND_NS
        return Point(life, machine.turns, seconds, places, self._mishaps)

    def _live(self, life: Life) -> bool:
        """Play a process to its end; return whether another goes on with its recording."""
        machine, first = self.machine, self.docket.life == 1
        machine.boot(life.seed, life.interleaving, life.redrawn)
        machine.turn = LADEN_TURN_NS if life.laden else TURN_NS
        self._programs, self._mishaps, self._booted, self._ended = [], 0, machine.now, False
        self._others = []
        self.network.boot()
        self.wires.boot()
        self.air.boot()
        path = Path(f"{self.docket.life}") / RECORDING
        path.parent.mkdir()
        if not first:
            self._left.write(path)
        self.disk.boot(path, slow=life.slow_disk)
        if life.aged and not first:
            self.disk.age()
        lives, number = self.script.lives, self.docket.life
        before = lives[number - 2] if number > 1 else None
        self.docket.log.begin(life, number, self.disk, before)
        self.witness.session, self.witness.amidst = None, False
        self.docket.forget_pictures()
        with contextlib.redirect_stderr(io.StringIO()), contextlib.redirect_stdout(io.StringIO()):
            session = machine.begin(lambda: self._serve(life), "session")
            others = self._begin_others(life)
            self._let_live(session)
            life = self.life  # which may have been drawn anew
            self._look(session, others)
            goes_on = self._end(life, session)
            machine.kill()
        machine.now += int(life.rest * SECOND_NS)
        return goes_on

    def _begin_others(self, life: Life) -> int:
        """Begin the stations and the mishaps of a process; return how many tasks."""
        for number, player in enumerate(life.players):
            hear = self._hearing(number)
            cable = self.wires.cable(cable_of(number)) if player.way is Way.CABLE else None
            program = Program(
                *(player, number, self.machine, self.network, self.docket, hear, cable),
                tokens=self.script.tokens,
            )
            self._programs.append(program)
            self._others.append(self.machine.begin(program.run, f"{player.role} {number}"))
        if life.instruments:
            plotter = Plotter(self.machine, self.wires, self.docket, self.air)
            self.machine.begin(plotter.run, "plotter")
        if life.mishaps:
            self._others.append(self.machine.begin(self._befall, "mishaps"))
        return len(self.machine.tasks) - 1

    def _hearing(self, number: int) -> Callable[[bytes], None]:
        trace, machine = self.docket.trace, self.machine
        return lambda data: trace.update(b"%d:%d:" % (number, machine.now) + data)

    def _let_live(self, session: Task) -> None:
        """Let the process live for its time, and a killed one for some turns more."""
        machine = self.machine

        def is_over() -> object:
            return session.done or machine.deaths or self.docket.breaches

        machine.run(self._booted + int(self.life.seconds * SECOND_NS), is_over)
        while not is_over() and self.at_end(self):
            machine.run(self._booted + int(self.life.seconds * SECOND_NS), is_over)
        life = self.life
        if life.ending is not Ending.SIGNAL:  # the very turn is drawn, too
            if life.amidst:
                self._strike_amidst(life, session)
                return
            last, promises, answered = machine.turns + life.turns, self.docket.promises, 0

            def strikes() -> bool:
                nonlocal answered
                if machine.turns < last:
                    answered = len(promises)
                    return False
                awaited = (life.awaited in ("", each.kind) for each, _ in promises[answered:])
                return not life.at_answer or any(awaited)

            machine.run(
                machine.now + KILL_TIMEOUT_NS,
                lambda: session.done or machine.deaths or strikes(),
            )

    def _strike_amidst(self, life: Life, session: Task) -> None:
        """Let a process live until an order is journalled, and has no answer yet.

        Where the power goes, its thread stands still there until the disk has what it wrote.
        """
        machine, disk, witness = self.machine, self.disk, self.witness

        def strikes() -> bool:
            if life.ending is Ending.KILLED:
                return witness.amidst
            machine.held = session if witness.amidst else None
            return disk.kept_amidst

        machine.run(
            machine.now + KILL_TIMEOUT_NS,
            lambda: session.done or machine.deaths or strikes(),
        )

    def _look(self, session: Task, others: int) -> None:
        """Look at what a process has done, L8 to L10."""
        machine = self.machine
        for name, error in machine.deaths:
            where = "".join(traceback.format_exception(error)[-3:])
            self.docket.enter(Law.LIVES, f"the thread {name} died: {where}")
        if not session.done:
            self.witness.check_bounds(len(machine.tasks) - others, self.disk)

    def _end(self, life: Life, session: Task) -> bool:
        """End a process as the script says; return whether another is to go on."""
        machine = self.machine
        self._ended = True
        goes_on = not (session.done or machine.deaths or self.docket.breaches)
        if goes_on and life.ending is not Ending.SIGNAL and not self.script.recorded:
            goes_on = False
        elif goes_on and life.ending is not Ending.SIGNAL:
            self._cut(life)
        elif goes_on:
            goes_on = False
            if self.witness.session:
                self.docket.log.see_signal(self.witness.session)
                self.witness.session.stop()
            machine.run(machine.now + END_TIMEOUT_NS, lambda: session.done)
            if self.witness.session and not session.done:
                self.docket.enter(Law.LIVES, "it does not end within 60 s of a signal")
        for name, at in machine.spinning[:1]:
            self.docket.enter(Law.RESTS, f"the thread {name} spins at {at / SECOND_NS:.3f} s")
        return goes_on

    def _cut(self, life: Life) -> None:
        """Take what a killed process leaves, or one without power; L1."""
        disk, session, now, ending = self.disk, self.witness.session, self.machine.now, life.ending
        self.witness.leave(killed=ending is Ending.KILLED)
        system = Image.of(disk.path)
        self._left, until, since = system, FOREVER_NS, 0
        disk.kept = disk.kept or Image(system.file, b"")  # it was made whole, and never asked for
        self.docket.kills += ending is Ending.KILLED
        if ending is Ending.POWER:
            self.docket.power_cuts += 1
            self._left = disk.kept
            told = session and session.history.recording.behind  # then nothing is promised
            asleep = now - disk.woken_at < MAX_AWAKE_NS
            until, since = 0 if told or asleep else now - SAFE_AFTER_NS, disk.opened_at
        looked = Path(f"{self.docket.life}-left") / RECORDING
        looked.parent.mkdir()
        self._left.write(looked)
        unanswered = has_unanswered(looked)
        self.docket.log.see_end(session, life, unanswered=unanswered)
        check_kept(self.docket, looked, until=until, since=since)

    def _befall(self) -> None:
        """Let befall the machine what is to, then wait for more."""
        while True:
            if self._mishaps < len(self.life.mishaps):
                self._mishaps += 1
                self.machine.sleep(self.life.mishaps[self._mishaps - 1].after)
            else:
                self._idle_since = self.machine.now
                self.machine.wait(lambda: False)
            mishap = self.life.mishaps[self._mishaps - 1]
            self.docket.log.see_mishap(mishap.trouble)
            if mishap.trouble is Trouble.RIVAL:
                self._begin_rival()
            else:
                self.disk.trouble(mishap.trouble, mishap.seconds)

    def _begin_rival(self) -> None:
        """L14: begin another session on the recording, which has to be refused."""
        if not (self.script.recorded and self.witness.session):
            return
        options = RunOptions(serve=True, listen="127.0.0.1:0", socket="none", headless=True)
        try:
            resume_boat(self.disk.path, options, anyway=False)
        except ConfigError:
            self.docket.log.see_rival()
        else:
            self.docket.enter(Law.SOLE, "a second session has gone on with the recording")

    def _serve(self, life: Life) -> None:
        """Be the process: a session that is served, begun or gone on with."""
        script = self.script
        options = {
            "serve": True,
            "listen": "127.0.0.1:0",
            "socket": LOCAL_SOCKET,
            "priority": "normal",
            "headless": True,
            "unsafe_step": True,
            "speed": script.speed,
            "frozen": life.frozen,
            "token": script.tokens,
            "lines": tuple(
                f"{player.role}={cable_of(number)}"
                for number, player in enumerate(life.players)
                if player.way is Way.CABLE
            ),
            **(NMEA_OPTIONS if life.instruments else {}),
        }
        source = DebriefSource(self._judge, self._write, EVALUATOR_WORDS)
        if self.docket.life > 1:
            resume_boat(self.disk.path, RunOptions(**options), source, anyway=False)  # type: ignore[arg-type]
            return
        begun = {
            "exercise": exercise_of(script) or None,
            "record": self.disk.path if script.recorded else None,
            "no_record": not script.recorded,
            "given": frozenset({"exercise"}),
        }
        run_boat(RunOptions(**options, **begun), debriefing=source)  # type: ignore[arg-type]

    def _judge(self, path: Path, branch: int) -> Judgement:
        self.machine.sleep(self.machine.dice.choice(JUDGE_TIMES_S))
        with contextlib.closing(Recording.look(path)) as recording:
            return Judgement(Outcome.WON, float(recording.last_tick(branch)), ("reason",))

    def _write(
        self, path: Path, _branch: int, _closing: Event, share: Callable[[float], object]
    ) -> WrittenDebrief:
        share(0.5)
        self.machine.sleep(WRITE_TIME_S)
        return WrittenDebrief(f"{path.stem}.html")
