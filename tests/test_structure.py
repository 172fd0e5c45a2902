"""The shape of the house: packages, layers, sizes, and the names on disk and on the wire."""

import ast
import re
import tomllib
from pathlib import Path

import grimp
import pytest
from fuzz.lines import GRAMMAR
from helpers.places import ROOT
from helpers.syntax import nodes_of

from trainer.boat.export.header import PUBLISHED_NAMES, record_members
from trainer.core.state import STATE
from trainer.core.vessel import COMPACT, VESSEL
from trainer.io.orders import sentences
from trainer.session.past.layout import LAYOUT
from trainer.session.stations.roles import EVENT_KINDS

PACKAGE = ROOT / "trainer"
PACKAGES = {path.parent.name for path in PACKAGE.glob("*/__init__.py")}
SOURCES = sorted(PACKAGE.rglob("*.py"))
MODULES = [path for path in SOURCES if path.name != "__init__.py"]
MAX_LINES = 500  # of a module that does not say why it is longer, as a linter would warn
REASONED = re.compile(r"^# long: \w.*$", re.MULTILINE)


def test_no_module_lies_beside_a_package_of_its_name() -> None:
    """It would be shadowed, in silence."""
    assert not [path for path in MODULES if path.with_suffix("").is_dir()]


def test_the_wheel_has_no_c_but_what_goes_out_with_an_exported_core() -> None:
    assert sorted(path.name for path in PACKAGE.rglob("*.[ch]")) == [
        "board.c",
        "component.c",
        "fmi2.c",
        "fmi3.c",
        "host.c",
        "unit.c",
    ]


def calls_of_the_core() -> dict[str, set[str]]:
    """Return what each function of the core calls by name."""
    found: dict[str, set[str]] = {}
    for path in sorted((PACKAGE / "core").rglob("*.py")):
        for each in nodes_of(path):
            if isinstance(each, ast.FunctionDef):
                called = [node.func for node in ast.walk(each) if isinstance(node, ast.Call)]
                found[each.name] = {name.id for name in called if isinstance(name, ast.Name)}
    return found


def test_the_block_diagram_says_who_calls_whom() -> None:
    text = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    diagram = text.partition("### Who calls whom")[2].split("```")[1].strip().splitlines()
    calls, above = calls_of_the_core(), {-1: ""}
    for line in diagram:
        name, level = line.split()[0], (len(line) - len(line.lstrip())) // 2
        assert name in calls
        if level:
            assert name in calls[above[level - 1]], f"{above[level - 1]} does not call {name}"
        above[level] = name
    assert len(diagram) == 21


def is_too_long(text: str) -> bool:
    """Return whether a module is long and has no comment `# long: why`."""
    return len(text.splitlines()) > MAX_LINES and not REASONED.search(text)


def test_a_long_module_says_why() -> None:
    assert not [path for path in SOURCES if is_too_long(path.read_text(encoding="utf-8"))]


def test_a_reason_silences_the_length_of_a_module() -> None:
    long = "x = 1\n" * (MAX_LINES + 1)

    assert is_too_long(long)
    assert is_too_long(f"# long:\n{long}")
    assert not is_too_long(f"# long: one table\n{long}")


def test_layers_name_packages_only() -> None:
    table = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    contracts = table["tool"]["importlinter"]["contracts"]
    layers, *_ = (each["layers"] for each in contracts if each["type"] == "layers")
    named = {name.strip() for layer in layers for name in layer.split("|")}
    assert named == {f"trainer.{package}" for package in PACKAGES}


def test_options_below_the_command_line_are_records() -> None:
    """A mapping would take any name, and give back anything."""
    functions = [
        (path, node)
        for path in SOURCES
        if PACKAGE / "cli" not in path.parents
        for node in nodes_of(path)
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
    assert set(EVENT_KINDS) == {
        *("order", "exercise", "moment", "time", "mark", "watch", "trouble", "station", "refused"),
        *("depth", "pilot", "plant", "crew", "marks", "lesson", "shown", "alert"),
    }


def test_the_kinds_of_sentences_and_of_facts_stay() -> None:
    assert set(sentences.SENTENCE_KINDS) == {"TRA", "TRN", "TRS", "TRE", "TRF"}
    assert set(sentences.FACTS) == {
        *("order", "mark", "back", "snapshot", "casualty", "depth", "collapse", "over", "left"),
        *("crew-order", "repeated", "wrong-repeat", "belayed", "wrong-way", "report", "has"),
        *("exercise", "range", "rate", "alert", "ack", "watch"),
        *(
            "branch",
            "exercise-over",
            "marks",
            "debrief",
            "debriefing",
            "next",
            "command",
            "asked",
            "ready",
        ),
        "chair",
        *("past", "plans", "planned", "debrief-page"),
        *("stations", "aboard", "said", "reason", "degree", "own-order", "own-alert", "alert-rank"),
        *("alerts", "alert-state"),
        *("step", "step-hint", "step-missed", "steps-undone"),
        *("shown", "attainable", "no-attainable", "no-room"),
    }


def test_the_places_of_a_recorded_state_stay() -> None:
    told = (ROOT / "tests/data/layout.txt").read_text(encoding="utf-8").split()
    assert list(LAYOUT) == told


@pytest.mark.parametrize("name", ["state", "vessel", "compact"])
def test_the_names_in_the_exported_header_stay(name: str) -> None:
    kind = {"state": STATE, "vessel": VESSEL, "compact": COMPACT}[name]
    told = (ROOT / f"tests/data/header-{name}.txt").read_text(encoding="utf-8").split()
    assert [PUBLISHED_NAMES.get(member, member) for member, _, _ in record_members(kind)] == told


def test_a_sweep_s_facts_stay_where_they_are() -> None:
    assert 'b"trainer.sweep"' in Path(PACKAGE / "analysis/sweep/sweep.py").read_text()
