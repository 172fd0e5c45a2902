"""A line comes in with a role or a token. A log that it cannot flood notes it."""

import hmac
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Final

from trainer.config.files import ConfigError
from trainer.io.orders.grammar import HIDDEN
from trainer.session.stations.roles import ROLES, STRANGER, Role

GUESSES: Final = 3  # wrong tokens before a line is closed
SHORT: Final = 6  # [characters]
ANY: Final = ""  # the role of a token that stands for all roles without their own


@dataclass(frozen=True)
class Access:
    """The demands on a line. With neither role nor tokens it may say what role it likes."""

    role: str | None = None
    tokens: Mapping[str, str] = field(default_factory=dict, repr=False)  # by role, or ANY
    entered: Callable[[], object] = bool  # called when a line has said who it is

    @property
    def first(self) -> Role:
        """Return what a line is before it has said anything."""
        if self.role is not None:
            return ROLES[self.role]
        return STRANGER if self.tokens else ROLES["observer"]

    def hide(self, text: str) -> str:
        """Return ``text`` without a token, wherever it stands: an order may be misspelt."""
        for token in self.tokens.values():
            found = re.escape(token)
            if len(token) < SHORT:  # it may stand within words that are none of it
                found = rf"(?<![\w-]){found}(?![\w-])"
            text = re.sub(found, HIDDEN, text, flags=re.IGNORECASE)
        return text

    def admits(self, role: str, given: str) -> bool:
        """Return whether a token will do for a role. How long that takes tells nothing of it.

        Where tokens are asked for, a role that has none is nobody's.
        """
        if not self.tokens:
            return True
        wanted = self.tokens.get(role, self.tokens.get(ANY, ""))
        return hmac.compare_digest(given.encode(), wanted.encode()) and bool(wanted)


def read_tokens(given: tuple[str, ...]) -> dict[str, str]:
    """Return the tokens of ``ROLE=WORD`` or ``WORD`` each; ConfigError if one is given twice."""
    tokens: dict[str, str] = {}
    for text in given:
        role, equals, word = text.partition("=")
        if not equals or role not in ROLES:
            role, word = ANY, text
        if not word:
            raise ConfigError(f"--token {role}=: say {role}=WORD")
        if role in tokens:
            raise ConfigError(f"--token: {role or 'a word for all roles'} is given twice")
        tokens[role] = word
    return tokens


MOST: Final = 20  # entries
WHILE: Final = 10.0  # [s]


class NoiseLog:
    """Pass entries on as long as they are few."""

    def __init__(self, log: Callable[[str, str], None], clock: Callable[[], float]) -> None:
        """Pass on to ``log``; ``clock`` gives the time [s]."""
        self._log = log
        self._clock = clock
        self._since = clock()
        self._passed = 0
        self._held: dict[str, int] = {}  # by kind

    def log(self, kind: str, text: str) -> None:
        """Pass an entry on, or count it."""
        self.settle()
        if self._passed < MOST:
            self._passed += 1
            self._log(kind, text)
            return
        self._held[kind] = self._held.get(kind, 0) + 1

    def settle(self) -> None:
        """Begin afresh if the while is over, with the number of what was held back."""
        if self._clock() - self._since >= WHILE:
            self.close()
            self._since = self._clock()
            self._passed = 0

    def close(self) -> None:
        """Tell the number of what was held back."""
        for kind, count in self._held.items():
            self._log(kind, f"{count} more of the same, not written one by one")
        self._held.clear()
