"""The roles: who may order, see and hear what. Tokens admit to them.

``dispatch`` and the stations ask. The instructor may order and see everything. Everybody else has
the controls and channels of one place in the control room, sees depth, heading and speed as the
gauges show them, and does not hear what would give away the truth behind them or what the exercise
has in store.
"""

import hmac
import re
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Final

from trainer.config.files import ConfigError, nearest
from trainer.io.machine import is_here
from trainer.io.orders.grammar import HIDDEN_TOKEN, Order, Refused
from trainer.io.orders.words import (
    CLASS_LINE,
    COMMON_CONTROL,
    CREW_ORDERS_CONTROL,
    CREW_ROLES,
    ORDER_WORDS,
    STRANGER,
    TRAINEE,
)

COMMON_ORDERS: Final = frozenset(
    word.name
    for word in ORDER_WORDS.values()
    if set(COMMON_CONTROL.roles) <= set(word.control.roles)
)
# What happens, by kind: in words, and which roles hear of it; () is the instructor alone.
ALL_ROLES: Final = COMMON_CONTROL.roles
EVENT_KINDS: Final[Mapping[str, tuple[str, tuple[str, ...]]]] = {
    "time": ("time stopped, let go on or made faster; the end", ALL_ROLES),
    "moment": ("gone back to a moment, replayed, taken over", ALL_ROLES),
    "station": ("a line attached, took a role, went away", ALL_ROLES),
    "order": ("an order given at a station, and its answer", ("observer",)),
    "crew": ("an order to the crew, its repeat, a report", ALL_ROLES),
    "exercise": ("the instructor's orders, the schedule's, casualties and the sea", ()),
    "mark": ("a moment marked, with a remark", ("observer",)),
    "lesson": ("a step of a lesson, its hint, how it has ended", ALL_ROLES),
    "shown": ("the way shown by the reference crew; an aid switched on or off", ALL_ROLES),
    "marks": ("the marks of an exercise, once they are released", ALL_ROLES),
    "watch": ("a limit passed, the surface broken, an order carried out the wrong way", ()),
    "pilot": ("what the autopilot gives up and has again; what an X-tail does not give", ALL_ROLES),
    "plant": ("oil low or lost, a bus lost, overload, smoke, battery low", ALL_ROLES),
    "depth": (
        "test depth near, passed and beyond; the hull's collapse; the ground",
        ALL_ROLES,
    ),
    "alert": ("an alert acknowledged, or over", ALL_ROLES),
    "refused": ("an order outside a role, a wrong token, a line that is no order", ()),
    "trouble": ("late ticks, a port or the recording in trouble", ()),
}
PART_VERBS: Final = {"have": "has", "are": "is"}  # the verbs of a part
AID_NAMES: Final = ("ghost", "predictor")  # channels that are empty while the aids are off
PANEL_NAMES: Final = (
    *("steering", "engine", "diving", "tanks", "air", "valves"),
    *("plant", "supply"),  # of a boat with a plant
    "safe",  # of a boat with a test depth
)
# what only the instructor sees; the class, which lets no person in, sees the first
TRUTH_CHANNELS: Final = ("motion", "sea", "current", "casualties", "contacts", "lookout", "ledger")
ROLE_FIRST_TEXT: Final = "say who you are first: role NAME TOKEN"
MAX_TOKEN_GUESSES: Final = 3  # wrong tokens before a line is closed
TOKEN_FORM: Final = re.compile(r"[!%-)+-~]+")  # what an order, and a page, can hold
SHORT_TOKEN_LETTERS: Final = 6  # [characters]
ANY_ROLE: Final = ""  # the role of a token that stands for all roles without their own
FREE_GUESSES: Final = 3  # wrong tokens of a machine that are answered at once
FIRST_WAIT_S: Final = 1.0  # of the answer to the next one; each one after it waits twice as long
MAX_WAIT_S: Final = 30.0  # [s] these three: docs/threat-model.md
FORGET_AFTER_S: Final = 600.0  # without a wrong token of that machine
MAX_MACHINES: Final = 1000  # machines remembered, the latest


@dataclass(frozen=True)
class Role:
    """One part in the session.

    ``title`` is whose a thing is, as in "the helm's"; ``part`` follows "you", as in "have the
    helm", or "are the diving officer".
    """

    name: str
    title: str
    part: str
    commands: frozenset[str]
    channels: tuple[str, ...]
    events: frozenset[str]
    axes: tuple[str, ...] = ()  # of its orders to the crew; () for all

    @property
    def of_another(self) -> str:
        """Return the part in the third person: "has the helm"."""
        verb, _, rest = self.part.partition(" ")
        return f"{PART_VERBS[verb]} {rest}"


def orders_of(*roles: str) -> frozenset[str]:
    """Return the names of the orders that any of these roles may give."""
    return frozenset(
        word.name for word in ORDER_WORDS.values() if not set(roles).isdisjoint(word.control.roles)
    )


def _role(name: str, title: str, part: str, *channels: str, axes: tuple[str, ...] = ()) -> Role:
    """Return a role with its orders, its events, and its channels beside the common ones."""
    heard = frozenset(kind for kind, (_, roles) in EVENT_KINDS.items() if name in roles)
    return Role(
        name,
        title,
        part,
        orders_of(name),
        ("teletype", "gauges", "orders", *channels, "time", *AID_NAMES),
        heard,
        axes,
    )


INSTRUCTOR_ROLE: Final = Role(
    "instructor",
    "the instructor's",
    "are an instructor",
    frozenset(ORDER_WORDS),
    (
        *("teletype", "gauges", "orders", *PANEL_NAMES, "scope", "swell", "time", *AID_NAMES),
        *TRUTH_CHANNELS,
    ),
    frozenset(EVENT_KINDS),
)
_OTHER_ROLES: Final[Mapping[str, Role]] = {
    role.name: role
    for role in (
        INSTRUCTOR_ROLE,
        _role("helm", "the helm's", "have the helm", "steering", "engine", "supply"),
        _role("planes", "the planes station's", "have the planes", "diving", "supply", "safe"),
        _role(
            "pilot",
            "the pilot's",
            "have helm and planes (pilot)",
            *("steering", "engine", "diving", "plant", "supply", "safe"),
        ),
        _role(
            "ballast",
            "the ballast station's",
            "have the ballast",
            *("tanks", "air", "valves", "plant"),
        ),
        _role(
            "diving",
            "the diving officer's",
            "are the diving officer",
            *("diving", "engine", "tanks", "air", "valves", "plant", "supply", "safe"),
        ),
        _role(
            "deck",
            "the officer of the deck's",
            "are the officer of the deck",
            axes=("course", "depth", "speed"),
        ),
        _role("observer", "an observer's", "are an observer", *PANEL_NAMES),
        _role("visitor", "a visitor's", "are a visitor", "diving"),
        _role("scope", "the periscope's", "have the periscope", "scope", "swell"),
    )
}

# All that the crew may order and see, and time, so that nobody else is needed; nothing hidden.
TRAINEE_ROLE: Final = Role(
    TRAINEE,
    "the trainee's",
    "are a trainee",
    orders_of(TRAINEE, *CREW_ROLES),
    ("teletype", "gauges", "orders", *PANEL_NAMES, "scope", "swell", "time", *AID_NAMES),
    frozenset(kind for kind, (_, roles) in EVENT_KINDS.items() if TRAINEE in roles),
)
# The class itself, whose boats are in one sea: it hears where a boat is, and tells it of others.
# It comes in by the instructor's word, because it sees the truth.
CLASS_ROLE: Final = Role(
    CLASS_LINE,
    "the class's",
    "are the class",
    COMMON_ORDERS | {"contact"},
    ("motion", "time"),
    frozenset(),
)
ROLES: Final[Mapping[str, Role]] = {
    **_OTHER_ROLES,
    TRAINEE: TRAINEE_ROLE,
    CLASS_LINE: CLASS_ROLE,
}

# A line that has to say a token and has not: it sees and orders nothing.
STRANGER_ROLE: Final = Role(
    STRANGER, "nobody's", "are nobody yet", orders_of(STRANGER), (), frozenset()
)


def refusal(role: Role, order: Order) -> Refused | None:
    """Return why ``role`` may not give ``order``, naming whose it is; None when it may."""
    if order.name in role.commands:
        return _other_axis(role, order)
    if role is STRANGER_ROLE:
        return Refused(ROLE_FIRST_TEXT)
    control = ORDER_WORDS[order.name].control
    says = control.says or f'"{order.text}" is'
    owners = [ROLES[name].title for name in control.roles if name != TRAINEE]
    whose = " or ".join(owners or [INSTRUCTOR_ROLE.title])
    return Refused(f"{says} {whose}; you {role.part}")


def _other_axis(role: Role, order: Order) -> Refused | None:
    """Return why ``role`` may not order the crew on an axis, None when it may.

    What ``belay`` alone takes back is only known where it is obeyed, which asks again.
    """
    axis = order.word.removeprefix("clear_").partition("_")[0].replace("periscope", "depth")
    crew_orders = (
        name for name, word in ORDER_WORDS.items() if word.control is CREW_ORDERS_CONTROL
    )
    if not (role.axes and axis) or axis in role.axes or order.name not in crew_orders:
        return None
    own = f"{', '.join(role.axes[:-1])} and {role.axes[-1]}"
    return Refused(f"you {role.part}, who orders {own} alone")


def not_for_visitors(role: Role) -> Refused | None:
    """Return why ``role`` may not begin a crew's exercise again, None when it may."""
    if role is not ROLES["visitor"]:
        return None
    return Refused(
        "a visitor begins an exercise again only where its file has visitors = true: "
        "ask the instructor"
    )


def channel_refusal(role: Role, channel: str) -> Refused | None:
    """Return why ``role`` may not see ``channel``, naming what it has; None when it may."""
    if channel in role.channels:
        return None
    if role is STRANGER_ROLE:
        return Refused(ROLE_FIRST_TEXT)
    shown = ", ".join((*role.channels, "events"))
    return Refused(f"{channel} is not shown here: you {role.part}; you may see {shown}")


def hears_kind(role: Role, kind: str) -> bool:
    """Return whether ``role`` hears of events of that kind; the instructor hears all."""
    return role is INSTRUCTOR_ROLE or kind in role.events


# A line comes in with a role or a token.


@dataclass(frozen=True)
class Access:
    """The conditions for a line's role. Without role and tokens it may choose any."""

    role: str | None = None
    tokens: Mapping[str, str] = field(default_factory=dict, repr=False)  # by role, or ANY_ROLE
    entered: Callable[[], object] = bool  # called when a line has said who it is
    delay: Callable[[], float] = float  # counts a wrong token, returns how long [s] to wait
    own: bool = False  # it is the run's own console
    here: Callable[[], bool] = bool  # whether the line comes from this machine

    def settles(self, role: Role) -> bool:
        """Return whether a line keeps its role for good, even where it is alone."""
        free = self.own or (self.role is None and not self.tokens and self.here())
        return not free or role is ROLES["visitor"]

    @property
    def first(self) -> Role:
        """Return the role of a line before it has said one."""
        if self.role is not None:
            return ROLES[self.role]
        return STRANGER_ROLE if self.tokens else ROLES["observer"]

    def hide(self, text: str) -> str:
        """Return ``text`` without tokens, wherever they stand, because an order may be misspelt."""
        for token in self.tokens.values():
            pattern = re.escape(token)
            if len(token) < SHORT_TOKEN_LETTERS:  # it may stand within words that are none of it
                pattern = rf"(?<![\w-]){pattern}(?![\w-])"
            text = re.sub(pattern, HIDDEN_TOKEN, text, flags=re.IGNORECASE)
        return text

    def admits(self, role: str, given: str) -> bool:
        """Return whether a token admits to a role, in constant time.

        If there are tokens, nobody may take a role that has none.
        """
        if not self.tokens:
            return True
        key = INSTRUCTOR_ROLE.name if role == CLASS_LINE else role
        wanted = self.tokens.get(key, self.tokens.get(ANY_ROLE, ""))
        return hmac.compare_digest(given.encode(), wanted.encode()) and bool(wanted)


@dataclass
class GuessWaits:
    """The waits for the answers to wrong tokens, by machine.

    Only the answer waits, and the line that has guessed. A right token is admitted at once, even
    from a machine from which others have guessed, because wrong tokens must shut nobody out. So who
    hangs up instead of waiting may guess again on a new line: to stop that, right tokens of that
    machine would have to wait too.
    """

    clock: Callable[[], float] = time.monotonic
    _guesses: dict[str, tuple[int, float]] = field(default_factory=dict)  # how many, the last [s]

    def count(self, machine: str) -> float:
        """Count a wrong token of a machine; return how long [s] its answer waits."""
        now = self.clock()
        count, last = self._guesses.pop(machine, (0, now))
        count = 1 if now - last >= FORGET_AFTER_S else count + 1
        self._guesses[machine] = count, now
        if len(self._guesses) > MAX_MACHINES:
            del self._guesses[next(iter(self._guesses))]
        doublings = min(count - FREE_GUESSES - 1, 10)
        return min(FIRST_WAIT_S * 2.0**doublings, MAX_WAIT_S) if doublings >= 0 else 0.0


def read_tokens(given: tuple[str, ...]) -> dict[str, str]:
    """Return the tokens of ``ROLE=WORD`` or ``WORD`` each; ConfigError if one is given twice."""
    tokens: dict[str, str] = {}
    for text in given:
        role, equals, word = text.partition("=")
        if not equals or role not in ROLES:
            if word and (near := nearest(role, ROLES)):
                raise ConfigError(f"--token {role}=: no such role{near}")
            role, word = ANY_ROLE, text
        if role == CLASS_LINE:
            own = INSTRUCTOR_ROLE.name
            raise ConfigError(
                f"--token {CLASS_LINE}=: a class comes by --token {own}=WORD: say that"
            )
        if not word:
            raise ConfigError(f"--token {role}=: say {role}=WORD")
        refuse_unsayable_token(word)
        if role in tokens:
            raise ConfigError(f"--token: {role or 'a word for all roles'} is given twice")
        tokens[role] = word
    return tokens


def refuse_unsayable_token(word: str) -> None:
    """Raise ConfigError, without the word, if no order could hold it."""
    if not TOKEN_FORM.fullmatch(word):
        raise ConfigError('--token: a word has plain letters, digits and signs; no space " # $ *')


def refuse_open_door(option: str, host: str, tokens: Mapping[str, str]) -> None:
    """Raise ConfigError if others than this machine could come in without a token."""
    if not (tokens or is_here(host)):
        raise ConfigError(f"{option} {host}: beyond this machine only with --token WORD")
