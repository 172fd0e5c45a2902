"""The digest of a kernel's sources: all that computes counts, in whatever room; words do not."""

import ast
import io
import pkgutil
import re
import shutil
import tokenize
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from types import ModuleType

import pytest

import trainer
from trainer.core import digest
from trainer.core.digest import (
    PACKAGE_FOLDER,
    digest_sources,
    imported_sources,
    read_source,
    without_words,
)
from trainer.core.kernel import Kernel

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
        if (
            isinstance(node, ast.Module | ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef)
            and node.body
        ):
            first = node.body[0]
            if isinstance(first, ast.Expr) and isinstance(first.value, ast.Constant):
                gone.update(range(first.lineno - 1, first.end_lineno or first.lineno))
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        if token.type == tokenize.COMMENT:
            row, column = token.start
            lines[row - 1] = lines[row - 1][:column].rstrip()
    return [line.rstrip() for i, line in enumerate(lines) if i not in gone and line.strip()]


def imports_at_the_head(path: Path) -> set[str]:
    """Return what a source imports of the package, as Python itself tells it."""
    return {
        name
        for node in ast.parse(read_source(path)).body
        if isinstance(node, ast.ImportFrom) and str(node.module).split(".")[0] == "trainer"
        for each in node.names
        for name in (f"{node.module}.{each.name}", str(node.module))
    }


def kernel_modules() -> Iterator[ModuleType]:
    """Yield each module of the package that has a kernel of its own, in whatever room."""
    for found in pkgutil.walk_packages(trainer.__path__, "trainer."):
        if found.name == "trainer.__main__":
            continue
        try:
            module = import_module(found.name)
        except ModuleNotFoundError as missing:
            if str(missing.name).startswith("trainer"):
                raise
            continue  # a library that this machine is without
        kernels = [each for each in vars(module).values() if isinstance(each, Kernel)]
        if any(each.__module__ == module.__name__ for each in kernels):
            yield module


@pytest.fixture(scope="module")
def with_kernels() -> list[ModuleType]:
    return list(kernel_modules())


@pytest.fixture
def copied(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """Return a copy of the package, whose sources are read."""
    shutil.copytree(
        PACKAGE_FOLDER, tmp_path / "trainer", ignore=shutil.ignore_patterns("__pycache__")
    )
    monkeypatch.setattr(digest, "PACKAGE_FOLDER", tmp_path / "trainer")
    digest._source_of.cache_clear()  # noqa: SLF001  names are of the other folder
    yield tmp_path / "trainer"
    digest._source_of.cache_clear()  # noqa: SLF001


def room_of(path: Path) -> str:
    return path.relative_to(PACKAGE_FOLDER).parts[0]


@pytest.mark.long
def test_words_and_imports_are_found_as_python_finds_them(with_kernels: list[ModuleType]) -> None:
    wrong = []
    counted = imported_sources(*(Path(str(each.__file__)) for each in with_kernels))
    for path in set(counted) - {digest.DIGEST_SOURCE}:
        source = read_source(path)
        found = [line.rstrip() for line in without_words(source).splitlines() if line.strip()]
        if found != lines_that_compute(source):
            wrong.append(path)
        named = {digest._source_of(name) for name in imports_at_the_head(path)}  # noqa: SLF001
        modules = {each for each in named if each and each.name != "__init__.py"}
        if not modules <= set(imported_sources(path)):
            wrong.append(path)
    assert wrong == []


def test_no_kernel_lies_outside_what_its_folder_is_named_by(with_kernels: list[ModuleType]) -> None:
    assert {room_of(Path(str(each.__file__))) for each in with_kernels} >= {
        *("analysis", "api", "boat", "core", "debrief", "identify")
    }
    for module in with_kernels:
        counted = imported_sources(Path(str(module.__file__)))
        for each in vars(module).values():
            owner = getattr(each, "__module__", None)  # of a kernel that is called, a class
            if isinstance(owner, str) and owner.startswith("trainer."):
                assert Path(str(import_module(owner).__file__)) in counted, (module, each)


def test_a_constant_of_any_room_names_another_folder(
    with_kernels: list[ModuleType], copied: Path
) -> None:
    edited = set()
    for module in with_kernels:
        path = copied / Path(str(module.__file__)).relative_to(PACKAGE_FOLDER)
        for source in imported_sources(path):
            room = source.relative_to(copied).parts[0]
            text = read_source(source)
            constant = re.search(r"^[A-Z_]+(?:: Final)? = [0-9][0-9.e-]*", text, re.MULTILINE)
            if constant is None or (path, room) in edited:
                continue
            edited.add((path, room))
            before = digest_sources(imported_sources(path))
            source.write_text(text.replace(constant[0], f"{constant[0]}1", 1))
            assert digest_sources(imported_sources(path)) != before, (path, source)
            source.write_text(text)
    assert {path for path, _ in edited} >= {
        copied / Path(str(each.__file__)).relative_to(PACKAGE_FOLDER)
        for each in with_kernels
        if each.__name__.startswith(("trainer.debrief", "trainer.identify.boat", "trainer.api"))
    }


def test_the_core_is_computed_by_nothing_but_itself_and_units() -> None:
    folder = PACKAGE_FOLDER / "core"
    assert set(imported_sources(folder)) == {PACKAGE_FOLDER / "units.py", *folder.rglob("*.py")}


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
    before = digest_sources([core])
    text = core.read_text()
    core.write_text(text.replace(old, new))
    assert digest_sources([core]) == before


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
    before = digest_sources([core])
    text = core.read_text()
    assert old in text
    core.write_text(text.replace(old, new))
    assert digest_sources([core]) != before


@pytest.fixture
def core(tmp_path: Path) -> Path:
    """Return a source that is the core of this test."""
    path = tmp_path / "kernels.py"
    path.write_text(KERNEL)
    return path
