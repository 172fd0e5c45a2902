"""Partial freezes by order: depth, position or tanks stand still while all else goes on."""

from typing import Final

from trainer.boat import Boat
from trainer.io.orders import Order
from trainer.reply import Refused, Reply

PARTS: Final = ("depth", "position", "tanks")


def hold(boat: Boat, order: Order) -> Reply:
    """Let the part that is the order's word stand still from the next tick on."""
    if order.word == "tanks" and not boat.vessel.fitted:
        return Refused(f"{boat.file.path.name} has no [ballast] table: this boat has no tanks")
    boat.state[f"held_{order.word}"] = 1.0
    return f"{order.word} frozen{_where(boat, order.word)}"


def release(boat: Boat, order: Order) -> Reply:
    """Let the part that is the order's word, or ``all`` that is frozen, go on."""
    frozen = held(boat)
    parts = frozen if order.word == "all" else [order.word]
    if order.word != "all" and order.word not in frozen:
        return Refused(f"{order.word} is not frozen; frozen: {', '.join(frozen) or 'nothing'}")
    for part in parts:
        boat.state[f"held_{part}"] = 0.0
    return f"{' and '.join(parts)} released" if parts else "nothing is frozen"


def held(boat: Boat) -> list[str]:
    """Return the parts that stand still."""
    return [part for part in PARTS if boat.state[f"held_{part}"]]


def held_text(boat: Boat) -> str:
    """Return what stands still and where, in words."""
    return ", ".join(f"{part}{_where(boat, part)}" for part in held(boat))


def _where(boat: Boat, part: str) -> str:
    """Return where a part stands, '' for one that is in no place."""
    s = boat.state
    places = {
        "depth": f" at {s.z:.1f} m",
        "position": f" at {s.x:.0f} m north, {s.y:.0f} m east of the start",
    }
    return places.get(part, "")
