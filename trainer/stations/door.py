"""How a line comes in: with a role that is fixed, or by saying one, with a token if need be."""

import hmac
import re
from dataclasses import dataclass, field
from typing import Final

from trainer.io.secret import HIDDEN
from trainer.stations.roles import ROLES, STRANGER, Role

GUESSES: Final = 3  # wrong tokens before a line is closed
SHORT: Final = 6  # [characters]


@dataclass(frozen=True)
class Door:
    """What is asked of a line; with neither role nor token it may say what role it likes."""

    role: str | None = None
    token: str = field(default="", repr=False)

    @property
    def first(self) -> Role:
        """Return what a line is before it has said anything."""
        if self.role is not None:
            return ROLES[self.role]
        return STRANGER if self.token else ROLES["observer"]

    def hide(self, text: str) -> str:
        """Return ``text`` without the token, wherever it stands: an order may be misspelt."""
        if not self.token:
            return text
        found = re.escape(self.token)
        if len(self.token) < SHORT:  # it may stand within words that are none of it
            found = rf"(?<![\w-]){found}(?![\w-])"
        return re.sub(found, HIDDEN, text, flags=re.IGNORECASE)

    def admits(self, given: str) -> bool:
        """Return whether a token will do; how long that takes tells nothing of it."""
        return not self.token or hmac.compare_digest(given.encode(), self.token.encode())
