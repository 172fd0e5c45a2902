"""The syntax of the sources, read once by all tests of a process."""

import ast
import functools
from pathlib import Path


@functools.cache
def tree_of(path: Path) -> ast.Module:
    """Return what a source file says."""
    return ast.parse(path.read_text(encoding="utf-8"))


@functools.cache
def nodes_of(path: Path) -> tuple[ast.AST, ...]:
    """Return all parts of a source file."""
    return tuple(ast.walk(tree_of(path)))
