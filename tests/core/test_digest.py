"""The digest of the core's sources: what computes counts, and words do not."""

import ast
import io
import tokenize
from pathlib import Path

import pytest

from trainer.core import digest
from trainer.core.digest import KERNEL_FOLDERS, digest_sources, read_source, sources, without_words

KERNEL = '''"""A module's docstring, with a # in it: and a colon:
"""

LIMIT = 5.0  # [m] of "what"
SIGN = "#"  # a string is none
TABLE = """
1.5  # a number's table
"""


def deepen(z: float) -> float:  # noqa: D103
    """Return it deeper.

    Why: for a test.
    """
    # a comment

    return z + LIMIT
'''


def lines_that_compute(source: str) -> list[str]:
    """Return a source's lines without words, as Python itself tells what are words."""
    lines, gone = source.splitlines(), set[int]()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Module | ast.FunctionDef | ast.ClassDef) and node.body:
            first = node.body[0]
            if isinstance(first, ast.Expr) and isinstance(first.value, ast.Constant):
                gone.update(range(first.lineno - 1, first.end_lineno or first.lineno))
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        if token.type == tokenize.COMMENT:
            row, column = token.start
            lines[row - 1] = lines[row - 1][:column].rstrip()
    return [line.rstrip() for i, line in enumerate(lines) if i not in gone and line.strip()]


@pytest.mark.parametrize("path", sources(*KERNEL_FOLDERS), ids=lambda path: path.stem)
def test_words_are_found_as_python_finds_them(path: Path) -> None:
    source = read_source(path)
    found = [line.rstrip() for line in without_words(source).splitlines() if line.strip()]
    assert found == lines_that_compute(source)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("A module's docstring", "Other words"),
        ("Why: for a test.\n\n", "Longer,\n    and more.\n"),
        ('  # [m] of "what"', ""),
        ("    # a comment\n\n", "\n\n    # others\n    # of two lines\n"),
        ("  # noqa: D103", ""),
    ],
)
def test_other_words_are_the_same_core(old: str, new: str, core: Path) -> None:
    before = digest_sources("core")
    text = core.read_text()
    core.write_text(text.replace(old, new))
    assert digest_sources("core") == before


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("5.0", "5.5"),
        ('"#"', '"##"'),
        ("1.5", "1.6"),
        ("z + LIMIT", "z - LIMIT"),
        ("deepen", "dip"),
    ],
)
def test_another_computation_is_another_core(old: str, new: str, core: Path) -> None:
    before = digest_sources("core")
    text = core.read_text()
    assert old in text
    core.write_text(text.replace(old, new))
    assert digest_sources("core") != before


@pytest.fixture
def core(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a source that is the core of this test."""
    path = tmp_path / "kernels.py"
    path.write_text(KERNEL)
    monkeypatch.setattr(digest, "sources", lambda *_: [path])
    return path
