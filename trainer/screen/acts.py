"""What a key does, as plain records: the console carries them out."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Give:
    """Give this order."""

    words: str


@dataclass(frozen=True)
class Toggle:
    """Freeze time, or let it go on."""


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
class Open:
    """Open a dialog."""

    dialog: str


@dataclass(frozen=True)
class Write:
    """Begin an order in the line at the bottom."""

    text: str


@dataclass(frozen=True)
class Widen:
    """Let the charts go back further, or less far."""

    steps: int


@dataclass(frozen=True)
class Scroll:
    """Look further back in the log by so many lines."""

    lines: int


@dataclass(frozen=True)
class Again:
    """Replay, or end the replay that runs."""


@dataclass(frozen=True)
class Leave:
    """Leave the session, or end one's own."""


Act = Give | Toggle | Hasten | Move | Open | Write | Widen | Scroll | Again | Leave


@dataclass(frozen=True)
class Key:
    """A key: its names for the terminal, for people, in the footer, and what it does in words."""

    names: tuple[str, ...]
    label: str
    says: str  # "" keeps it out of the footer
    does: str
    act: Act
