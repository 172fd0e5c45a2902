"""Names by what the grammar calls them, as far as the session has told them."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Final

from trainer.io.order_table import NAMES
from trainer.screen.sight import Sight

CASUALTY: Final = NAMES["NAME"].says
MOMENT: Final = NAMES["LABEL"].says


class Names(Mapping[str, Sequence[str]]):
    """The names that an order may hold at this moment."""

    def __init__(self, sight: Sight) -> None:
        self._sight = sight

    def __getitem__(self, says: str) -> Sequence[str]:
        if says == CASUALTY:
            return [each.name for each in self._sight.casualties]
        if says == MOMENT:
            return [kept.text for kept in self._sight.snapshots]
        raise KeyError(says)

    def __iter__(self) -> Iterator[str]:
        return iter((CASUALTY, MOMENT))

    def __len__(self) -> int:
        return 2
