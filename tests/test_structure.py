"""The shape of the house: packages, layers, sizes, and the names on disk and on the wire."""

import ast
import statistics
import tomllib
from pathlib import Path

import grimp
import pytest
from fuzz.lines import GRAMMAR
from helpers.places import ROOT

from trainer.boat.export.header import PUBLISHED, members
from trainer.core.state import STATE
from trainer.core.vessel import COMPACT, VESSEL
from trainer.io.orders import sentences
from trainer.session.layout import LAYOUT
from trainer.session.stations.roles import KINDS

PACKAGE = ROOT / "trainer"
PACKAGES = {
    *(
        "core",
        "io",
        "config",
        "boat",
        "session",
        "console",
        "web",
        "analysis",
        "debrief",
        "report",
        "identify",
        "cli",
    ),
}
FILES = {"__init__.py", "__main__.py", "units.py"}
SOURCES = sorted(PACKAGE.rglob("*.py"))
MODULES = [path for path in SOURCES if path.name != "__init__.py"]


def test_the_house_has_twelve_packages_and_three_files() -> None:
    assert {each.parent.name for each in PACKAGE.glob("*/__init__.py")} == PACKAGES
    assert {each.name for each in PACKAGE.glob("*.py")} == FILES


def test_no_module_lies_beside_a_package_of_its_name() -> None:
    """It would be shadowed, in silence."""
    assert not [path for path in MODULES if path.with_suffix("").is_dir()]


def test_the_wheel_has_no_c_but_the_host_of_an_exported_core() -> None:
    assert [path.name for path in PACKAGE.rglob("*.[ch]")] == ["host.c"]


def test_modules_are_short() -> None:
    longest = max(SOURCES, key=lambda path: len(path.read_text(encoding="utf-8").splitlines()))
    assert len(longest.read_text(encoding="utf-8").splitlines()) <= 500, longest


def test_functions_are_short() -> None:
    sizes = sorted(
        node.end_lineno - node.lineno + 1
        for path in SOURCES
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.FunctionDef) and node.end_lineno
    )
    assert statistics.median(sizes) <= 8
    assert sizes[int(0.9 * len(sizes))] <= 20


def test_layers_name_packages_only() -> None:
    table = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    contracts = table["tool"]["importlinter"]["contracts"]
    assert len(contracts) == 5
    layers, *_ = (each["layers"] for each in contracts if each["type"] == "layers")
    assert len(layers) <= 10
    named = {name.strip() for layer in layers for name in layer.split("|")}
    assert named == {f"trainer.{package}" for package in PACKAGES}


def test_options_below_the_command_line_are_records() -> None:
    """A mapping would take any name, and give back anything."""
    functions = [
        (path, node)
        for path in SOURCES
        if path.parent != PACKAGE / "cli"
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.FunctionDef)
    ]
    kinds = [
        (path.name, node.name, ast.unparse(each.annotation))
        for path, node in functions
        for each in (*node.args.args, *node.args.kwonlyargs)
        if each.arg == "options" and each.annotation
    ]
    assert kinds
    assert not [one for one in kinds if one[2].startswith(("dict", "Mapping", "Any"))]


def test_no_modules_import_each_other_in_a_circle() -> None:
    graph = grimp.build_graph("trainer", include_external_packages=False, cache_dir=None)
    edges = {name: graph.find_modules_directly_imported_by(name) for name in graph.modules}
    edges["trainer"] = set()  # the Python face, whose modules are imported when it is used
    done: set[str] = set()

    def follow(name: str, way: list[str]) -> None:
        assert name not in way, " -> ".join([*way[way.index(name) :], name])
        if name in done:
            return
        for other in edges[name]:
            follow(other, [*way, name])
        done.add(name)

    for name in sorted(edges):
        follow(name, [])


def watched() -> tuple[str, ...]:
    """Return what the fuzzer's process watches; it cannot be imported without atheris."""
    tree = ast.parse((ROOT / "tests/fuzz/child.py").read_text(encoding="utf-8"))
    (found,) = (
        node.value
        for node in tree.body
        if isinstance(node, ast.AnnAssign) and ast.unparse(node.target) == "COMPILED"
    )
    assert found
    return ast.literal_eval(found)  # type: ignore[no-any-return]


@pytest.mark.parametrize("prefix", [*watched(), *GRAMMAR[1:]])
def test_what_a_fuzzer_watches_or_spares_is_there(prefix: str) -> None:
    """A wrong prefix would match nothing, in silence."""
    path = ROOT.joinpath(*prefix.split("."))
    assert path.is_dir() or path.with_suffix(".py").is_file()


# Names on disk and on the wire, which outlive the names in the code


def test_the_kinds_of_events_stay() -> None:
    assert set(KINDS) == {
        *("order", "exercise", "moment", "time", "mark", "watch", "trouble", "station", "refused"),
        *("depth", "pilot", "crew", "marks"),
    }


def test_the_kinds_of_sentences_and_of_facts_stay() -> None:
    assert set(sentences.KINDS) == {"TRA", "TRN", "TRS", "TRE", "TRF"}
    assert set(sentences.FACTS) == {
        *("order", "mark", "back", "snapshot", "casualty", "depth", "collapse", "over", "left"),
        *("crew-order", "repeated", "wrong-repeat", "belayed", "wrong-way", "report"),
        *("exercise", "range", "rate", "alert", "ack"),
        *("branch", "exercise-over", "marks", "debrief", "next", "command", "asked", "ready"),
        *("past", "compiled", "plans", "planned", "debrief-page"),
    }


def test_the_places_of_a_recorded_state_stay() -> None:
    told = (ROOT / "tests/data/layout.txt").read_text(encoding="utf-8").split()
    assert list(LAYOUT) == told


@pytest.mark.parametrize("name", ["state", "vessel", "compact"])
def test_the_names_in_the_exported_header_stay(name: str) -> None:
    kind = {"state": STATE, "vessel": VESSEL, "compact": COMPACT}[name]
    told = (ROOT / f"tests/data/header-{name}.txt").read_text(encoding="utf-8").split()
    assert [PUBLISHED.get(member, member) for member, _, _ in members(kind)] == told


def test_a_sweep_s_facts_stay_where_they_are() -> None:
    assert 'b"trainer.sweep"' in Path(PACKAGE / "analysis/sweep/results.py").read_text()
