"""The keys of each role and their actions, once. Screens, help and documents read them."""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum
from typing import Final

PAGE: Final = 8  # [lines] of the log


@dataclass(frozen=True)
class Give:
    """Give this order."""

    words: str


@dataclass(frozen=True)
class Hasten:
    """Make time faster or slower by so many steps."""

    steps: int


@dataclass(frozen=True)
class Move:
    """Move a surface by an angle [deg], right and rise positive."""

    surface: str
    by: int


@dataclass(frozen=True)
class Pump:
    """Move so much more water [t], into a tank or forward positive."""

    tank: str
    by: float


@dataclass(frozen=True)
class Open:
    """Open a dialog."""

    dialog: str


@dataclass(frozen=True)
class Write:
    """Begin an order in the line at the bottom."""

    text: str


@dataclass(frozen=True)
class Widen:
    """Change how far the charts go back."""

    steps: int


@dataclass(frozen=True)
class Scroll:
    """Look further back in the log by so many lines."""

    lines: int


class Deed(Enum):
    """The deeds of keys that need no more words."""

    TOGGLE = "freeze time, or let it go on"
    REPEAT = "repeat the order to the crew that is new; without one begin an order"
    AGAIN = "replay, or end the replay that runs"
    LEAVE = "leave the session, or end one's own"
    RING = "switch the terminal's bell on or off"


Act = Give | Hasten | Move | Pump | Open | Write | Widen | Scroll | Deed


@dataclass(frozen=True)
class Key:
    """A key: its names for the terminal, for people, in the footer, and its action."""

    names: tuple[str, ...]
    label: str
    says: str  # "" keeps it out of the footer; "B: both" names its counterpart
    does: str
    act: Act


HELP: Final = Key(("f1", "question_mark"), "F1", "help", "help, this page", Open("help"))
BRIEF: Final = Key(
    ("f12",),
    "F12",
    "briefing",
    "the exercise: task, time left, how to win, limits",
    Open("briefing"),
)
BELL: Final = Key(("ctrl+g",), "Ctrl-G", "", "switch the bell off or on", Deed.RING)
PLAN: Final = Key(("ctrl+t",), "Ctrl-T", "", "the track from above", Open("plan"))
LEAVE: Final = Key(("f10", "ctrl+c"), "F10", "leave", "leave; the session goes on", Deed.LEAVE)
END: Final = Key(("f10", "ctrl+c"), "F10", "quit", "end the run, or leave it", Deed.LEAVE)
LOG: Final = (
    Key(("pageup",), "Page Up", "", "look back in the log", Scroll(PAGE)),
    Key(("pagedown",), "Page Down", "", "look forward in the log", Scroll(-PAGE)),
)
SPAN: Final = (
    Key(("right_square_bracket",), "]", "", "charts over a longer time", Widen(1)),
    Key(("left_square_bracket",), "[", "", "charts over a shorter time", Widen(-1)),
)
REPEAT: Final = Key(
    ("enter",),
    "Enter",
    "type/repeat",
    "repeat a new order (aye), or type an order",
    Deed.REPEAT,
)
TYPE: Final = Key(("colon",), ":", "", "type an order; Esc comes back", Write(""))

INSTRUCTOR: Final = (
    HELP,
    Key(("f2", "space"), "F2", "freeze", "stop time, or start it again", Deed.TOGGLE),
    Key(("f3", "full_stop"), "F3", "step", "one tick, then frozen again", Give("step")),
    Key(("f4",), "F4", "break", "break something, or repair it", Open("casualties")),
    Key(("f5",), "F5", "sea", "change the sea", Open("sea")),
    Key(("f6",), "F6", "back", "go back in time, by the time line", Open("moments")),
    Key(("f7",), "F7", "replay", "replay the last minutes, or end the replay", Deed.AGAIN),
    Key(("f8",), "F8", "keep", "keep this moment under a name", Write("snapshot ")),
    Key(("f9",), "F9", "mark", "mark this moment, with a remark", Write("mark ")),
    END,
    BRIEF,
    PLAN,
    Key(("plus", "equals_sign"), "+", "", "time faster", Hasten(1)),
    Key(("minus",), "-", "", "time slower", Hasten(-1)),
    BELL,
    *SPAN,
    *LOG,
)


def steering(
    surface: str, pair: tuple[str, str], labels: tuple[str, str], sides: tuple[str, str]
) -> tuple[Key, ...]:
    """Return the keys that move a surface. The second of each pair moves it to the positive side.

    With Shift they move it further; of a letter that is the capital.
    """
    found = []
    for key, label, side, sign in zip(pair, labels, sides, (-1, 1), strict=True):
        says = f"{labels[1]}: {surface}" if sign < 0 else ""
        found += [
            Key((key,), label, says, f"{surface} 1 degree {side}", Move(surface, sign)),
            Key(
                (key.upper(), f"shift+{key}") if len(key) == 1 else (f"shift+{key}", f"ctrl+{key}"),
                f"Shift {label}",
                "",
                f"{surface} 5 degrees {side}{'' if len(key) == 1 else '; Ctrl does the same'}",
                Move(surface, 5 * sign),
            ),
        ]
    return tuple(found)


def order_key(key: str, says: str, words: str) -> Key:
    """Return a key that gives an order."""
    return Key((key,), key.upper() if len(key) == 1 else key, says, words, Give(words))


def pump_key(key: str, says: str, does: str, act: Pump) -> Key:
    """Return a key that moves water."""
    return Key((key,), key.upper(), says, does, act)


RUDDER: Final = (
    *steering("rudder", ("left", "right"), ("Left", "Right"), ("left", "right")),
    order_key("m", "amidships", "rudder amidships"),
    order_key("a", "auto", "rudder auto"),
)
BELLS: Final = (
    order_key("0", "to 8: bells", "bell stop"),
    order_key("1", "", "bell ahead one-third"),
    order_key("2", "", "bell ahead two-thirds"),
    order_key("3", "", "bell ahead standard"),
    order_key("4", "", "bell ahead full"),
    order_key("5", "", "bell ahead flank"),
    order_key("6", "", "bell astern one-third"),
    order_key("7", "", "bell astern two-thirds"),
    order_key("8", "", "bell astern full"),
)
STERN: Final = steering("stern", ("down", "up"), ("Down", "Up"), ("dive", "rise"))
ZERO: Final = (
    order_key("z", "stern 0", "stern planes zero"),
    order_key("x", "bow 0", "bow planes zero"),
)
PERISCOPE: Final = order_key("p", "periscope", "periscope depth")
PLANES: Final = (
    *STERN,
    *steering("bow", ("left", "right"), ("Left", "Right"), ("dive", "rise")),
    *ZERO,
    order_key("a", "auto", "planes auto"),
    PERISCOPE,
)
BOTH: Final = (  # rudder and planes, by one person
    *RUDDER,
    *STERN,
    *steering("bow", ("s", "w"), ("S", "W"), ("dive", "rise")),
    *ZERO,
    order_key("d", "planes auto", "planes auto"),
    PERISCOPE,
)
VALVES: Final = (
    order_key("1", "to 4: blow", "blow forward"),
    order_key("2", "", "blow mid"),
    order_key("3", "", "blow aft"),
    order_key("4", "", "blow all"),
    order_key("0", "no blow", "blow stop"),
    order_key("v", "vent", "vent all open"),
    order_key("s", "shut", "vent all shut"),
    Key(("e",), "E", "EMERGENCY", "emergency blow; you must confirm it", Open("emergency")),
)
WATER: Final = (
    order_key("n", "B: negative", "negative flood"),
    order_key("b", "", "negative blow"),
    pump_key("f", "G: aux", "flood auxiliary 1 t more", Pump("auxiliary", 1.0)),
    pump_key("g", "", "pump auxiliary 1 t more", Pump("auxiliary", -1.0)),
    pump_key("u", "I: depth", "flood depth-control 1 t more", Pump("depth_control", 1.0)),
    pump_key("i", "", "pump depth-control 1 t more", Pump("depth_control", -1.0)),
    pump_key("t", "Y: trim", "pump trim 1 t more to aft", Pump("trim", -1.0)),
    pump_key("y", "", "pump trim 1 t more to forward", Pump("trim", 1.0)),
    order_key("h", "J: hover", "hover on"),
    order_key("j", "", "hover off"),
    order_key("c", "K: charge", "compressor on"),
    order_key("k", "", "compressor off"),
)
FIRST: Final = (HELP, REPEAT, BRIEF, LEAVE)  # named first where there is little room
COMMON: Final = (TYPE, BELL, *SPAN, *LOG)

KEYS: Final[Mapping[str, tuple[Key, ...]]] = {
    "instructor": INSTRUCTOR,
    "helm": (*FIRST, *RUDDER, *BELLS, *COMMON),
    "planes": (*FIRST, *PLANES, *COMMON),
    "pilot": (*FIRST, *BOTH, *BELLS, *COMMON),
    "ballast": (*FIRST, *VALVES, *WATER, *COMMON),
    "diving": (*FIRST, *PLANES, *VALVES, *WATER, *COMMON),
    "observer": (
        *FIRST,
        Key(("m",), "M", "mark", "mark this moment, with a remark", Write("mark ")),
        *COMMON,
    ),
    "scope": (
        *FIRST,
        order_key("u", "raise", "scope raise"),
        order_key("d", "lower", "scope lower"),
        order_key("1", "power", "scope power 1.5"),
        order_key("6", "", "scope power 6"),
        Key(("t",), "T", "train", "turn it to an angle from the bow", Write("scope train ")),
        Key(("r",), "R", "range", "measure a range by a mast's height", Write("scope range ")),
        Key(("m",), "M", "mark", "mark a ship on its bearing", Write("mark contact ")),
        *COMMON,
    ),
    "visitor": (
        *FIRST,
        Key(("d",), "D", "R: lever", "push the lever down, so many degrees", Write("lever dive ")),
        Key(("r",), "R", "", "pull it up", Write("lever rise ")),
        order_key("z", "lever 0", "lever zero"),
        order_key("n", "new dive", "restart"),
        *COMMON,
    ),
}


def footer(role: str) -> tuple[tuple[str, str], ...]:
    """Return the keys that the last line names."""
    return tuple((key.label, key.says) for key in KEYS[role] if key.says)


def by_name(role: str) -> dict[str, Key]:
    """Return the keys of a role by the names that a terminal gives them.

    A capital does what its letter does, as with Caps Lock, unless it is a key of its own.
    """
    found = {name: key for key in KEYS[role] for name in key.names}
    capitals = {name.upper(): key for name, key in found.items() if len(name) == 1}
    return capitals | found


def key_table(role: str) -> str:
    """Return the Markdown table of a role's keys, as docs/instructor.md shows it."""
    rows = [f"| `{key.label}` | {key.does} |" for key in KEYS[role]]
    return "\n".join(["| key | does |", "|---|---|", *rows]) + "\n"


def key_tables() -> str:
    """Return the tables of all roles but those of who looks on or visits."""
    shown = (role for role in KEYS if role not in ("observer", "scope", "visitor"))
    return "\n".join(f"#### {role.capitalize()}\n\n{key_table(role)}" for role in shown)
