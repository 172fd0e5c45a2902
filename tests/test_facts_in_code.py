"""No decision is made on English: code asks a field, never the words that people read."""

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest
from helpers.places import ROOT

WORDS_FOR_PEOPLE = frozenset(
    ("why", "told", "text", "who", "reason", "answer", "says", "verdict", "outcome")
)
QUESTIONS = frozenset(("startswith", "endswith"))
GRAMMARS = ("trainer/io/orders", "trainer/cli")  # there the words are what is decided on
# Texts that are a notation and no prose, by file: what they are
NOTATIONS = {
    "trainer/analysis/exercise_page.py": "lines of TOML",
    "trainer/analysis/reduce/vessel_text.py": "lines of TOML",
    "trainer/config/tables.py": "numbers",
    "trainer/console/client.py": "sentences of programs, which begin with $",
    "trainer/io/recording/format_1.py": "recordings of before, which hold words alone",
    "trainer/io/nmea.py": "sentences of NMEA, which begin with $",
}


def texts(tree: ast.AST) -> Iterator[ast.expr]:
    """Yield each question that code puts to words for people, by a literal."""
    constants = {
        target.id
        for node in ast.walk(tree)
        if isinstance(node, ast.Assign | ast.AnnAssign) and is_literal(node.value)
        for target in (node.targets if isinstance(node, ast.Assign) else [node.target])
        if isinstance(target, ast.Name)
    }

    def said(node: ast.expr) -> bool:
        return is_literal(node) or (isinstance(node, ast.Name) and node.id in constants)

    for node in ast.walk(tree):
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute):
            asked = node.func.attr in QUESTIONS and is_for_people(node.func.value)
            if asked and any(map(said, node.args)):
                yield node
        elif isinstance(node, ast.Compare):
            sides = [node.left, *node.comparators]
            if any(map(said, sides)) and any(map(is_for_people, sides)):
                yield node


def is_literal(node: ast.expr | None) -> bool:
    """Return whether an expression is words written in the code, or a tuple of such."""
    if isinstance(node, ast.Tuple):
        return any(map(is_literal, node.elts))
    return isinstance(node, ast.Constant) and isinstance(node.value, str) and node.value != ""


def is_for_people(node: ast.expr) -> bool:
    """Return whether an expression is named as words for people are."""
    name = node.attr if isinstance(node, ast.Attribute) else getattr(node, "id", "")
    return name in WORDS_FOR_PEOPLE


def modules() -> list[Path]:
    """Return the modules in which no words are decided on."""
    paths = sorted((ROOT / "trainer").rglob("*.py"))
    return [path for path in paths if not str(path.relative_to(ROOT)).startswith(GRAMMARS)]


def test_no_code_decides_by_words_that_people_read() -> None:
    found = [
        f"{name}:{node.lineno}: {ast.unparse(node)}"
        for path in modules()
        if (name := str(path.relative_to(ROOT))) not in NOTATIONS
        for node in texts(ast.parse(path.read_text(encoding="utf-8")))
    ]
    assert not found, "ask a field in place of words:\n" + "\n".join(found)


@pytest.mark.parametrize(
    "code",
    [
        'if each.why.startswith("the record ends"): pass',
        'GAP = "not recorded"\nx = branch.why.startswith(GAP)',
        'x = order.text.endswith("ft")',
        'x = "hit" in event.text',
        'x = who == "schedule"',
        'x = said.reason in ("lost", "won")',
        'x = card.verdict.outcome == "won"',
    ],
)
def test_a_decision_on_words_is_found(code: str) -> None:
    assert list(texts(ast.parse(code)))


@pytest.mark.parametrize(
    "code", ['x = order.name == "depth"', 'x = why == ""', "x = each.giver == GUARD"]
)
def test_a_decision_on_a_field_is_none(code: str) -> None:
    assert not list(texts(ast.parse(code)))
