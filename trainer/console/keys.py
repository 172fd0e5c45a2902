"""The keys of each role and their actions, once. Screens, help and documents read them.

``app`` looks a pressed key up here and does its action, which is data: an order to send, a surface
to move by some degrees, a dialog to open.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from enum import Enum
from typing import Final

PAGE_LINES: Final = 8  # [lines] of the log


@dataclass(frozen=True)
class OrderAction:
    """Give this order."""

    words: str


@dataclass(frozen=True)
class PaceAction:
    """Make time faster or slower by so many steps."""

    steps: int


@dataclass(frozen=True)
class MoveAction:
    """Move a surface by an angle [deg], right and rise positive."""

    surface: str
    by: int


@dataclass(frozen=True)
class PumpAction:
    """Move so much more water [t], into a tank or forward positive."""

    tank: str
    by: float


@dataclass(frozen=True)
class DialogAction:
    """Open a dialog."""

    dialog: str


@dataclass(frozen=True)
class TypingAction:
    """Begin an order in the line at the bottom."""

    text: str


@dataclass(frozen=True)
class SpanAction:
    """Change how far the charts go back."""

    steps: int


@dataclass(frozen=True)
class ScrollAction:
    """Look further back in the log by so many lines."""

    lines: int


class PlainAction(Enum):
    """The deeds of keys that need no more words."""

    TOGGLE = "freeze time, or let it go on"
    REPEAT = "repeat the order to the crew that is new; without one begin an order"
    AGAIN = "replay, or end the replay that runs"
    SHOW = "have the way shown, or end that"
    GHOST = "ghost on or off"
    PREDICT = "predictor on or off"
    LEAVE = "leave the session, or end one's own"
    RING = "switch the terminal's bell on or off"


KeyAction = (
    OrderAction
    | PaceAction
    | MoveAction
    | PumpAction
    | DialogAction
    | TypingAction
    | SpanAction
    | ScrollAction
    | PlainAction
)


@dataclass(frozen=True)
class Key:
    """A key: its names for the terminal, for people, in the footer, and its action."""

    names: tuple[str, ...]
    label: str
    says: str  # "" keeps it out of the footer; "B: both" names its counterpart
    does: str
    act: KeyAction


HELP_KEY: Final = Key(
    ("f1", "question_mark"), "F1", "help", "help, this page", DialogAction("help")
)
BRIEFING_KEY: Final = Key(
    ("f12",),
    "F12",
    "briefing",
    "the exercise: task, time left, how to win, limits",
    DialogAction("briefing"),
)
BELL_KEY: Final = Key(("ctrl+g",), "Ctrl-G", "", "switch the bell off or on", PlainAction.RING)
PLAN_KEY: Final = Key(("ctrl+t",), "Ctrl-T", "", "the track from above", DialogAction("plan"))
LEAVE_KEY: Final = Key(
    ("f10", "ctrl+c"), "F10", "leave", "leave; the session goes on", PlainAction.LEAVE
)
END_KEY: Final = Key(
    ("f10", "ctrl+c"), "F10", "quit", "end the run, or leave it", PlainAction.LEAVE
)
LOG_KEYS: Final = (
    Key(("pageup",), "Page Up", "", "look back in the log", ScrollAction(PAGE_LINES)),
    Key(("pagedown",), "Page Down", "", "look forward in the log", ScrollAction(-PAGE_LINES)),
)
SPAN_KEYS: Final = (
    Key(("right_square_bracket",), "]", "", "charts over a longer time", SpanAction(1)),
    Key(("left_square_bracket",), "[", "", "charts over a shorter time", SpanAction(-1)),
)
REPEAT_KEY: Final = Key(
    ("enter",),
    "Enter",
    "type/repeat",
    "repeat a new order (aye), or type an order",
    PlainAction.REPEAT,
)
TYPE_KEY: Final = Key(
    ("colon",), ":", "", "type an order, as other letters do; Esc comes back", TypingAction("")
)

FREEZE_KEY: Final = Key(
    ("f2", "space"), "F2", "freeze", "stop time, or start it again", PlainAction.TOGGLE
)

INSTRUCTOR_KEYS: Final = (
    HELP_KEY,
    FREEZE_KEY,
    Key(("f3", "full_stop"), "F3", "step", "one tick, then frozen again", OrderAction("step")),
    Key(("f4",), "F4", "break", "break something, or repair it", DialogAction("casualties")),
    Key(("f5",), "F5", "sea", "change the sea", DialogAction("sea")),
    Key(("f6",), "F6", "back", "go back in time, by the time line", DialogAction("moments")),
    Key(("f7",), "F7", "replay", "replay the last minutes, or end the replay", PlainAction.AGAIN),
    Key(("f8",), "F8", "keep", "keep this moment under a name", TypingAction("snapshot ")),
    Key(("f9",), "F9", "mark", "mark this moment, with a remark", TypingAction("mark ")),
    END_KEY,
    BRIEFING_KEY,
    PLAN_KEY,
    Key(("plus", "equals_sign"), "+", "", "time faster", PaceAction(1)),
    Key(("minus",), "-", "", "time slower", PaceAction(-1)),
    BELL_KEY,
    *SPAN_KEYS,
    *LOG_KEYS,
)


def steering(
    surface: str, pair: tuple[str, str], labels: tuple[str, str], sides: tuple[str, str]
) -> tuple[Key, ...]:
    """Return the keys that move a surface. The second of each pair moves it to the positive side.

    With Shift they move it further; of a letter that is the capital.
    """
    move_keys = []
    for key, label, side, sign in zip(pair, labels, sides, (-1, 1), strict=True):
        says = f"{labels[1]}: {surface}" if sign < 0 else ""
        move_keys += [
            Key((key,), label, says, f"{surface} 1 degree {side}", MoveAction(surface, sign)),
            Key(
                (key.upper(), f"shift+{key}") if len(key) == 1 else (f"shift+{key}", f"ctrl+{key}"),
                f"Shift {label}",
                "",
                f"{surface} 5 degrees {side}{'' if len(key) == 1 else '; Ctrl does the same'}",
                MoveAction(surface, 5 * sign),
            ),
        ]
    return tuple(move_keys)


def order_key(key: str, says: str, words: str) -> Key:
    """Return a key that gives an order."""
    return Key((key,), key.upper() if len(key) == 1 else key, says, words, OrderAction(words))


def pump_key(key: str, says: str, does: str, act: PumpAction) -> Key:
    """Return a key that moves water."""
    return Key((key,), key.upper(), says, does, act)


RUDDER_KEYS: Final = (
    *steering("rudder", ("left", "right"), ("Left", "Right"), ("left", "right")),
    order_key("m", "amidships", "rudder amidships"),
    order_key("a", "auto", "rudder auto"),
)
TELEGRAPH_KEYS: Final = (
    order_key("0", "to 8: engine", "bell stop"),
    order_key("1", "", "bell ahead one-third"),
    order_key("2", "", "bell ahead two-thirds"),
    order_key("3", "", "bell ahead standard"),
    order_key("4", "", "bell ahead full"),
    order_key("5", "", "bell ahead flank"),
    order_key("6", "", "bell astern one-third"),
    order_key("7", "", "bell astern two-thirds"),
    order_key("8", "", "bell astern full"),
)
STERN_KEYS: Final = steering("stern", ("down", "up"), ("Down", "Up"), ("dive", "rise"))
ZERO_KEYS: Final = (
    order_key("z", "stern 0", "stern planes zero"),
    order_key("x", "bow 0", "bow planes zero"),
)
PERISCOPE_KEY: Final = order_key("p", "periscope", "periscope depth")
PLANE_KEYS: Final = (
    *STERN_KEYS,
    *steering("bow", ("left", "right"), ("Left", "Right"), ("dive", "rise")),
    *ZERO_KEYS,
    order_key("a", "auto", "planes auto"),
    PERISCOPE_KEY,
)
PILOT_KEYS: Final = (  # rudder and planes, by one person
    *RUDDER_KEYS,
    *STERN_KEYS,
    *steering("bow", ("s", "w"), ("S", "W"), ("dive", "rise")),
    *ZERO_KEYS,
    order_key("d", "planes auto", "planes auto"),
    PERISCOPE_KEY,
)
VALVE_KEYS: Final = (
    order_key("1", "to 4: blow", "blow forward"),
    order_key("2", "", "blow mid"),
    order_key("3", "", "blow aft"),
    order_key("4", "", "blow all"),
    order_key("0", "no blow", "blow stop"),
    order_key("v", "vent", "vent all open"),
    order_key("s", "shut", "vent all shut"),
    Key(("e",), "E", "EMERGENCY", "emergency blow; you must confirm it", DialogAction("emergency")),
)
WATER_KEYS: Final = (
    order_key("n", "B: negative", "negative flood"),
    order_key("b", "", "negative blow"),
    pump_key("f", "G: aux", "flood auxiliary 1 t more", PumpAction("auxiliary", 1.0)),
    pump_key("g", "", "pump auxiliary 1 t more", PumpAction("auxiliary", -1.0)),
    pump_key("u", "I: depth", "flood depth-control 1 t more", PumpAction("depth_control", 1.0)),
    pump_key("i", "", "pump depth-control 1 t more", PumpAction("depth_control", -1.0)),
    pump_key("t", "Y: trim", "pump trim 1 t more to aft", PumpAction("trim", -1.0)),
    pump_key("y", "", "pump trim 1 t more to forward", PumpAction("trim", 1.0)),
    order_key("h", "J: hover", "hover on"),
    order_key("j", "", "hover off"),
    order_key("c", "K: charge", "compressor on"),
    order_key("k", "", "compressor off"),
)
# Who trains may begin to type an order at any time, so the bow planes have no letters.
TRAINEE_BOW_KEYS: Final = (
    Key(("comma",), ",", ".: bow", "bow 1 degree dive", MoveAction("bow", -1)),
    Key(("full_stop",), ".", "", "bow 1 degree rise", MoveAction("bow", 1)),
    Key(("less_than_sign",), "<", "", "bow 5 degrees dive", MoveAction("bow", -5)),
    Key(("greater_than_sign",), ">", "", "bow 5 degrees rise", MoveAction("bow", 5)),
)
# Where a screen has little room, its last line names these keys first.
FOOTER_KEYS: Final = (HELP_KEY, REPEAT_KEY, BRIEFING_KEY, LEAVE_KEY)
COMMON_KEYS: Final = (TYPE_KEY, BELL_KEY, *SPAN_KEYS, *LOG_KEYS)

KEYS: Final[Mapping[str, tuple[Key, ...]]] = {
    "instructor": INSTRUCTOR_KEYS,
    "helm": (*FOOTER_KEYS, *RUDDER_KEYS, *TELEGRAPH_KEYS, *COMMON_KEYS),
    "planes": (*FOOTER_KEYS, *PLANE_KEYS, *COMMON_KEYS),
    "pilot": (*FOOTER_KEYS, *PILOT_KEYS, *TELEGRAPH_KEYS, *COMMON_KEYS),
    "ballast": (*FOOTER_KEYS, *VALVE_KEYS, *WATER_KEYS, *COMMON_KEYS),
    "diving": (*FOOTER_KEYS, *PLANE_KEYS, *VALVE_KEYS, *WATER_KEYS, *COMMON_KEYS),
    "trainee": (
        *FOOTER_KEYS,
        replace(FREEZE_KEY, names=("f2",)),
        Key(("f5",), "F5", "", "the reference crew's run beside yours, or not", PlainAction.GHOST),
        Key(("f6",), "F6", "", "where the boat goes as it stands, or not", PlainAction.PREDICT),
        Key(("f7",), "F7", "the way", "have the way shown, or end that", PlainAction.SHOW),
        Key(("f8",), "F8", "hint", "what is overdue, and why; it costs marks", OrderAction("hint")),
        *steering("rudder", ("left", "right"), ("Left", "Right"), ("left", "right")),
        order_key("m", "amidships", "rudder amidships"),
        *STERN_KEYS,
        *TRAINEE_BOW_KEYS,
        *ZERO_KEYS,
        *TELEGRAPH_KEYS,
        *COMMON_KEYS,
    ),
    "deck": (
        *FOOTER_KEYS,
        Key(("c",), "C", "course", "order a course", TypingAction("order course ")),
        Key(("d",), "D", "depth", "order a depth", TypingAction("order depth ")),
        Key(("s",), "S", "speed", "order a speed", TypingAction("order speed ")),
        *COMMON_KEYS,
    ),
    "observer": (
        *FOOTER_KEYS,
        Key(("m",), "M", "mark", "mark this moment, with a remark", TypingAction("mark ")),
        *COMMON_KEYS,
    ),
    "scope": (
        *FOOTER_KEYS,
        order_key("u", "raise", "scope raise"),
        order_key("d", "lower", "scope lower"),
        order_key("1", "power", "scope power 1.5"),
        order_key("6", "", "scope power 6"),
        Key(("t",), "T", "train", "turn it to an angle from the bow", TypingAction("scope train ")),
        Key(
            ("r",), "R", "range", "measure a range by a mast's height", TypingAction("scope range ")
        ),
        Key(("m",), "M", "mark", "mark a ship on its bearing", TypingAction("mark contact ")),
        *COMMON_KEYS,
    ),
    "visitor": (
        *FOOTER_KEYS,
        Key(
            ("d",),
            "D",
            "R: lever",
            "push the lever down, so many degrees",
            TypingAction("lever dive "),
        ),
        Key(("r",), "R", "", "pull it up", TypingAction("lever rise ")),
        order_key("z", "lever 0", "lever zero"),
        order_key("n", "new dive", "restart"),
        *COMMON_KEYS,
    ),
}


def footer(role: str) -> tuple[tuple[str, str], ...]:
    """Return the keys that the last line names."""
    return tuple((key.label, key.says) for key in KEYS[role] if key.says)


def by_name(role: str) -> dict[str, Key]:
    """Return the keys of a role by the names that a terminal gives them.

    A capital does what its letter does, as with Caps Lock, unless it is a key of its own.
    """
    keys_by_name = {name: key for key in KEYS[role] for name in key.names}
    capitals = {name.upper(): key for name, key in keys_by_name.items() if len(name) == 1}
    return capitals | keys_by_name
