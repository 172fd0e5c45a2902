"""A line comes in with a role or a token."""

import contextlib
import hmac
import ipaddress
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


def refuse_open_door(option: str, host: str, tokens: Mapping[str, str]) -> None:
    """Raise ConfigError if others than this machine could come in without a token."""
    if tokens or host == "localhost":
        return
    with contextlib.suppress(ValueError):
        if ipaddress.ip_address(host).is_loopback:
            return
    raise ConfigError(f"{option} {host}: beyond this machine only with --token WORD")
