"""The order words: a row for each, from which all that a room has to know of it follows."""

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest
from helpers.boats import make_boat
from helpers.orders import read_order
from helpers.places import ROOT

from trainer.boat import helm
from trainer.boat.effects import WORD_EFFECTS, effects_of_boat
from trainer.core.surfaces import SURFACES
from trainer.io.orders.table import FORMS_BY_WORD
from trainer.io.orders.words import (
    BOAT_ORDERS,
    BOAT_TOPICS,
    HAND_AXES,
    ORDER_WORDS,
    SESSION_TOPICS,
    Obeyer,
)

WHEEL = ROOT / "trainer"
ROWS = WHEEL / "io" / "orders" / "words.py"
# what is measured, worked or shown has names that are order words, too
OTHER_NAMES = ({*SURFACES}, {"depth", "course", "speed"})


def named_together(node: ast.AST) -> list[str]:
    """Return the texts that stand together in one set, sequence or table of texts."""
    if isinstance(node, ast.Tuple | ast.List | ast.Set):
        items: list[ast.expr | None] = [*node.elts]
    elif isinstance(node, ast.Dict) and all(isinstance(each, ast.Constant) for each in node.values):
        items = node.keys
    else:
        return []
    texts = [each.value for each in items if isinstance(each, ast.Constant)]
    return [str(text) for text in texts] if len(texts) == len(items) else []


def written_sets(path: Path) -> Iterator[str]:
    """Yield where three order words or more stand together in a module, and which."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        names = set(named_together(node))
        if (
            len(names) > 2
            and names <= set(ORDER_WORDS)
            and not any(map(names.issubset, OTHER_NAMES))
        ):
            yield f"{path.relative_to(ROOT)}: {', '.join(sorted(names))}"


def test_no_module_but_that_of_the_rows_lists_order_words() -> None:
    modules = [path for path in WHEEL.rglob("*.py") if path != ROWS]

    assert len(modules) > 300
    assert [found for path in modules for found in written_sets(path)] == []


def test_every_order_that_has_a_wording_has_one_row_and_the_other_way_round() -> None:
    rows = [word.name for topic in BOAT_TOPICS + SESSION_TOPICS for word in topic.words]

    assert sorted(rows) == sorted(FORMS_BY_WORD)


def test_whatever_the_boat_obeys_has_a_function_or_an_effect_that_does_it() -> None:
    assert set(helm.ORDER_DUTIES) | WORD_EFFECTS.keys() == BOAT_ORDERS


def test_each_effect_is_that_of_an_order_in_full() -> None:
    effects = effects_of_boat(make_boat("bb2"))

    assert len(effects) > 60
    for effect in effects:
        order = read_order(f"{effect.words} 0" if effect.number else effect.words)
        assert order.words == effect.words
        assert order.name in WORD_EFFECTS


@pytest.mark.parametrize("axis", HAND_AXES)
def test_whoever_may_work_an_axis_may_give_an_order_that_works_it(axis: str) -> None:
    working = [word for word in ORDER_WORDS.values() if axis in word.works]

    assert working
    assert all(word.obeyer is Obeyer.BOAT and word.control.roles for word in working)


@pytest.mark.parametrize(
    ("text", "axes"),
    [
        ("course left 30", ("rudder",)),
        ("rudder auto", ("rudder",)),
        ("rudder left 5", ()),
        ("stern planes auto", ("planes",)),
        ("planes zero", ()),
        ("autopilot on", HAND_AXES),
        ("autopilot report", ()),
        ("hover 60", ("ballast",)),
        ("hover off", ()),
        ("trim manual", ()),
    ],
)
def test_an_order_gives_up_the_axes_that_it_makes_automatic(
    text: str, axes: tuple[str, ...]
) -> None:
    order = read_order(text)

    assert ORDER_WORDS[order.name].automates(order.word) == axes
