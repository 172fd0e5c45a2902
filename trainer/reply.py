"""What an order is answered: what now holds, or why nothing changed."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Refused:
    """Why an order changed nothing."""

    reason: str


Reply = str | Refused
