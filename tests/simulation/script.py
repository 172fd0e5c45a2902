"""A script is all that happens to one session, as data.

``drawing`` makes one of a seed. Times are in seconds of the machine's clock, each counted from the
end of what comes before it.
"""

import json
from dataclasses import asdict, dataclass
from enum import Enum
from pathlib import Path
from typing import Any, Final, NamedTuple

from simulation.disk import Trouble
from simulation.network import ROOM_BYTES

AWAITED: Final = ("mark", "snapshot", "", "")  # promises, after whose answer a kill strikes


class Farewell(Enum):
    """How a program leaves its line."""

    HANGS_UP = "hangs up"
    RESET = "resets the connection"
    HALF = "hangs up within a line"


class Way(Enum):
    """How a program comes to the session."""

    PORT = "a TCP port"
    PAGE = "the pages' server, which carries it to a socket of this machine"
    CABLE = "a serial cable of its own"


class Ending(Enum):
    """How a process ends that does not end by itself."""

    KILLED = "kill -9"
    POWER = "the power goes"
    SIGNAL = "a signal asks it to end"


@dataclass(frozen=True)
class Part:
    """A part of a script."""

    after: float  # what comes before it has ended


@dataclass(frozen=True)
class Act(Part):
    """Something that a program sends."""

    words: str
    noise: bool = False  # the words are bytes (latin-1), and no sentence
    pause: float = 0.0  # within the line
    end: str = "\r\n"


@dataclass(frozen=True)
class Visit(Part):
    """A line of a program, from its call to its farewell."""

    acts: tuple[Act, ...]
    reads: bool = True  # False: it never takes what it is sent
    room: int = ROOM_BYTES  # [bytes] that it keeps before it reads
    sip: int = 0  # [bytes/s] that it takes at most, 0 for all that comes
    farewell: Farewell = Farewell.HANGS_UP


@dataclass(frozen=True)
class Player:
    """A program at the far end of a line, with a role."""

    role: str
    visits: tuple[Visit, ...]
    way: Way = Way.PORT
    token: str = ""  # the word that it says with its role


@dataclass(frozen=True)
class Mishap(Part):
    """What befalls the disk, or the machine."""

    trouble: Trouble
    seconds: float


@dataclass(frozen=True)
class Life:
    """A process of the session, and how it ends."""

    seed: int  # of whose turn it is
    seconds: float  # until it is ended
    ending: Ending
    turns: int  # of threads after that time, until a kill strikes
    players: tuple[Player, ...]
    mishaps: tuple[Mishap, ...] = ()
    at_answer: bool = False  # then it waits for the next answer, and strikes before all else
    interleaving: float = 0.05  # [-] the chance that a thread comes in between
    frozen: bool = False
    slow_disk: bool = False
    instruments: bool = False  # NMEA goes out by a cable and by datagrams
    rest: float = 0.0  # before the next process begins
    aged: bool = False  # the recording that it goes on with is of format 1
    redrawn: tuple[tuple[int, int], ...] = ()  # after so many turns, their seed from then on
    amidst: bool = False  # a kill, or the cut, strikes between an order's journal and its answer
    laden: bool = False  # other programs have the processor: each turn takes long
    narrow: bool = False  # little waits in memory while the disk is out of reach

    @property
    def awaited(self) -> str:
        """Return of which kind the promise is that a kill waits for, "" for any."""
        return AWAITED[self.seed % len(AWAITED)]


@dataclass(frozen=True)
class Script:
    """A session: its exercise and its processes, each of which goes on with the recording."""

    exercise: str
    duration: float  # of the exercise, 0 for its own
    speed: float  # of time
    lives: tuple[Life, ...]
    recorded: bool = True  # else there is one life
    fleet: int = 0  # the seed of many ships, in place of the exercise; 0: none
    tokens: tuple[str, ...] = ()  # the words that it asks for, as `--token` has them

    @property
    def acts(self) -> int:
        """Return how many lines are sent."""
        visits = (
            visit for life in self.lives for player in life.players for visit in player.visits
        )
        return sum(len(visit.acts) for visit in visits)


class Point(NamedTuple):
    """A point of a script, up to which it can be played again exactly."""

    life: int  # the number of the process
    turns: int  # of it
    seconds: float  # of it
    places: tuple[tuple[int, int], ...] = ()  # of each player: visits done, lines of the next said
    mishaps: int = 0  # that have begun


def write_script(script: Script, path: Path) -> None:
    """Write a script into a file of JSON."""
    table = asdict(script)
    text = json.dumps(table, indent=1, default=lambda each: each.value)
    path.write_text(f"{text}\n", encoding="utf-8")


def read_script(path: Path) -> Script:
    """Read a script back."""
    return _script_of(json.loads(path.read_text(encoding="utf-8")))


def _script_of(table: dict[str, Any]) -> Script:
    lives = tuple(_life_of(each) for each in table["lives"])
    return Script(**{**table, "lives": lives, "tokens": tuple(table.get("tokens", ()))})


def _life_of(table: dict[str, Any]) -> Life:
    mishaps = (Mishap(**{**each, "trouble": Trouble(each["trouble"])}) for each in table["mishaps"])
    parts = {
        "ending": Ending(table["ending"]),
        "players": tuple(_player_of(each) for each in table["players"]),
        "mishaps": tuple(mishaps),
        "redrawn": tuple(tuple(each) for each in table.get("redrawn", ())),
    }
    return Life(**{**table, **parts})


def _player_of(table: dict[str, Any]) -> Player:
    visits = (
        Visit(
            **{
                **each,
                "acts": tuple(Act(**act) for act in each["acts"]),
                "farewell": Farewell(each["farewell"]),
            }
        )
        for each in table["visits"]
    )
    way = Way(table.get("way", Way.PORT.value))
    return Player(table["role"], tuple(visits), way, table.get("token", ""))
