"""A seed draws a script: who comes, what is said, what befalls, how it ends.

Which words, scenes, mishaps and endings come how often is in ``vocabulary`` and ``weights``. What
is drawn anew likes a few of them: where all come alike, three that must come in a row seldom do
(A. Groce and others, *Swarm Testing*, ISSTA 2012).
"""

from dataclasses import replace
from random import Random
from typing import Final

from simulation.admission import ask_words, give_words
from simulation.disk import Trouble
from simulation.network import ROOM_BYTES
from simulation.script import Act, Ending, Farewell, Life, Mishap, Player, Point, Script, Visit, Way
from simulation.traffic import traffic_words
from simulation.vocabulary import CHOICES, DEALT, FOREIGN, NOISE, TROUBLED
from simulation.weights import Weights, read_weights
from trainer.session.stations.roles import INSTRUCTOR_ROLE

ROLES: Final = ("instructor", "instructor", "helm", "planes", "ballast", "observer")
TIME_SPEEDS: Final = (1.0, 5.0, 20.0, 100.0)
ORDER_RATES_HZ: Final = (0.5, 2.0, 5.0)
LIFE_TIMES_S: Final = (3.0, 8.0, 20.0, 40.0)
MAX_LIVES: Final = 4
AGED_SHARE: Final = 0.15  # [-] of processes
AMIDST_SHARE: Final = 0.2  # [-] of processes
NARROW_SHARE: Final = 0.2  # [-] of processes
UNRECORDED_SHARE: Final = 0.05  # [-] of scripts
LADEN_SHARE: Final = 0.1  # [-] of processes, and more among ships
LADEN_FLEET_SHARE: Final = 0.3
DOGGED_SHARE: Final = 0.2  # [-] of processes end in the midst of trouble with the disk
DISK_TROUBLES: Final = (Trouble.LOCKED, Trouble.REFUSED, Trouble.FULL, Trouble.UNREADABLE)
END_TROUBLE_S: Final = (0.2, 5.0)  # before the end, and that it lasts
PROMISE_AFTER_S: Final = 0.2  # the last that was said
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
SCENE_SHARE: Final = 0.08  # [-] of an instructor's acts begin one
LIKED_SCENE_SHARES: Final = (0.02, 0.08, 0.4)  # likewise, of who likes some actions
LIKED_SHARE: Final = 0.08  # [-] of the actions of a kind (estimate)
LIKED_TIMES: Final = 20.0  # as often as others (estimate)
SCENE_PACES_S: Final = (0.02, 0.3, 1.0)  # [s] from word to word, on the average
DEAL_PACE_S: Final = 0.1  # [s] from word to word
FOREIGN_COUNT: Final = 3  # that each says
LINE_ENDS: Final = ("\r\n", "\n", "\r")
WEIGHTS: Final = read_weights()


class Dice(Random):
    """Chance by a seed, which may like some actions."""

    def __init__(self, seed: str) -> None:
        """Like all actions by their weights."""
        super().__init__(seed)
        self.scene_share = SCENE_SHARE
        self._weights: Weights = WEIGHTS

    def like_some(self) -> None:
        """Draw some actions of each kind, which from now on come much more often."""
        self.scene_share = self.choice(LIKED_SCENE_SHARES)
        self._weights = {
            kind: {
                word: LIKED_TIMES * weight if self.random() < LIKED_SHARE else weight
                for word, weight in weights.items()
            }
            for kind, weights in WEIGHTS.items()
        }

    def draw(self, kind: str) -> str:
        """Return an action of a kind, by its weight."""
        weights = self._weights[kind]
        return self.choices(tuple(weights), tuple(weights.values()))[0]


def draw_script(seed: int, longest: float = max(LIFE_TIMES_S)) -> Script:
    """Return the script of a seed, no process of which is played for longer [s]."""
    dice = Dice(f"{seed}/script")
    longest = longest if seed % FLEET_EVERY else min(longest, FLEET_LIFE_S)
    exercise = dice.draw("exercises")
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
    return ask_words(seed, script if seed % FLEET_EVERY else _among_ships(dice, script))


def redraw(
    script: Script, point: Point, seed: int, longest: float, most_lives: int = MAX_LIVES
) -> Script:
    """Return a script that is the same up to a point, and then drawn anew.

    It has so many processes at most, or one more than that of the point.
    """
    dice = Dice(f"{seed}/redrawn")
    dice.like_some()
    rate, done = dice.choice(ORDER_RATES_HZ), point.life - bool(point.turns)
    lives = list(script.lives[:done])
    if point.turns:
        lives.append(_redraw_life(dice, script.lives[done], point, rate, longest))
    while not lives or lives[-1].ending is not Ending.SIGNAL:
        if len(lives) >= max(most_lives, point.life + 1):
            break
        fresh = _draw_life(dice, script.exercise, rate, longest)
        lives.append(give_words(dice, fresh, script.tokens) if script.tokens else fresh)
    return replace(script, lives=tuple(lives))


def _redraw_life(dice: Dice, life: Life, point: Point, rate: float, longest: float) -> Life:
    """Return a process that goes on by other chance after some of its turns."""
    fresh = _draw_life(dice, "", rate, longest)
    players = tuple(
        _redraw_player(dice, player, place, rate, point.seconds, fresh.seconds)
        for player, place in zip(life.players, point.places, strict=True)
    )
    coming = _draw_mishaps(dice, fresh.seconds) if life.mishaps else ()
    if coming and point.mishaps == len(life.mishaps):
        coming = (replace(coming[0], after=coming[0].after + point.seconds), *coming[1:])
    return replace(
        life,
        seconds=point.seconds + fresh.seconds,
        ending=fresh.ending,
        turns=fresh.turns,
        at_answer=fresh.at_answer,
        amidst=fresh.amidst,
        rest=fresh.rest,
        players=players,
        mishaps=(*life.mishaps[: point.mishaps], *coming),
        redrawn=(
            *(each for each in life.redrawn if each[0] < point.turns),
            (point.turns, dice.randrange(MAX_SEED)),
        ),
    )


def _redraw_player(
    dice: Dice, player: Player, place: tuple[int, int], rate: float, now: float, seconds: float
) -> Player:
    """Return a player who has said the same up to a place, and goes on with other words."""
    done, said = place
    first, *more = _draw_player(dice, player.role, rate, seconds, 1.0, player.way).visits
    if said >= 0:
        visit, acts = player.visits[done], first.acts
        if said < len(visit.acts):  # it waits for that time already
            acts = (replace(acts[0], after=visit.acts[said].after), *acts[1:])
        first = replace(visit, acts=(*visit.acts[:said], *acts))
    elif done == len(player.visits):  # its program had nothing left to do
        first = replace(first, after=first.after + now)
    return replace(player, visits=(*player.visits[:done], first, *more))


def _among_ships(dice: Dice, script: Script) -> Script:
    """Return a script with a fleet, its master, and instruments that hear it."""
    lives = [
        replace(
            life,
            frozen=False,  # else few hear anything
            instruments=True,
            laden=dice.random() < LADEN_FLEET_SHARE,
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


def _draw_master(dice: Dice, seconds: float) -> Player:
    """Return who orders the ships of a fleet."""
    acts, now = [], 0.0
    while now < seconds:
        acts.append(Act(dice.expovariate(1.0), traffic_words(dice)))
        now += acts[-1].after
    return Player("instructor", (Visit(dice.uniform(0.0, 1.0), tuple(acts)),))


def _draw_life(dice: Dice, exercise: str, rate: float, longest: float) -> Life:
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
    mishaps = _draw_mishaps(dice, seconds) if dice.random() < 0.5 else ()
    if dice.random() < DOGGED_SHARE:
        before, lasts = END_TROUBLE_S
        mishaps = (Mishap(max(seconds - before, 0.0), dice.choice(DISK_TROUBLES), lasts),)
    life = Life(
        seed=dice.randrange(MAX_SEED),
        seconds=seconds,
        ending=Ending(dice.draw("endings")),
        turns=dice.randrange(1, 300),
        at_answer=dice.random() < 0.5,
        players=tuple(
            _draw_player(dice, role, rate, seconds, wait, way)
            for role, way in zip(reversed(roles), ways, strict=False)
        ),
        mishaps=mishaps,
        interleaving=dice.choice((0.0, 0.05, 0.3)),
        frozen=quiet or dice.random() < 0.25,
        slow_disk=dice.random() < 0.2,
        instruments=dice.random() < 0.2,
        rest=dice.choice((0.0, 60.0)),
        aged=dice.random() < AGED_SHARE,
        amidst=dice.random() < AMIDST_SHARE,
        narrow=dice.random() < NARROW_SHARE,
        laden=dice.random() < LADEN_SHARE,
    )
    awaits = life.at_answer and life.awaited and life.ending is not Ending.SIGNAL
    return _promise_at_end(life) if awaits else life


def _promise_at_end(life: Life) -> Life:
    """Return a life whose instructors say at last what its kill waits for."""
    act = Act(PROMISE_AFTER_S, f"{life.awaited} last")
    players = [
        replace(
            player,
            visits=(
                *player.visits[:-1],
                replace(player.visits[-1], acts=(*player.visits[-1].acts, act)),
            ),
        )
        if player.role == "instructor"
        else player
        for player in life.players
    ]
    return replace(life, players=tuple(players))


def _strike_again(dice: Dice, life: Life) -> Life:
    """Return a life after a kill in which nobody says anything, and then the power goes."""
    seconds = dice.uniform(1.0, 4.0)
    return replace(life, seconds=seconds, ending=Ending.POWER, players=(), mishaps=(), frozen=True)


def _draw_player(
    dice: Dice, role: str, rate: float, seconds: float, wait: float, way: Way
) -> Player:
    visits, now, cable = [], 0.0, way is Way.CABLE
    while now < seconds:
        after = dice.expovariate(1.0 / wait)
        acts = []
        now += after
        for _ in range(dice.choice((5, 30, 100))):
            in_a_row = role == "instructor" and dice.random() < dice.scene_share
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


def _draw_scene(dice: Dice) -> list[Act]:
    """Return some words in a row."""
    pace = dice.choice(SCENE_PACES_S)
    words = dice.draw("scenes").split("|")
    return [Act(dice.expovariate(1.0 / pace), each, end=dice.choice(LINE_ENDS)) for each in words]


def _deal_words(seed: int, life: Life) -> Life:
    """Return a life in which each player first says what a seed deals it.

    An instructor says a row of words, and looks at a channel; another what few may say.
    """
    players, mishaps = [], life.mishaps
    for number, player in enumerate(life.players):
        if player.role == "instructor":
            row = DEALT[(seed + number) % len(DEALT)]
            words = row.split("|")
            mishaps = (TROUBLED[row],) if row in TROUBLED else mishaps
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
    return replace(life, players=tuple(players), mishaps=mishaps)


def _draw_act(dice: Dice, role: str, rate: float) -> Act:
    after = dice.expovariate(rate)
    if dice.random() < 0.08:
        return Act(after, dice.choice(NOISE), noise=True)
    whose = role if dice.random() < 0.9 else dice.choice(tuple(CHOICES))
    words = dice.draw(whose)
    if words == "quit" and dice.random() < 0.8:  # else no session lives long
        words = "status"
    pause = dice.expovariate(5.0) if dice.random() < 0.1 else 0.0
    return Act(after, words, pause=pause, end=dice.choice(LINE_ENDS))


def _draw_mishaps(dice: Dice, seconds: float) -> tuple[Mishap, ...]:
    mishaps, now = [], 0.0
    while now < seconds:
        trouble = Trouble(dice.draw("mishaps"))
        times = (0.1, 20.0) if trouble is Trouble.ASLEEP else (0.05, 5.0)
        mishaps.append(Mishap(dice.expovariate(0.25), trouble, dice.uniform(*times)))
        now += mishaps[-1].after + mishaps[-1].seconds
    return tuple(mishaps)
