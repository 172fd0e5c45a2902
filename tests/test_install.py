"""The wheel, installed into an empty environment as strangers do: its page, lines and Pythons."""

import email
import os
import re
import subprocess
import sys
import tempfile
import tomllib
import zipfile
from email.message import Message
from pathlib import Path
from typing import Final

import pytest
from helpers.address import project_urls
from helpers.places import ROOT
from helpers.shell import typed
from release import run_in

pytestmark = [pytest.mark.slow, pytest.mark.process]
NAME: Final = "submarine-trainer"
ROW: Final = re.compile(r"^\| ([^|`]+) \| (`.*) \|$", re.MULTILINE)
SAIL: Final = "depth 70\nquit\n"
LINK: Final = re.compile(r"\]\(([^)]*)\)")
OWN_FOLDERS: Final = ("UV_TOOL_DIR", "PIPX_HOME", "XDG_STATE_HOME")
FLOWN: Final = (
    "trainer run --headless --speed max --duration 5m --sea sea-state-5 --seed 3 --csv out.csv"
)


def groups(*names: str) -> list[str]:
    """Return what the group of the ways in names, of these libraries."""
    table = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    return [each for each in table["dependency-groups"]["doors"] if each.startswith(names)]


@pytest.fixture(scope="module")
def tools(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of uv, pipx and what builds, from the package index."""
    folder = tmp_path_factory.mktemp("tools")
    table = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    wanted = [*groups("uv", "pipx"), *table["dependency-groups"]["release"]]
    run_in(ROOT, sys.executable, "-m", "venv", str(folder))
    run_in(ROOT, str(folder / "bin" / "pip"), "install", "--quiet", *wanted)
    return folder / "bin"


@pytest.fixture(scope="module")
def built(tools: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of wheel and sdist of what lies here."""
    folder = tmp_path_factory.mktemp("built")
    run_in(ROOT, str(tools / "python"), "-m", "build", "--outdir", str(folder), ".")
    return folder


@pytest.fixture(scope="module")
def wheel(built: Path) -> Path:
    (wheel,) = built.glob("*.whl")
    return wheel


@pytest.fixture(scope="module")
def page(wheel: Path) -> Message:
    """Return what the package's page is made of."""
    with zipfile.ZipFile(wheel) as files:
        (name,) = (each for each in files.namelist() if each.endswith(".dist-info/METADATA"))
        return email.message_from_string(files.read(name).decode())


def install_lines() -> dict[str, str]:
    """Return what the page of installation types, by what its reader has."""
    text = (ROOT / "docs" / "install.md").read_text(encoding="utf-8")
    part = text.partition("begins -->")[2].partition("<!-- and ends")[0]
    return {has: " && ".join(re.findall("`([^`]*)`", cell)) for has, cell in ROW.findall(part)}


def python_versions() -> list[str]:
    """Return the versions of Python that the project says it runs on."""
    table = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    named = "\n".join(table["classifiers"])
    return re.findall(r"^Programming Language :: Python :: (\d\.\d+)$", named, re.MULTILINE)


def empty_environment(folder: Path, tools: Path) -> dict[str, str]:
    """Return the environment of somebody who has Python, uv and pipx, and no trainer."""
    pythons = Path(sys.executable).resolve().parent
    own = {name: str(folder / name) for name in OWN_FOLDERS}
    own |= {"UV_TOOL_BIN_DIR": str(folder / "bin"), "PIPX_BIN_DIR": str(folder / "bin")}
    places = (str(folder / "bin"), str(tools), str(pythons), *os.environ["PATH"].split(os.pathsep))
    path = os.pathsep.join(each for each in places if not Path(each, "trainer").exists())
    kept = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}
    kept.pop("VIRTUAL_ENV", None)
    return kept | own | {"PATH": path, "BROWSER": "true"}


def type_line(line: str, folder: Path, tools: Path) -> str:
    """Type a line into a shell in an empty folder, then sail; return what it wrote."""
    with tempfile.TemporaryDirectory() as running:  # short, as the address of a socket must be
        done = subprocess.run(
            ["sh", "-ec", line],
            cwd=folder,
            env=empty_environment(folder, tools) | {"XDG_RUNTIME_DIR": running},
            input=SAIL,
            capture_output=True,
            text=True,
            timeout=300.0,
            check=False,
        )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout + done.stderr


@pytest.mark.parametrize("has", install_lines())
def test_a_line_of_the_page_installs_a_boat_that_sails(
    has: str, wheel: Path, tools: Path, tmp_path: Path
) -> None:
    line = install_lines()[has].replace(NAME, str(wheel))
    in_browser = line.endswith("--web")  # orders are given there, and none are read here

    said = type_line(f"{line} --duration 2" if in_browser else line, tmp_path, tools)

    assert ("http://127.0.0.1:" in said) == in_browser
    assert ("keeping depth 70 m" in said) != in_browser


@pytest.mark.parametrize("version", python_versions())
def test_each_python_that_is_named_flies_the_same_bits(
    version: str, wheel: Path, tools: Path, tmp_path: Path
) -> None:
    made = f"uv venv --quiet --no-python-downloads --python {version} own"
    if subprocess.run(
        ["sh", "-ec", made], cwd=tmp_path, env=empty_environment(tmp_path, tools), check=False
    ).returncode:
        pytest.skip(f"no Python {version} here: uv python install {version}")
    install = f"uv pip install --quiet --python own/bin/python {wheel}"

    said = type_line(f"{install} && own/bin/trainer run && own/bin/{FLOWN}", tmp_path, tools)
    here = typed(FLOWN.replace("out.csv", "here.csv"), tmp_path, "")

    assert "keeping depth 70 m" in said
    assert here.returncode == 0, here.stderr
    assert (tmp_path / "out.csv").read_bytes() == (tmp_path / "here.csv").read_bytes()


def test_the_page_of_the_package_leads_everywhere_from_everywhere(page: Message) -> None:
    text, source = str(page.get_payload()), project_urls()["Source"]
    links = LINK.findall(text)
    inside = f"{source}/blob/v{page['Version']}/"
    raw = inside.replace("github.com", "raw.githubusercontent.com").replace("/blob", "")
    files = [each.removeprefix(inside).removeprefix(raw) for each in links]

    assert len(links) > 3
    assert [each for each in links if not each.startswith((inside, raw))] == []
    assert [each for each in files if not (ROOT / each).is_file()] == []
    assert f"{raw}docs/images/session.png" in links


def test_the_page_of_the_package_has_each_line_that_installs_it(page: Message) -> None:
    text = str(page.get_payload())

    for line in install_lines().values():
        assert all(f"`{part}`" in text for part in line.split(" && ")[-1:])
    assert "pip install --quiet ." not in text
    assert "'.[web]'" not in text
    assert "# set up" not in text
    assert text.rstrip().endswith("MIT licence.")
    assert {line.partition(", ")[0] for line in page.get_all("Project-URL", [])} == set(
        project_urls()
    )


def test_twine_finds_no_fault_in_the_files(built: Path, tools: Path) -> None:
    files = [str(path) for path in sorted(built.iterdir())]

    said = run_in(ROOT, str(tools / "python"), "-m", "twine", "check", "--strict", *files)

    assert said.count("PASSED") == len(files) == 2
