"""The first sentence of a docstring is short and plain, for whose second language English is."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest
from helpers.places import ROOT
from helpers.syntax import nodes_of, tree_of

MOST = 15  # [words]
SENTENCE = re.compile(r"(?<=[.!?])[\"')\]]*\s+(?=[A-Z\"`'(\[0-9])|\n\s*\n")
PROVING = (
    "bench",
    "c_twin",
    "cases",
    "faults",
    "fuzz",
    "layouts",
    "mutation",
    "simulation",
    "soak",
)  # rooms of tests/ with programs
MODULES = [
    *sorted((ROOT / "trainer").rglob("*.py")),
    *(path for room in PROVING for path in sorted((ROOT / "tests" / room).glob("[!t]*.py"))),
]


def first_sentence(docstring: str) -> str:
    """Return the first sentence, on one line."""
    return " ".join(SENTENCE.split(docstring.strip(), maxsplit=1)[0].split())


def fault(docstring: str) -> str:
    """Return what is wrong with the first sentence of a docstring, "" if nothing is."""
    first = first_sentence(docstring)
    words = len(first.split())
    faults = {
        f"{words} words, at most {MOST}": words > MOST,
        "ends without a full stop": not first.endswith("."),
        "begins with a small letter": first[:1].islower(),
    }
    return ", ".join(told for told, holds in faults.items() if holds)


def docstrings(path: Path) -> Iterator[tuple[str, str]]:
    """Yield what is public in a module and its docstring: the module, its classes and functions."""
    tree = tree_of(path)
    yield "", ast.get_docstring(tree) or ""
    for node in nodes_of(path):
        if isinstance(node, ast.ClassDef | ast.FunctionDef) and not node.name.startswith("_"):
            yield node.name, ast.get_docstring(node) or ""


def faults(*paths: Path) -> list[str]:
    """Return the faults in modules, a line each."""
    return [
        f"{path.relative_to(ROOT)} {name}: {wrong}: {first_sentence(text)}"
        for path in paths
        for name, text in docstrings(path)
        if text and (wrong := fault(text))
    ]


def test_first_sentences_are_short_and_plain() -> None:
    assert MODULES
    assert not faults(*MODULES)


@pytest.mark.parametrize(
    "wrong",
    [
        "return the depth.",
        "Return the depth",
        "Return the depth of the boat below the surface of the sea as its crew reads it now.",
    ],
)
def test_a_fault_is_seen(wrong: str) -> None:
    assert fault(wrong)
    assert not fault(
        "Return the depth [m]. ConfigError if there is none, said at any length at all."
    )
