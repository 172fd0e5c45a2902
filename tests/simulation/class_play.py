"""A class of three sessions is played by a seed, with the product's one sea."""

import contextlib
import io
import traceback
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from types import SimpleNamespace
from typing import Any, Final, NamedTuple

import pytest

from simulation.class_laws import ClassLaw, Sea
from simulation.class_machine import OUTSIDE, ClassMachine, ClassNetwork, LoyalDisk
from simulation.class_script import BOATS, LIVE_S, ClassScript, Kill, draw_class, mark_of
from simulation.disk import Image
from simulation.laws import Docket, check_whole
from simulation.machine import SECOND_NS
from simulation.network import FIRST_PORT, Socket
from simulation.play import RECORDING, Change, folder_in_memory
from simulation.seam import played_on
from simulation.threads import Threading
from simulation.wires import Wires
from trainer.classroom import one_sea
from trainer.classroom.one_sea import OneSea
from trainer.io import client
from trainer.io.orders.sentences import order_sentence
from trainer.io.recording.recording import Recording
from trainer.io.serial_line import LinkError
from trainer.session.dispatch import Dispatch
from trainer.session.past.options import RunOptions
from trainer.session.resume import resume_boat
from trainer.session.run import run_boat
from trainer.session.session import Session
from trainer.session.stations.station import Request

SLICE_S: Final = 0.1  # between two looks at all boats
QUIET_S: Final = 9.0  # in which all dial again and hear each other
REDIAL_S: Final = 0.3
CALM: Final = ("run", "run", "time x{speed:g}")  # out of a replay, and out of a freeze


class ClassPlayed(NamedTuple):
    """What came of a seed."""

    seed: int
    breaches: tuple[str, ...]
    counts: dict[str, int]
    trace: str  # the digest of all recordings


def play_class(seed: int, *changes: Change) -> ClassPlayed:
    """Play the class of a seed, the product changed as ``changes`` say."""
    with folder_in_memory(), contextlib.ExitStack() as stack:
        for change in changes:
            stack.enter_context(change())
        return ClassStage(draw_class(seed)).play()


@dataclass
class ClassLine:
    """The class's line to a session, as ``trainer.io.client.dial`` gives one."""

    number: int
    end: Socket
    sea: Sea
    trouble: str = ""
    ended: bool = False
    _rest: bytes = b""
    _unsent: bytes = b""

    def send(self, text: str) -> None:
        self.sea.hear(self.number, text)
        self._unsent += text.encode() + b"\r\n"
        with contextlib.suppress(BlockingIOError):
            while self._unsent:
                try:
                    self._unsent = self._unsent[self.end.send(self._unsent) :]
                except BlockingIOError:
                    raise
                except OSError:
                    self.ended, self._unsent = True, b""

    def take(self, _most: int) -> Sequence[str]:
        try:
            came = self.end.recv(1_000_000)
            self.ended = self.ended or not came
        except BlockingIOError:
            came = b""
        except OSError:
            came, self.ended = b"", True
        *lines, self._rest = (self._rest + came).split(b"\r\n")
        taken = [line.decode("ascii") for line in lines]
        self.sea.reach(self.number, taken)
        return taken

    def close(self, _patience: float) -> None:
        self.end.close()


@dataclass
class Captain:
    """The instructor of one boat, who comes back to it when its process has died."""

    number: int
    stage: "ClassStage"
    heard: bytearray = field(default_factory=bytearray)
    done: bool = False
    _end: Socket | None = None

    def run(self) -> None:
        """Say all that the script has, then have the boat go on quietly."""
        machine, script = self.stage.machine, self.stage.script
        for said in script.says[self.number]:
            machine.sleep(said.after)
            self._say(said.words)
        machine.wait(lambda: self.stage.calm)
        for words in CALM:
            machine.sleep(SLICE_S)
            self._say(words.format(speed=script.speed))
        self.done = True

    def _say(self, words: str) -> None:
        while not self._send(words):
            self._end = self._dial()

    def _dial(self) -> Socket:
        while (end := self.stage.network.reach(self.number)) is None:
            self.stage.machine.sleep(REDIAL_S)
        self._end = end
        self._send("role instructor")
        return end

    def _send(self, words: str) -> bool:
        """Send a line, and take all that came; return whether the line is there."""
        if self._end is None:
            return False
        line = f"{order_sentence(words)}\r\n".encode()
        try:
            while line:
                line = line[self._end.send(line) :]
            while self._end.readable:
                came = self._end.recv(1_000_000)
                if not came:
                    return False
                self.heard += came
        except OSError:
            self._end = None
            return False
        return True


class ClassStage:
    """The machine on which one class is played, and who looks on."""

    def __init__(self, script: ClassScript) -> None:
        self.script = script
        self.machine = ClassMachine()
        self.network = ClassNetwork(self.machine)
        self.sea = Sea(self.machine, script.spacing)
        self.docket = Docket(self.machine)
        self.captains = [Captain(number, self) for number in BOATS]
        self.calm = False
        self.kills = 0
        self._lives = dict.fromkeys(BOATS, 0)
        self._told: list[str] = []  # by the class, at its terminal

    def play(self) -> ClassPlayed:
        """Play all, then look at the files."""
        machine, script = self.machine, self.script
        machine.boot(script.seed, 0.05)
        disk, wires = LoyalDisk(machine), Wires(self.network)
        quiet = io.StringIO()
        with (
            played_on(machine, self.network, disk, wires) as patch,
            contextlib.redirect_stderr(quiet),
            contextlib.redirect_stdout(quiet),
        ):
            self._watch(patch)
            for number in BOATS:
                self._begin(number)
            for captain in self.captains:
                machine.begin_in(OUTSIDE, captain.run, f"captain {captain.number}")
            sea = self._begin_sea()
            self._live()
            machine.begin_in(OUTSIDE, sea.end, "end of the sea")
            self._pass(1.0)
            paths = [self._path(number) for number in BOATS]
            for number in BOATS:
                machine.kill_process(number)
            machine.kill()
        if not self.sea.breaches:
            for number, path in zip(BOATS, paths, strict=True):
                self._check_file(number, path)
            self._check_heard()
        told = {f"told {what}": count for what, count in self.sea.told.items()}
        counts = {"classes": 1, "kills": self.kills, **told}
        breaches = tuple(map(str, self.sea.breaches))
        return ClassPlayed(script.seed, breaches, counts, self.docket.trace.hexdigest())

    def _watch(self, patch: pytest.MonkeyPatch) -> None:
        """Know the sessions, and give the class the machine's lines and threads."""
        begin, tick, hear = Session.__post_init__, Session.tick, Dispatch.hear

        def begin_noted(session: Session, *given: Any) -> None:
            begin(session, *given)
            self.sea.begin(self.machine.process, session)

        def tick_noted(session: Session) -> None:
            tick(session)
            self.sea.look()

        def hear_noted(dispatch: Dispatch, asked: Request) -> None:
            hear(dispatch, asked)
            self.sea.look()  # the next order may hide where this one has brought the boat

        patch.setattr(Session, "__post_init__", begin_noted)
        patch.setattr(Session, "tick", tick_noted)
        patch.setattr(Dispatch, "hear", hear_noted)
        patch.setattr(one_sea, "threading", Threading(self.machine))
        patch.setattr(client, "dial", self._dial)

    def _dial(self, number: int, *_: object) -> ClassLine:
        end = self.network.reach(number)
        if end is None:
            raise LinkError("no session listens there")
        return ClassLine(number, end, self.sea)

    def _begin_sea(self) -> OneSea:
        rows: dict[int, Any] = {
            number: SimpleNamespace(address=number, title=f"boat {number}") for number in BOATS
        }
        spacing, clock = self.script.spacing, lambda: self.machine.now / SECOND_NS
        sea = OneSea(rows, spacing, "", self._told.append, clock)
        self.machine.begin_in(OUTSIDE, sea.begin, "class")
        return sea

    def _path(self, number: int) -> Path:
        return Path(f"{number}-{self._lives[number]}") / RECORDING

    def _begin(self, number: int) -> None:
        """Begin the process of a boat, anew or from what the one before has left."""
        before = self._path(number)
        self._lives[number] += 1
        path = self._path(number)
        path.parent.mkdir()
        first = not before.exists()
        if not first:
            Image.of(before).write(path)
        self.machine.begin_in(number, self._serving(number, path, first=first), "session")

    def _serving(self, number: int, path: Path, *, first: bool) -> Callable[[], object]:
        options = {
            "serve": True,
            "listen": f"127.0.0.1:{FIRST_PORT + number}",
            "socket": "none",
            "priority": "normal",
            "headless": True,
            "speed": self.script.speed,
        }
        if first:
            return lambda: run_boat(RunOptions(**options, record=path))  # type: ignore[arg-type]
        frozen = RunOptions(**options, frozen=True)  # type: ignore[arg-type]
        return lambda: resume_boat(path, frozen, anyway=False)

    def _live(self) -> None:
        """Let all live, and kill who is to be killed."""
        begun = self.machine.now
        for seconds, act in sorted(self._acts(), key=lambda each: each[0]):
            self._pass(seconds - (self.machine.now - begun) / SECOND_NS)
            act()
        self._pass(LIVE_S - (self.machine.now - begun) / SECOND_NS)
        self.calm = True
        while not all(captain.done for captain in self.captains):
            self._pass(SLICE_S)
        self._pass(QUIET_S)
        self.sea.check_quiet()

    def _acts(self) -> Iterator[tuple[float, Callable[[], object]]]:
        """Yield when what befalls the processes; one that is dead already is not killed."""
        free = dict.fromkeys(BOATS, 0.0)
        for kill in self.script.kills:
            if kill.at < free[kill.boat]:
                continue
            free[kill.boat] = kill.at + kill.rest + 1.0
            yield kill.at, partial(self._kill, kill)
            yield kill.at + kill.rest, partial(self._begin, kill.boat)

    def _kill(self, kill: Kill) -> None:
        self.kills += 1
        self.sea.end(kill.boat)
        self.machine.kill_process(kill.boat)
        self.network.kill_process(kill.boat)

    def _pass(self, seconds: float) -> None:
        """Let time go on, and look at all boats in between."""
        machine = self.machine
        until = machine.now + int(max(seconds, 0.0) * SECOND_NS)
        while machine.now < until:
            machine.run(min(machine.now + int(SLICE_S * SECOND_NS), until))
            self.sea.look()
            for name, error in machine.deaths:
                where = "".join(traceback.format_exception(error)[-3:])
                self.sea.enter(ClassLaw.LIVES, f"the thread {name} died: {where}")
            machine.deaths.clear()

    def _check_file(self, number: int, path: Path) -> None:
        """C1 and C4: a recording has nothing of another boat, and is replayed alone."""
        check_whole(self.docket, path)
        for breach in self.docket.breaches:
            self.sea.enter(ClassLaw.ALONE, f"boat {number}: {breach.text}")
        self.docket.breaches.clear()
        with contextlib.closing(Recording.look(path)) as recording:
            texts = [event.text for event in recording.events()]
            given = [each for b in recording.branches() for each in recording.orders(b.id)]
        said = {each.words for each in self.script.says[number]}
        for order in given:
            about = order.text.startswith(("contact boat", "contact boats"))
            if about != (order.giver.role == "class") or f"boat {number} " in order.text:
                self.sea.enter(ClassLaw.APART, f"boat {number} has {order.text!r} of {order.who}")
        marks = {text for text in texts if text.startswith(mark_of(number, 0)[:8])}
        if foreign := {text for text in marks if f"mark {text}" not in said}:
            self.sea.enter(ClassLaw.APART, f"boat {number} has the marks {sorted(foreign)}")

    def _check_heard(self) -> None:
        """C1: no instructor's line has heard of another boat's marks."""
        for captain in self.captains:
            for other in BOATS:
                if other != captain.number and mark_of(other, 0)[:-1].encode() in captain.heard:
                    self.sea.enter(ClassLaw.APART, f"boat {captain.number} hears boat {other}")
