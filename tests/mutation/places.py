"""Where a fault of one place can be made, and how its module then reads."""

import ast
from collections.abc import Mapping
from enum import Enum
from itertools import accumulate
from pathlib import Path
from typing import Any, Final, NamedTuple

ROOMS: Final = ("session", "io", "boat")
TURNED: Final[Mapping[type[ast.cmpop], type[ast.cmpop]]] = {
    ast.Lt: ast.LtE,
    ast.LtE: ast.Lt,
    ast.Gt: ast.GtE,
    ast.GtE: ast.Gt,
    ast.Eq: ast.NotEq,
    ast.NotEq: ast.Eq,
    ast.Is: ast.IsNot,
    ast.IsNot: ast.Is,
    ast.In: ast.NotIn,
    ast.NotIn: ast.In,
}
ORDERED: Final = (ast.Lt, ast.LtE, ast.Gt, ast.GtE)  # what turns at its limit alone


class FaultKind(Enum):
    """What a careless hand does."""

    COMPARISON = "comparison turned"
    NUMBER = "number off by one"
    CALL = "call dropped"
    BRANCH = "branches swapped"


class Place(NamedTuple):
    """A place of a module, and the fault that is made there."""

    file: str  # from the checkout
    line: int
    function: str
    kind: FaultKind
    before: str
    after: str
    begin: int  # [bytes] of the file
    end: int

    def __str__(self) -> str:
        return f"{self.file}:{self.line} {self.function}: `{self.before}` -> `{self.after}`"


def files_of(root: Path, room: str) -> list[Path]:
    """Return the modules of a room, in order."""
    return sorted((root / "trainer" / room).rglob("*.py"))


def places_in(root: Path, path: Path) -> list[Place]:
    """Return the places of a module, in order."""
    finder = PlaceFinder(path.relative_to(root).as_posix(), path.read_bytes())
    finder.visit(ast.parse(finder.source))
    return finder.places


def with_fault_at(source: bytes, place: Place) -> bytes:
    """Return a module with the fault of a place."""
    return source[: place.begin] + place.after.encode() + source[place.end :]


class PlaceFinder(ast.NodeVisitor):
    """What goes through the bodies of a module's functions."""

    def __init__(self, file: str, source: bytes) -> None:
        self.file, self.source = file, source
        self.places: list[Place] = []
        self._names: list[str] = []
        self._functions = 0  # how deep
        lengths = (len(line) for line in source.splitlines(keepends=True))
        self._starts = [0, *accumulate(lengths)]

    def visit_ClassDef(self, node: ast.ClassDef) -> None:
        """Go through its functions."""
        self._names.append(node.name)
        for each in node.body:
            self.visit(each)
        self._names.pop()

    def visit_FunctionDef(self, node: ast.FunctionDef) -> None:
        """Go through its body."""
        self._names.append(node.name)
        self._functions += 1
        for each in node.body:
            self.visit(each)
        self._functions -= 1
        self._names.pop()

    def visit_AnnAssign(self, node: ast.AnnAssign) -> None:
        """Go through the value alone."""
        if node.value:
            self.visit(node.value)

    def visit_JoinedStr(self, node: ast.JoinedStr) -> None:
        """Pass by: before Python 3.12 its parts have no place of their own."""

    def visit_Assert(self, node: ast.Assert) -> None:
        """Pass by: it tells the reader, or the checker of types."""

    def visit_Compare(self, node: ast.Compare) -> None:
        """Note one that compares two."""
        turned = TURNED[type(node.ops[0])]
        if len(node.ops) == 1:
            other = ast.Compare(node.left, [turned()], node.comparators)
            self._note(node, FaultKind.COMPARISON, f"({ast.unparse(other)})")
        self.generic_visit(node)

    def visit_Constant(self, node: ast.Constant) -> None:
        """Note a number."""
        if isinstance(node.value, int | float) and not isinstance(node.value, bool):
            self._note(node, FaultKind.NUMBER, repr(node.value + 1))

    def visit_Expr(self, node: ast.Expr) -> None:
        """Note a call whose value nobody takes."""
        if isinstance(node.value, ast.Call):
            self._note(node, FaultKind.CALL, "pass")
        self.generic_visit(node)

    def visit_If(self, node: ast.If) -> None:
        """Note its test."""
        self._swap(node.test)
        for each in (*node.body, *node.orelse):
            self.visit(each)

    def visit_IfExp(self, node: ast.IfExp) -> None:
        """Note its test."""
        self._swap(node.test)
        self.visit(node.body)
        self.visit(node.orelse)

    def _swap(self, test: ast.expr) -> None:
        self._note(test, FaultKind.BRANCH, f"(not ({ast.unparse(test)}))")
        if isinstance(test, ast.Compare) and not isinstance(test.ops[0], ORDERED):
            self.generic_visit(test)  # turned it would be the same fault once more
        else:
            self.visit(test)

    def _note(self, node: Any, kind: FaultKind, after: str) -> None:
        if not self._functions:
            return
        begin = self._starts[node.lineno - 1] + node.col_offset
        end = self._starts[node.end_lineno - 1] + node.end_col_offset
        before = self.source[begin:end].decode()
        self.places.append(
            Place(self.file, node.lineno, ".".join(self._names), kind, before, after, begin, end)
        )
