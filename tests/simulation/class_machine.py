"""One machine with the sessions of a class, each a process that is killed alone.

``Machine`` has one process; here each task belongs to the process whose task began it, and a kill
ends the tasks of one and closes its sockets, as a system does.
"""

from collections.abc import Callable
from socket import AF_INET
from typing import Final

from simulation.disk import SYNC_TIMES_S, Disk
from simulation.machine import Machine, Task
from simulation.network import FIRST_PORT, Listener, Network, Socket

OUTSIDE: Final = 0  # the class itself, captains: processes that are never killed


class ClassMachine(Machine):
    """A machine of one thread with several processes, by number."""

    def __init__(self) -> None:
        super().__init__()
        self.owner: dict[Task, int] = {}

    @property
    def process(self) -> int:
        """Return the process whose turn it is."""
        return self.owner[self.running] if self.running else OUTSIDE

    def begin(self, call: Callable[[], object], name: str) -> Task:
        """Begin a task of the process whose turn it is."""
        return self.begin_in(self.process, call, name)

    def begin_in(self, process: int, call: Callable[[], object], name: str) -> Task:
        """Begin a task of a process."""
        task = super().begin(call, f"{name} of {process}")
        self.owner[task] = process
        return task

    def kill_process(self, process: int) -> None:
        """End the tasks of one process where they stand, as SIGKILL does."""
        whole = self.tasks
        self.tasks = [task for task in whole if self.owner[task] == process]
        self.kill()
        self._dead = False
        self.tasks = [task for task in whole if self.owner[task] != process]


class ClassNetwork(Network):
    """The sockets of such a machine: each session listens at a port of its own."""

    def __init__(self, machine: ClassMachine) -> None:
        super().__init__(machine)
        self.processes = machine
        self.owner: dict[int, int] = {}  # of a socket, by its descriptor

    def listen(self, _host: str, port: int) -> Listener:
        """Listen at a port."""
        door = Listener(self, port)
        self.doors[port] = self.ends[door.fileno()] = door
        return door

    def reach(self, process: int) -> Socket | None:
        """Return a connection to a session; None if it does not listen."""
        door = self.doors.get(FIRST_PORT + process)
        if door is None or door.closed:
            return None
        ours, theirs = self.pair()
        theirs.family = AF_INET
        self.owner[theirs.fileno()] = process
        door.backlog.append(theirs)
        return ours

    def kill_process(self, process: int) -> None:
        """Close all sockets of a process."""
        door = self.doors.pop(FIRST_PORT + process, None)
        if door:
            door.close()
        for number, owner in self.owner.items():
            end = self.ends[number]
            if owner == process and not end.closed:
                end.close()

    def _end(self) -> Socket:
        end = super()._end()
        self.owner[end.fileno()] = self.processes.process
        return end


class LoyalDisk(Disk):
    """A disk that nothing befalls: of all recordings, what was written is there."""

    def fsync(self, _descriptor: int) -> None:
        """Take a moment."""
        self.machine.sleep(self.machine.dice.choice(SYNC_TIMES_S))

    def keep(self) -> None:
        """Keep nothing: no power is cut."""
