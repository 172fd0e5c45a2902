"""The map of state in docs/architecture.md: each field once, with all that writes it."""

import ast
import re
from collections import Counter
from collections.abc import Iterator

import pytest
from helpers.places import ROOT

from trainer.core import state

STARTS = ("core/start", "core/trim")  # which write a start, and not a tick
CORE = ROOT / "trainer" / "core"


def rows() -> list[tuple[list[str], set[str]]]:
    """Return the rows of the map: its fields, and the modules that write them."""
    page = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    section = page.partition("## The map of state\n")[2].partition("\n## ")[0]
    lines = [line for line in section.splitlines() if line.startswith("| `")]
    cells = [line.strip("| ").split(" | ") for line in lines]
    return [
        (re.findall(r"`(\w+)`", fields), set(re.findall(r"`([\w/]+)`", by)))
        for fields, by, *_ in cells
    ]


def blocks() -> dict[str, str]:
    """Return each name within the record, with the field of the record that it is in."""
    (call,) = [
        node.value
        for node in ast.parse((CORE / "state.py").read_text(encoding="utf-8")).body
        if isinstance(node, ast.AnnAssign) and ast.unparse(node.target) == "STATE"
    ]
    assert isinstance(call, ast.Call)
    found = {}
    for field in call.args:
        value = eval(compile(ast.Expression(field), "state", "eval"), vars(state))  # noqa: S307
        if isinstance(value, str):
            found[value] = value
        else:
            name, inner = value
            found[name] = name
            found |= dict.fromkeys(inner if isinstance(inner, list) else [], name)
    return found


def written(tree: ast.AST) -> Iterator[str]:
    """Yield the names of the attributes of ``s`` that a module's code assigns."""
    for node in ast.walk(tree):
        targets = node.targets if isinstance(node, ast.Assign) else []
        if isinstance(node, ast.AugAssign):
            targets = [node.target]
        for target in targets:
            for one in target.elts if isinstance(target, ast.Tuple) else [target]:
                place: ast.expr = one
                while isinstance(place, ast.Subscript):
                    place = place.value
                if isinstance(place, ast.Attribute) and ast.unparse(place.value) == "s":
                    yield place.attr


def test_the_map_has_each_field_of_the_state_once() -> None:
    fields = Counter(name for names, _ in rows() for name in names)
    assert fields == Counter(set(blocks().values()))


def test_the_map_names_all_of_the_core_that_writes_a_field() -> None:
    by = {name: modules for names, modules in rows() for name in names}
    block = blocks()
    missing = {
        f"{block[name]}: {module}"
        for path in sorted(CORE.rglob("*.py"))
        if (module := str(path.relative_to(ROOT / "trainer").with_suffix(""))) not in STARTS
        for name in written(ast.parse(path.read_text(encoding="utf-8")))
        if name in block and module not in by[block[name]]
    }
    assert not missing


@pytest.mark.parametrize("module", sorted({name for _, names in rows() for name in names}))
def test_the_map_names_modules_that_there_are(module: str) -> None:
    path = ROOT / "trainer" / module
    assert path.with_suffix(".py").exists() or path.is_dir()
