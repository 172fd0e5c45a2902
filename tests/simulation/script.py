"""A script is all that happens to one session, as data.

``draw_script`` makes one of a seed. Times are in seconds of the machine's clock, each counted from
the end of what comes before it.
"""

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from enum import Enum
from pathlib import Path
from random import Random
from typing import Any, Final

from simulation.disk import Trouble
from simulation.network import ROOM_BYTES
from simulation.traffic import traffic_words
from trainer.session.stations.roles import INSTRUCTOR_ROLE

EXERCISES: Final = (
    *("", "", "depth-changes", "visitor-dive", "rise-jam-shallow", "watch"),
    *("crossing-traffic", "bottoming", "periscope-depth"),
)  # "": none
ROLES: Final = ("instructor", "instructor", "helm", "planes", "ballast", "observer")
TIME_SPEEDS: Final = (1.0, 5.0, 20.0, 100.0)
ORDER_RATES_HZ: Final = (0.5, 2.0, 5.0)
LIFE_TIMES_S: Final = (3.0, 8.0, 20.0, 40.0)
MAX_LIVES: Final = 4
AGED_SHARE: Final = 0.15  # [-] of processes
UNRECORDED_SHARE: Final = 0.05  # [-] of scripts
FLEET_EVERY: Final = 11  # seeds: of these one has many ships
FLEET_LIFE_S: Final = 20.0  # of a process among them, each tick of which takes 30 ms
FLEET_SPEEDS: Final = (5.0, 20.0, 100.0)  # of time: a name comes every six minutes
MAX_CABLES: Final = 2
MAX_SEED: Final = 2**31
GUEST_SHARE: Final = 0.15  # [-] of processes has one who is out of place there
GUESTS: Final = ("trainee", "visitor")
SHOWN: Final = INSTRUCTOR_ROLE.channels
FEW_BYTES: Final = 2_000  # that a small client keeps before it reads
SIP_BYTES: Final = 300  # that a slow one takes in a second
# What is there more than once is said more often.
WORDS: Final[Mapping[str, str]] = {
    "instructor": """freeze|run|run|run|step 3|step 40|time 20|time 1|time 100|snapshot A|snapshot B
        |restore A|restore B|reset|backtrack 5 s|backtrack 30 s|replay 10 s|replay 20 s|take over
        |again|again from here|again from A|again from 20 s|branch 1|branch 2|branch 9
        |branches|branches|branches|snapshots|snapshots|snapshots|plans
        |at 30 s depth 70|in 10 s depth 80|in 2 s course 010|at 1 s emergency blow
        |when depth over 62 then rudder left 5|cancel 1|cancel all|end exercise|release marks
        |debrief|take command|give command|keep command|mark hello|casualty rudder-stuck
        |casualty stern-slow 0.5 ramp 20|clear all|casualties|clear rudder-stuck
        |sea state 4|sea state 0|order depth 90|order course 120
        |tell helm steady|depth 70|course 090|rudder left 10|history motion 20 s|who|status|log 5
        |quit|current set 090 drift 2|current off|ack 1|ack silent 1|restart|emergency blow
        |subscribe motion|subscribe ledger|unsubscribe all|alerts|allow planes|allow ballast
        |autopilot on|autopilot off|belay|briefing|course left 30|come right to 090|demonstrate
        |ghost on|ghost off|predictor 60 s|hint|freeze depth|release depth|release all|next
        |what if depth 80|dive|surface|drain aft|drain stop|pump trim forward 2|pump auxiliary 1
        |periscope depth|rpm 60|turns 4|name wall|detach|casualty oil-leak-header|loads shed
        |casualty bus-port-lost|casualty fire-aft|bus tie shut|stern emergency|isolate main""",
    "helm": """rudder left 10|rudder right 20|rudder midships|course 045|speed 8|bell ahead full|aye
        |report ready|ready|status|depth 70|freeze|who|subscribe steering|history gauges 20 s
        |rudder manual|rudder auto|mark late|course right 20|come left to 300|turns 5|rpm 80
        |alerts|ack 1|have rudder|relief Berg|rudder emergency|rudder normal|rudder hand""",
    "planes": """stern rise 5|stern dive 10|bow dive 3|planes zero|depth 80|aye|report ready|ready
        |planes manual|planes auto|rudder left 5|log 3|subscribe diving|mark|periscope depth
        |ack all|ack 1|ack silent 1|have planes|relief Ott|planes emergency|stern normal
        |bow hand|subscribe supply""",
    "ballast": """blow forward|blow aft|vent forward open|vent aft open|vent forward shut
        |negative flood|trim auto|trim manual|emergency blow|compressor on|hover on|hover off
        |flood auxiliary 5|pump auxiliary 3|pump trim aft 2|drain forward|ready|report ready|aye
        |name tanks|unsubscribe all|isolate main|isolate stern|open main|open stern|loads shed
        |hydraulic pump 2 run|hydraulic pump vital stop|bus tie shut|bus tie open|loads back
        |breaker port open|breaker port shut|ventilation secure|ventilation run|fight fire aft
        |subscribe plant""",
    "observer": "mark one|mark two|who|status|log 9|subscribe gauges|history events 60 s|help",
    "visitor": "lever dive 3|lever rise 2|lever zero|restart|status|freeze|mark no",
    "trainee": "depth 70|course 045|freeze|run|autopilot on|status|ready|hint",
}
CHOICES: Final = {
    role: tuple(each.strip() for each in words.split("|")) for role, words in WORDS.items()
}
# What an instructor says in a row: each leads to where single words seldom come.
SCENE_SHARE: Final = 0.08  # [-] of an instructor's acts begin one
SCENE_PACES_S: Final = (0.02, 0.3, 1.0)  # [s] from word to word, on the average
SCENES: Final = (
    "snapshot A|casualty stern-slow 0.5 ramp 20|restore A",
    "casualty rudder-stuck|snapshot B|clear all|restore B",
    "casualty rudder-slow 0.7 ramp 30|snapshot A|backtrack 1 s|restore A",
    "replay 10 s|freeze|take over",
    "time 1|replay 20 s|take over|mark taken over",
    "run|time 1|run|replay 60 s",
    "replay 10 s|mark seen again|snapshot B|restore B",
    "replay 20 s|replay 5 s|backtrack 2 s",
    "in 3 s depth 80|snapshot A|cancel all|restore A",
    "snapshot A|in 10 s depth 90|restore A|run",
    "at 20 s depth 70|freeze|backtrack 5 s|run",
    "run|at 1 s emergency blow|at 1 s depth 70",
    "at 1 s emergency blow|at 1 s casualty rudder-stuck",
    "snapshot A|end exercise|restore A|run",
    "end exercise|again|run",
    "debrief|debrief|again",
    "end exercise|release marks|next",
    "ghost on|hint|what if depth 80",
    "ghost on|predictor 30 s|backtrack 2 s|ghost off",
    "demonstrate for 10 s|freeze|run",
    "take command|run|give command",
    "order depth 90|tell helm steady|belay|backtrack 1 s",
    "planes manual|stern dive 20|bell ahead full|run|time 100",
    "surface|time 100|run",
    "sea state 5|current set 090 drift 2|snapshot A|current off|restore A",
    "freeze depth|backtrack 1 s|release all",
    "branch 1|branch 2|mark here|branch 1",
)
# What each instructor says first, dealt by seed, so that none is missed. Who comes second says the
# next row: so one asks for command, and the other keeps it.
DEALT: Final = (
    *(2 * ("run|take command|keep command|take command|keep command|take command|keep command",)),
    "ghost on|run|what if depth 80|freeze|what if depth 80|predictor 60 s|run",
    "who|quit|quit",
    "in 9 s depth 80|cancel all|order depth 90|belay|flood auxiliary 5|demonstrate for 5 s",
    "end exercise|release marks|run|again",
    "casualty oil-leak-header|step 200|rudder emergency|planes emergency|isolate main|open main",
    "casualty bus-port-lost|step 4|bus tie shut|step 20|loads shed|breaker port open|loads back",
    "casualty fire-aft|step 120|ventilation secure|fight fire aft|hydraulic pump 1 stop",
    "run|casualty oil-leak-stern|step 40|snapshot A|isolate stern|stern hand|restore A|run",
    "run|casualty bus-starboard-lost|snapshot B|bus tie shut|backtrack 2 s|restore B|run",
    "run|planes manual|stern dive 20|step 900|run|run|run|mark crushed|backtrack 20 s",
    "role helm|who|role instructor|scope raise",
    "run|breaker starboard open|breaker port open|mark dark|reset|ventilation exhaust",
)
# What few may say: each of the others first says some of it, dealt likewise.
FOREIGN: Final = (
    *("scope raise", "negative flood", "hover on", "compressor on", "surface", "isolate main"),
    *("lever dive 3", "emergency blow", "drain aft", "rudder emergency", "stern emergency"),
    *("report ready", "ready", "have planes", "relief Berg", "order depth 90", "tell look out"),
    *("mark mine", "rudder left 5", "planes zero", "depth 60", "course 020", "turns 5"),
    *("vent aft shut", "autopilot on"),
)
DEAL_PACE_S: Final = 0.1  # [s] from word to word
FOREIGN_COUNT: Final = 3  # that each says
NOISE: Final = (
    *("\xff\xfd\x01hel\xff\r\n", "$TRO,900001,depth 70*00\r\n", "nonsense\r\n", "\r\n\n\r"),
    *("x" * 3000 + "\r\n", "depth 99999\r\n", "\x1b[2J\r\n", "caf\xe9\r\n", "$$$***\r\n"),
    *("depth 7\b80\r\n", "name \u20ac\r\n".encode().decode("latin-1")),
)
LINE_ENDS: Final = ("\r\n", "\n", "\r")


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

    @property
    def at_mark(self) -> bool:
        """Return whether the answer that a kill waits for is that to a mark."""
        return self.seed % 4 == 0  # not drawn: each draw more changes all that come after it


@dataclass(frozen=True)
class Script:
    """A session: its exercise and its processes, each of which goes on with the recording."""

    exercise: str
    duration: float  # of the exercise, 0 for its own
    speed: float  # of time
    lives: tuple[Life, ...]
    recorded: bool = True  # else there is one life
    fleet: int = 0  # the seed of many ships, in place of the exercise; 0: none

    @property
    def acts(self) -> int:
        """Return how many lines are sent."""
        visits = (
            visit for life in self.lives for player in life.players for visit in player.visits
        )
        return sum(len(visit.acts) for visit in visits)


def draw_script(seed: int, longest: float = max(LIFE_TIMES_S)) -> Script:
    """Return the script of a seed, no process of which is played for longer [s]."""
    dice = Random(f"{seed}/script")  # noqa: S311  no secrets
    longest = longest if seed % FLEET_EVERY else min(longest, FLEET_LIFE_S)
    exercise = dice.choice(EXERCISES)
    duration = dice.choice((0.0, 5.0, 20.0, 120.0)) if exercise else 0.0
    rate = dice.choice(ORDER_RATES_HZ)
    speed = dice.choice(TIME_SPEEDS)
    lives: list[Life] = []
    while True:
        lives.append(_draw_life(dice, exercise, rate, longest))
        if len(lives) == 1 and seed % FLEET_EVERY:
            lives[0] = _deal_words(seed, lives[0])
        if len(lives) > 1 and lives[-2].ending is Ending.KILLED and dice.random() < 0.25:
            lives[-1] = _strike_again(dice, lives[-1])
        if lives[-1].ending is Ending.SIGNAL or len(lives) == MAX_LIVES:
            break
    recorded = dice.random() >= UNRECORDED_SHARE
    lives = lives if recorded else lives[:1]
    script = Script(exercise, duration, speed, tuple(lives), recorded)
    return script if seed % FLEET_EVERY else _among_ships(dice, script)


def _among_ships(dice: Random, script: Script) -> Script:
    """Return a script with a fleet, its master, and instruments that hear it."""
    lives = [
        replace(
            life,
            frozen=False,  # else few hear anything
            instruments=True,
            players=(*life.players, _draw_master(dice, life.seconds)),
        )
        for life in script.lives
    ]
    return replace(
        script,
        exercise="",
        duration=0.0,
        speed=dice.choice(FLEET_SPEEDS),
        lives=tuple(lives),
        fleet=dice.randrange(1, MAX_SEED),
    )


def _draw_master(dice: Random, seconds: float) -> Player:
    """Return who orders the ships of a fleet."""
    acts, now = [], 0.0
    while now < seconds:
        acts.append(Act(dice.expovariate(1.0), traffic_words(dice)))
        now += acts[-1].after
    return Player("instructor", (Visit(dice.uniform(0.0, 1.0), tuple(acts)),))


def _draw_life(dice: Random, exercise: str, rate: float, longest: float) -> Life:
    seconds = dice.uniform(0.3, 1.0) * min(dice.choice(LIFE_TIMES_S), longest)
    quiet = dice.random() < 0.15  # frozen, and nobody comes at once
    roles = list(ROLES[: dice.randrange(2, len(ROLES) + 1)])
    if exercise == "visitor-dive":
        roles.append("visitor")
    roles += [guest for guest in GUESTS if dice.random() < GUEST_SHARE]
    wait = dice.choice((0.5, 5.0)) if quiet else 1.0
    ways = [Way.CABLE] * dice.choice((0, 0, 1, MAX_CABLES)) + dice.choices(
        (Way.PORT, Way.PAGE), k=9
    )
    return Life(
        seed=dice.randrange(MAX_SEED),
        seconds=seconds,
        ending=dice.choices(tuple(Ending), (0.4, 0.2, 0.4))[0],
        turns=dice.randrange(1, 300),
        at_answer=dice.random() < 0.5,
        players=tuple(
            _draw_player(dice, role, rate, seconds, wait, way)
            for role, way in zip(reversed(roles), ways, strict=False)
        ),
        mishaps=_draw_mishaps(dice, seconds) if dice.random() < 0.5 else (),
        interleaving=dice.choice((0.0, 0.05, 0.3)),
        frozen=quiet or dice.random() < 0.25,
        slow_disk=dice.random() < 0.2,
        instruments=dice.random() < 0.2,
        rest=dice.choice((0.0, 60.0)),
        aged=dice.random() < AGED_SHARE,
    )


def _strike_again(dice: Random, life: Life) -> Life:
    """Return a life after a kill in which nobody says anything, and then the power goes."""
    seconds = dice.uniform(1.0, 4.0)
    return replace(life, seconds=seconds, ending=Ending.POWER, players=(), mishaps=(), frozen=True)


def _draw_player(
    dice: Random, role: str, rate: float, seconds: float, wait: float, way: Way
) -> Player:
    visits, now, cable = [], 0.0, way is Way.CABLE
    while now < seconds:
        after = dice.expovariate(1.0 / wait)
        acts = []
        now += after
        for _ in range(dice.choice((5, 30, 100))):
            in_a_row = role == "instructor" and dice.random() < SCENE_SHARE
            said = _draw_scene(dice) if in_a_row else [_draw_act(dice, role, rate)]
            acts += said
            now += sum(act.after + act.pause for act in said)
            if now > seconds:
                break
        visits.append(
            Visit(
                after,
                tuple(acts),
                reads=cable or dice.random() < 0.9,
                room=dice.choice((ROOM_BYTES, ROOM_BYTES, ROOM_BYTES, FEW_BYTES)),
                sip=0 if cable or dice.random() < 0.9 else SIP_BYTES,
                farewell=dice.choice(tuple(Farewell)),
            )
        )
    return Player(role, tuple(visits), way)


def _draw_scene(dice: Random) -> list[Act]:
    """Return some words in a row."""
    pace = dice.choice(SCENE_PACES_S)
    words = dice.choice(SCENES).split("|")
    return [Act(dice.expovariate(1.0 / pace), each, end=dice.choice(LINE_ENDS)) for each in words]


def _deal_words(seed: int, life: Life) -> Life:
    """Return a life in which each player first says what a seed deals it.

    An instructor says a row of words, and looks at a channel; another what few may say.
    """
    players = []
    for number, player in enumerate(life.players):
        if player.role == "instructor":
            words = DEALT[(seed + number) % len(DEALT)].split("|")
            words = [f"subscribe {SHOWN[seed % len(SHOWN)]}", *words]
        else:
            first = FOREIGN_COUNT * (seed + number)
            words = [FOREIGN[(first + i) % len(FOREIGN)] for i in range(FOREIGN_COUNT)]
            words = ["restart", *words] if player.role == "visitor" else words
        dealt = tuple(Act(DEAL_PACE_S, each) for each in words)
        visits = [
            replace(visit, acts=(*dealt, *visit.acts)) if i == 0 else visit
            for i, visit in enumerate(player.visits)
        ]
        players.append(replace(player, visits=tuple(visits)))
    return replace(life, players=tuple(players))


def _draw_act(dice: Random, role: str, rate: float) -> Act:
    after = dice.expovariate(rate)
    if dice.random() < 0.08:
        return Act(after, dice.choice(NOISE), noise=True)
    whose = role if dice.random() < 0.9 else dice.choice(tuple(CHOICES))
    words = dice.choice(CHOICES[whose])
    if words == "quit" and dice.random() < 0.8:  # else no session lives long
        words = "status"
    pause = dice.expovariate(5.0) if dice.random() < 0.1 else 0.0
    return Act(after, words, pause=pause, end=dice.choice(LINE_ENDS))


def _draw_mishaps(dice: Random, seconds: float) -> tuple[Mishap, ...]:
    mishaps, now = [], 0.0
    while now < seconds:
        trouble = dice.choice((*Trouble, Trouble.LOCKED, Trouble.UNREADABLE))
        times = (0.1, 20.0) if trouble is Trouble.ASLEEP else (0.05, 5.0)
        mishaps.append(Mishap(dice.expovariate(0.25), trouble, dice.uniform(*times)))
        now += mishaps[-1].after + mishaps[-1].seconds
    return tuple(mishaps)


def write_script(script: Script, path: Path) -> None:
    """Write a script into a file of JSON."""
    table = asdict(script)
    text = json.dumps(table, indent=1, default=lambda each: each.value)
    path.write_text(f"{text}\n", encoding="utf-8")


def read_script(path: Path) -> Script:
    """Read a script back."""
    return _script_of(json.loads(path.read_text(encoding="utf-8")))


def _script_of(table: dict[str, Any]) -> Script:
    return Script(**{**table, "lives": tuple(_life_of(each) for each in table["lives"])})


def _life_of(table: dict[str, Any]) -> Life:
    mishaps = (Mishap(**{**each, "trouble": Trouble(each["trouble"])}) for each in table["mishaps"])
    parts = {
        "ending": Ending(table["ending"]),
        "players": tuple(_player_of(each) for each in table["players"]),
        "mishaps": tuple(mishaps),
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
    return Player(table["role"], tuple(visits), Way(table.get("way", Way.PORT.value)))
