"""Random legal orders: any wording of the grammar, any number within its limits."""

from collections.abc import Sequence
from random import Random
from typing import Final

from trainer.files.casualty_file import load_casualties
from trainer.helm import ORDERS
from trainer.io.order_table import FORMS, Form, Name, Place, UnitWord, Word, heading_word, variants
from trainer.io.orders import LONGEST, Order, parse
from trainer.io.quantities import Number
from trainer.io.sentences import order_sentence
from trainer.stations.roles import Role

LONGEST_WORDS: Final = LONGEST - len(order_sentence("", "999999"))  # [characters]


class Orders:
    """A stream of orders to the boat that a role may give; the same seed says the same."""

    def __init__(self, role: Role, dice: Random) -> None:
        self._dice = dice
        self._casualties = sorted(load_casualties())
        self._forms = [form for form in FORMS if _fits(form, role)]

    def __bool__(self) -> bool:
        """Return whether the role has any."""
        return bool(self._forms)

    def next(self) -> str:
        """Return the words of the next order."""
        while True:
            places = self._dice.choice(list(variants(self._dice.choice(self._forms))))
            said = self._said(places)
            if len(said) <= LONGEST_WORDS and isinstance(parse(said), Order):
                return said

    def _said(self, places: Sequence[Place]) -> str:
        return " ".join(self._word(each) for each in places)

    def _word(self, place: Place) -> str:
        if isinstance(place, Word):
            return self._dice.choice(place.spellings)[0]
        if isinstance(place, Number):
            number = self._dice.uniform(place.low, place.high)
            return f"{number:.{min(place.decimals, 2)}f}"
        if isinstance(place, UnitWord):
            return self._dice.choice(place.number.units[0].names)
        return self._dice.choice(self._casualties) if isinstance(place, Name) else "all"


def _fits(form: Form, role: Role) -> bool:
    """Return whether it is an order to the boat, and the role's to give."""
    name = form.name or heading_word(form)
    return not form.refusal and name in ORDERS and name in role.commands
