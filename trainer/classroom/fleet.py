"""The boats of a class: sessions in processes of their own, kept at sea.

A session writes its recording as it goes. So one whose process has died is resumed from it, frozen,
and the others notice nothing. All that a boat leaves lies in the folder of the class: recordings in
a folder of the boat's, what the process has said in a text. Sockets lie elsewhere, because their
paths have to be short.

Each process ends with its owner, however that ends, because its standard input ends then.
"""

import contextlib
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import KW_ONLY, dataclass, field
from enum import Enum
from pathlib import Path
from socket import socket
from typing import Final, Protocol

from trainer.config.exercise.class_file import CLASS_FILE_NAME, BoatRow, ClassFile
from trainer.io import client
from trainer.io.paths import LISTENING_TEXT, RECORDING_SUFFIX

FIRST_RESTART_S: Final = 0.25  # until a dead session is begun again, twice as long each time after
MAX_RESTART_WAIT_S: Final = 8.0
STEADY_TIME_S: Final = 30.0  # after which a session has done well, and waits are short again
END_TIMEOUT_S: Final = 30.0  # for a session to end its recording
WRONG_INPUT: Final = 2  # the exit code of what a restart cannot mend
LAST_BYTES: Final = 4000  # of what a session has said, in which its last line is looked for

Tell = Callable[[str], None]


class BoatState(Enum):
    """What has become of a boat. The value is the word that pages get."""

    STARTING = "starting"
    AT_SEA = "at sea"
    RESUMING = "resuming"
    ENDED = "ended"  # in order, by its instructor
    LOST = "lost"  # a restart would not mend it
    AWAY = "away"  # of another machine, which does not answer


class AnyBoat(Protocol):
    """A boat of a class, wherever its session runs."""

    row: BoatRow
    state: BoatState
    resumed: int

    @property
    def title(self) -> str:
        """Return its number, and its name if it has one."""

    @property
    def address(self) -> str:
        """Return where its session listens."""

    def reach(self) -> socket:
        """Return a line to its session; LinkError."""

    def begin(self) -> None:
        """Begin it."""

    def ask_to_end(self) -> None:
        """Ask its session to end."""

    def end(self, timeout_s: float) -> None:
        """Wait until its session has ended, for so long [s] at most."""

    def has_ended(self) -> bool:
        """Return whether it will not be at sea again."""


@dataclass
class ClassBoat:
    """One boat of a class: its session's process, which a thread keeps alive."""

    row: BoatRow
    folder: Path  # of the class
    local_socket: Path  # where its session listens
    exercise: str
    tokens: Sequence[str]
    tell: Tell
    _: KW_ONLY
    follows_course: bool = False  # that of the class's file
    state: BoatState = BoatState.STARTING
    resumed: int = 0  # how often its process has died and was begun again
    _process: subprocess.Popen[bytes] | None = None
    _thread: threading.Thread | None = None
    _closing: threading.Event = field(default_factory=threading.Event)
    _lock: threading.Lock = field(default_factory=threading.Lock)  # of the process's beginning

    @property
    def title(self) -> str:
        """Return its number, and its name if it has one."""
        return self.row.title

    @property
    def address(self) -> str:
        """Return where its session listens."""
        return str(self.local_socket)

    def reach(self) -> socket:
        """Return a line to its session; LinkError."""
        return client.reach(self.address)

    @property
    def recordings(self) -> Path:
        """Return the folder of its recordings."""
        return self.folder / f"boat-{self.row.number}"

    @property
    def process(self) -> int:
        """Return the number of its session's process, 0 without one."""
        return self._process.pid if self._process else 0

    def begin(self) -> None:
        """Begin its session, or go on with its latest recording; OSError without room for it."""
        self.recordings.mkdir(mode=0o700, exist_ok=True)
        self._launch()
        self._thread = threading.Thread(target=self._keep, name=self.title, daemon=True)
        self._thread.start()

    def ask_to_end(self) -> None:
        """Ask its session to end, and begin it no more."""
        with self._lock:
            self._closing.set()
            if self._process is not None:
                self._process.terminate()

    def end(self, timeout_s: float) -> None:
        """Wait until its session has ended; kill it after ``timeout_s`` [s]."""
        if self._process is not None:
            try:
                self._process.wait(timeout_s)
            except subprocess.TimeoutExpired:
                self._process.kill()
                self.tell(f"{self.title} did not end in {timeout_s:g} s, and was killed")
        if self._thread is not None:
            self._thread.join()

    def has_ended(self) -> bool:
        """Return whether nothing will be at sea again."""
        return self.state in (BoatState.ENDED, BoatState.LOST)

    @property
    def _said(self) -> Path:
        return self.folder / f"boat-{self.row.number}.log"

    def _launch(self) -> None:
        """Start its process, unless the class ends."""
        with self._lock, self._said.open("ab") as said:
            if self._closing.is_set():
                return
            self._process = subprocess.Popen(  # noqa: S603  our own program
                [sys.executable, "-P", "-m", "trainer", *self._words()],
                stdin=subprocess.PIPE,
                stdout=said,
                stderr=said,
                start_new_session=True,  # Ctrl-C reaches the class, which ends all in order
            )
        threading.Thread(target=self._await_sea, args=(self._process,), daemon=True).start()

    def _words(self) -> list[str]:
        """Return the command of its process: go on if there is a recording, else begin."""
        row = self.row
        common = ["--owned", "--listen", "none", "--socket", str(self.local_socket)]
        common += [f"--token={word}" for word in self.tokens]
        if self.follows_course:
            common += ["--course", str(self.folder / CLASS_FILE_NAME)]
        if kept := self.latest_recording():
            return ["resume", str(kept), "--serve", *common]
        names = [f"--trainee={name}" for name in row.trainees]
        begun = ["serve", self.exercise, "--frozen", f"--seed={row.seed}", *names]
        return [*begun, f"--record={self.recordings}", *common]

    def latest_recording(self) -> Path | None:
        """Return the recording written last, None without one."""
        kept = self.recordings.glob(f"*{RECORDING_SUFFIX}")
        return max(kept, key=lambda path: path.stat().st_mtime_ns, default=None)

    def _await_sea(self, process: subprocess.Popen[bytes]) -> None:
        """Note when its session takes lines."""
        begun = self._said.stat().st_size
        while process.poll() is None:
            if f"{LISTENING_TEXT} {self.local_socket}" in self._tail(since=begun):
                self.state = BoatState.AT_SEA
                return
            time.sleep(FIRST_RESTART_S / 5)

    def _tail(self, since: int = 0) -> str:
        """Return the last of what its process has said."""
        with contextlib.suppress(OSError), self._said.open("rb") as said:
            said.seek(max(since, self._said.stat().st_size - LAST_BYTES))
            return said.read().decode("utf-8", "replace")
        return ""

    def _keep(self) -> None:
        """Begin its session again whenever its process has died."""
        wait_s = FIRST_RESTART_S
        while self._process is not None:
            begun = time.monotonic()
            code = self._process.wait()
            if self._process.stdin:
                self._process.stdin.close()
            if self._closing.is_set() or code == 0:
                self.state = BoatState.ENDED
                self.tell(f"{self.title} has ended")
                return
            if code == WRONG_INPUT:
                self.state = BoatState.LOST
                last = (self._tail().strip().splitlines() or ["it says nothing"])[-1]
                self.tell(f"{self.title} cannot go to sea: {last}")
                return
            self.state = BoatState.RESUMING
            wait_s = FIRST_RESTART_S if time.monotonic() - begun >= STEADY_TIME_S else wait_s
            how = f"by signal {-code}" if code < 0 else f"with {code}"
            self.tell(f"{self.title} has died ({how}); it is resumed from its recording, frozen")
            if self._closing.wait(wait_s):
                continue
            wait_s = min(2.0 * wait_s, MAX_RESTART_WAIT_S)
            self.resumed += 1
            with contextlib.suppress(OSError):  # without room: tried again
                self._launch()


@dataclass
class Fleet:
    """All boats of a class; ``sockets`` is a folder of this user's alone."""

    planned: ClassFile
    folder: Path
    sockets: Path
    tokens: Sequence[str]
    tell: Tell
    distant: Mapping[int, AnyBoat] = field(default_factory=dict)  # that run elsewhere
    boats: dict[int, AnyBoat] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for number in self.planned.numbers:
            self.boats[number] = self.distant.get(number) or ClassBoat(
                self.planned.row_of(number),
                self.folder,
                self.sockets / f"boat-{number}.sock",
                self.planned.exercises[0],
                self.tokens,
                self.tell,
                follows_course=bool(self.planned.course),
            )

    def begin(self) -> None:
        """Begin all sessions."""
        for boat in self.boats.values():
            boat.begin()

    def end(self) -> None:
        """End all sessions in order; nothing of them is left but their recordings."""
        for boat in self.boats.values():
            boat.ask_to_end()
        by = time.monotonic() + END_TIMEOUT_S
        for boat in self.boats.values():
            boat.end(max(by - time.monotonic(), 0.1))

    def await_end(self) -> None:
        """Wait until no boat will be at sea again."""
        while not all(boat.has_ended() for boat in self.boats.values()):
            time.sleep(FIRST_RESTART_S)
