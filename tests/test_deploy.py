"""The service and the container of a classroom's server are whole, and type what there is."""

import configparser
import json
import re
import shlex
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
from helpers.places import ROOT, environment
from helpers.shell import understand

from trainer.boat.machine_code import FORBIDDEN_TEXT
from trainer.classroom.fleet import END_TIMEOUT_S

DEPLOY = ROOT / "deploy"
UNIT = DEPLOY / "trainer-classroom.service"
RECIPE = DEPLOY / "conda" / "recipe.yaml"
CLASS_LINES = DEPLOY / "class.conf"
CONTAINERFILE = (DEPLOY / "Containerfile").read_text(encoding="utf-8")
PAGE = (ROOT / "docs" / "classroom.md").read_text(encoding="utf-8")


def service(path: Path = UNIT) -> configparser.SectionProxy:
    """Return the keys of the unit's service; of a key that is given twice, the last."""
    unit = configparser.ConfigParser(interpolation=None, strict=False)
    unit.optionxform = str  # type: ignore[assignment,method-assign]
    unit.read(path, encoding="utf-8")
    return unit["Service"]


def test_the_service_types_a_command_that_there_is() -> None:
    line = service()["ExecStart"].replace("${EXERCISE}", "periscope-depth")
    program, *words = shlex.split(line)

    assert program == "/opt/trainer/bin/trainer"
    assert understand(shlex.join(["trainer", *words])) == ["serve"]
    assert "`/opt/trainer`" in PAGE


def test_a_class_takes_the_place_of_the_boat_in_the_service() -> None:
    keys = service(CLASS_LINES)
    line = re.sub(r"\$\{\w+\}", "depth-changes", keys["ExecStart"])
    program, *words = shlex.split(line)
    text = CLASS_LINES.read_text(encoding="utf-8")

    assert program == "/opt/trainer/bin/trainer"
    assert understand(shlex.join(["trainer", *words])) == ["class"]
    assert re.findall("^ExecStart=(.?)", text, re.MULTILINE) == ["", "/"]  # the boat's is taken off
    assert float(keys["TimeoutStopSec"]) > END_TIMEOUT_S
    assert f"{UNIT.name}.d/{CLASS_LINES.name}" in PAGE
    for name in re.findall(r"\$\{(\w+)\}", text):
        assert f"{name}=" in PAGE


def test_the_service_allows_machine_code_and_a_real_time_priority() -> None:
    keys = service()

    assert keys["MemoryDenyWriteExecute"] == "no"
    assert "MemoryDenyWriteExecute=no" in FORBIDDEN_TEXT
    assert (keys["RestrictRealtime"], keys["LimitMEMLOCK"]) == ("no", "infinity")


def test_the_service_keeps_what_is_written_in_its_own_folders() -> None:
    keys = service()
    written = dict(word.split("=") for word in keys["Environment"].split())

    assert keys["DynamicUser"] == "yes"
    for name, folder in (
        *(("XDG_STATE_HOME", "%S/"), ("XDG_CACHE_HOME", "%C/"), ("XDG_RUNTIME_DIR", "%t/")),
    ):
        assert written[name] == folder + "trainer"
    assert {keys[f"{kind}Directory"] for kind in ("State", "Cache", "Runtime")} == {"trainer"}


def complaints(unit: Path) -> str:
    """Return what systemd says against a unit, "" also where it is not installed."""
    analyst = shutil.which("systemd-analyze")
    if analyst is None:
        return ""
    words = (analyst, "verify", str(unit))
    return subprocess.run(words, capture_output=True, text=True, check=False).stderr


@pytest.mark.process
def test_systemd_reads_the_service_without_a_complaint(tmp_path: Path) -> None:
    copy = tmp_path / UNIT.name
    text = UNIT.read_text(encoding="utf-8").replace("/opt/trainer/bin/trainer", sys.executable)
    copy.write_text(text, encoding="utf-8")

    assert UNIT.name not in complaints(copy)


def test_the_container_copies_what_there_is_and_runs_the_tested_python() -> None:
    copied = re.findall(r"^COPY (?!--)(.*) \S+$", CONTAINERFILE, re.MULTILINE)
    names = [name for line in copied for name in line.split()]
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    wheel = project["tool"]["hatch"]["build"]["targets"]["wheel"]
    workflow = (ROOT / ".github" / "workflows" / "ci.yml").read_text(encoding="utf-8")

    assert [name for name in names if not (ROOT / name).exists()] == []
    made_of = project["tool"]["hatch"]["metadata"]["hooks"]["fancy-pypi-readme"]["fragments"]
    assert {"pyproject.toml", *(each["path"] for each in made_of)} <= set(names)
    for part in made_of:  # or nothing can be installed
        text = (ROOT / part["path"]).read_text(encoding="utf-8")
        assert all(part.get(key, "") in text for key in ("start-at", "start-after", "end-before"))
    assert {*project["project"]["license-files"], *wheel["packages"]} <= set(names)
    assert set(wheel["force-include"]) <= set(names)
    assert set(re.findall(r"^FROM \S+/python:([\d.]+)-slim", CONTAINERFILE, re.MULTILINE)) == set(
        re.findall(r'python-version: "([\d.]+)"', workflow)
    )


def test_the_package_s_page_is_made_of_lines_that_are_there() -> None:
    """Without one of them nothing is built, and nobody can install."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    made_of = project["tool"]["hatch"]["metadata"]["hooks"]["fancy-pypi-readme"]["fragments"]
    marks = [
        (each["path"], mark) for each in made_of for key, mark in each.items() if key != "path"
    ]
    assert len(marks) == 6
    assert [(p, mark) for p, mark in marks if mark not in (ROOT / p).read_text("utf-8")] == []


def test_the_page_types_what_the_container_understands() -> None:
    (entry,) = re.findall(r"^ENTRYPOINT (.*)$", CONTAINERFILE, re.MULTILINE)
    lines = re.findall(r"^podman run .* trainer ((?:serve|class) .*)$", PAGE, re.MULTILINE)

    assert json.loads(entry) == ["trainer"]
    assert [understand(f"trainer {line}") for line in lines] == [["serve"], ["class"]]


def test_the_recipe_of_conda_asks_for_what_the_wheel_does() -> None:
    whole = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    project, recipe = whole["project"], RECIPE.read_text(encoding="utf-8")
    host, run = (
        re.findall(r"^    - (.+)$", part, re.MULTILINE)
        for part in recipe.partition("  host:")[2].partition("tests:")[0].split("  run:")
    )

    python = f"python {project['requires-python']}"
    asked = {re.sub(r"(?=[<>])", " ", need, count=1) for need in project["dependencies"]}
    built = {re.sub(r"(?=[<>])", " ", need, count=1) for need in whole["build-system"]["requires"]}
    assert set(run) == {python, *asked}
    assert set(host) == {python, "pip", *built}
    (name, entry) = next(iter(project["scripts"].items()))
    assert f"- {name} = {entry}" in recipe
    assert f"summary: {project['description']}" in recipe
    assert f"license: {project['license']}" in recipe


@pytest.mark.slow
@pytest.mark.process
def test_the_builder_of_conda_packages_reads_the_recipe() -> None:
    builder = pytest.importorskip("rattler_build")
    (variant,) = builder.Stage0Recipe.from_file(RECIPE).render()

    assert variant.recipe.package.name == "submarine-trainer"


@pytest.mark.slow
@pytest.mark.process
def test_without_shipped_code_it_is_made_at_the_first_start(tmp_path: Path) -> None:
    tree = tmp_path / "tree"
    ignored = shutil.ignore_patterns("*.o.gz", "__pycache__")
    shutil.copytree(ROOT / "trainer", tree / "trainer", ignore=ignored)
    shutil.copytree(ROOT / "configs", tree / "configs")
    told = subprocess.run(
        [sys.executable, *shlex.split("-m trainer run --headless --duration 10 --speed max")],
        cwd=tree,
        env=environment(PYTHONPATH=str(tree), XDG_CACHE_HOME=str(tmp_path)),
        capture_output=True,
        text=True,
        check=True,
    )

    assert "compiling the core for this machine, this once" in told.stderr
    assert "20 ticks" in told.stdout
