"""No decision is made on English: code asks a field, never the words that people read."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest
from helpers.places import ROOT
from helpers.syntax import tree_of

WORDS_FOR_PEOPLE = frozenset(
    ("why", "told", "text", "who", "reason", "answer", "says", "verdict", "outcome")
)
QUESTIONS = frozenset(("startswith", "endswith", "removeprefix", "removesuffix"))
PATTERN_QUESTIONS = frozenset(
    ("match", "search", "fullmatch", "findall", "finditer", "sub", "split")
)
# Attributes that hold the names which code has for things; all others may hold prose
CODE_NAMES = frozenset(
    ("name", "word", "kind", "key", "unit", "quantity", "platform", "address", "path")
)
GRAMMARS = ("trainer/io/orders", "trainer/cli")  # there the words are what is decided on
# Texts that are a notation and no prose, by file: what they are
NOTATIONS = {
    "trainer/analysis/bench/delays.py": "sentences of programs",
    "trainer/authoring/exercise_page.py": "lines of TOML",
    "trainer/config/tables.py": "numbers",
    "trainer/config/world/soundings.py": "names of files",
    "trainer/config/exercise/steps.py": "orders in backquotes",
    "trainer/console/client.py": "sentences of programs, which begin with $",
    "trainer/console/drawing/dials.py": "orders as they are typed",
    "trainer/console/journal.py": "orders as they are typed",
    "trainer/console/own_session.py": "the line by which a session says where it listens",
    "trainer/debrief/page/sections.py": "the place at the head of an event",
    "trainer/debrief/passage/ships_met.py": "marks as the crew types them",
    "trainer/io/recording/format_1.py": "recordings of before, which hold words alone",
    "trainer/io/nmea.py": "sentences of NMEA, which begin with $",
}

# Functions whose text says how something stands, and which refuse nothing: what it tells
STATES = {
    "trainer/api/boat.py: lost": "how a boat was lost, for the Python face",
    "trainer/identify/fitted_ship.py: doubt": "a result of a fit, for the Python face",
    "trainer/io/recording/recording.py: behind": "how the disk keeps up",
}
# "Return why nobody may", and then what it is where anybody may
TEXT_OF_NO = re.compile(r"^\w+ why\b[^.]*(\"\"|''|or nothing)|(\"\"|'') (if|where) \w+ (may|can)\b")


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

    def begun(node: ast.expr) -> bool:
        return any(map(said, node.values if isinstance(node, ast.JoinedStr) else [node]))

    for node in ast.walk(tree):
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute):
            by, of = node.func.attr, node.func.value
            if by in QUESTIONS and (is_for_people(of) or is_prose(of)):
                found = any(map(begun, node.args))
            else:
                found = by in PATTERN_QUESTIONS and any(map(is_prose, node.args))
            if found:
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


def is_prose(node: ast.expr) -> bool:
    """Return whether an expression is an attribute that may hold prose."""
    return isinstance(node, ast.Attribute) and node.attr.islower() and node.attr not in CODE_NAMES


def modules() -> list[Path]:
    """Return the modules in which no words are decided on."""
    paths = sorted((ROOT / "trainer").rglob("*.py"))
    return [path for path in paths if not str(path.relative_to(ROOT)).startswith(GRAMMARS)]


def test_no_code_decides_by_words_that_people_read() -> None:
    found = [
        f"{name}:{node.lineno}: {ast.unparse(node)}"
        for path in modules()
        if (name := str(path.relative_to(ROOT))) not in NOTATIONS
        for node in texts(tree_of(path))
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
        'x = order.text.removeprefix("when ")',
        'x = run.label.removesuffix(f" by {name}")',
        'x = re.fullmatch("hit .*", event.said)',
        "x = EVENT_PATTERN.match(event.text)",
    ],
)
def test_a_decision_on_words_is_found(code: str) -> None:
    assert list(texts(ast.parse(code)))


@pytest.mark.parametrize(
    "code",
    [
        'x = order.name == "depth"',
        'x = why == ""',
        "x = each.giver == GUARD",
        'x = each.name.removeprefix("bank_")',
    ],
)
def test_a_decision_on_a_field_is_none(code: str) -> None:
    assert not list(texts(ast.parse(code)))


def answers_by_text(tree: ast.AST) -> Iterator[str]:
    """Yield the functions whose docstring promises a reason or "" as the answer yes."""
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef) and isinstance(node.returns, ast.Name):
            says = " ".join((ast.get_docstring(node) or "").split())
            if node.returns.id == "str" and TEXT_OF_NO.search(says):
                yield node.name


def test_a_function_that_may_refuse_answers_by_a_type() -> None:
    paths = sorted((ROOT / "trainer").rglob("*.py"))
    found = {
        f"{path.relative_to(ROOT)}: {name}"
        for path in paths
        for name in answers_by_text(tree_of(path))
    }
    assert found == set(STATES), "answer by `Refused | None`, or tell in STATES what it is"


@pytest.mark.parametrize(
    "says",
    [
        'Return why a line may not take another role, "" where it may.',
        "Return why a step is too long for a sea,\n    '' if it fits.",
        "Return why nothing compiles here, and what helps; or nothing.",
        'Return the reason of a refusal, "" if it may go on.',
    ],
)
def test_an_answer_of_no_by_a_text_is_found(says: str) -> None:
    code = f"def barred() -> str:\n    '''{says}'''"
    assert list(answers_by_text(ast.parse(code))) == ["barred"]
