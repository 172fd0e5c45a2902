"""What others cite, index and archive agrees with the project; figures are where they are from."""

import json
import re
import tomllib
from pathlib import Path
from typing import Any

import pytest
from helpers.address import WRITTEN_IN, project_urls, renewed
from helpers.places import ROOT
from release import CHANGELOG, DAY_LINES, VERSION_LINES, day_in, version_in

from trainer.config.files import shipped_names

DOCS = ROOT / "docs"
ELSEWHERE = "https://github.com/someone/some-name"
# of a table in the preprint: what, its figure, the page that it is from
FIGURE_ROW = re.compile(
    r"^\| ([^|]+) \| ([^|]+) \| \[[^]]+\]\(([\w-]+\.md)[^)]*\) \|$", re.MULTILINE
)


def text_of(path: str) -> str:
    return (ROOT / path).read_text(encoding="utf-8")


def project() -> dict[str, Any]:
    return dict(tomllib.loads(text_of("pyproject.toml"))["project"])


def citation(key: str) -> str:
    """Return the value of a key of CITATION.cff's own level."""
    (found,) = re.findall(rf"^{key}: (.*)$", text_of("CITATION.cff"), re.MULTILINE)
    return str(found).strip('"')


@pytest.mark.parametrize("file", WRITTEN_IN)
def test_an_address_of_the_project_follows_from_the_one_line(file: str) -> None:
    text, source = text_of(file), project_urls()["Source"]

    assert source in text
    assert renewed(text, source) == text, "type `python -m helpers.address` in tests/"


def test_another_address_is_written_everywhere_by_its_one_line() -> None:
    for file in WRITTEN_IN:
        text = renewed(text_of(file), ELSEWHERE)

        assert ELSEWHERE in text
        assert project_urls()["Source"] not in text
    assert "https://someone.github.io/some-name/" in renewed(text_of("codemeta.json"), ELSEWHERE)


def test_an_address_at_another_host_is_refused_with_its_form() -> None:
    with pytest.raises(ValueError, match=r"must be https://github\.com/OWNER/NAME"):
        renewed("", "https://example.org/trainer")


def test_the_package_leads_to_its_pages() -> None:
    urls = project_urls()

    assert set(urls) == {"Source", "Homepage", "Documentation", "Changelog", "Issues"}
    file = urls["Changelog"].removeprefix(f"{urls['Source']}/blob/main/")
    assert (ROOT / file).is_file()
    page = urls["Documentation"].removeprefix(urls["Homepage"])
    assert f'"{page.replace(".html", ".md")}"' in text_of("tests/site_pages.py")


def test_what_is_archived_and_indexed_says_what_the_project_says() -> None:
    said, meta, zenodo = (
        project(),
        *map(json.loads, map(text_of, ("codemeta.json", ".zenodo.json"))),
    )
    (author,) = said["authors"]

    assert {author["name"]} == {
        meta["author"][0]["name"],
        zenodo["creators"][0]["name"],
        *re.findall(r"^authors:\n  - name: (.*)$", text_of("CITATION.cff"), re.MULTILINE),
        *re.findall(r"^site_author: (.*)$", text_of("mkdocs.yml"), re.MULTILINE),
    }
    assert said["description"] == meta["description"] == zenodo["description"]
    assert said["keywords"] == meta["keywords"] == zenodo["keywords"]
    assert said["license"] == zenodo["license"] == Path(meta["license"]).name
    assert said["name"] == meta["identifier"]
    assert zenodo["title"] == citation("title")
    assert citation("url") == meta["url"] == project_urls()["Homepage"]


def test_version_and_day_of_every_file_are_those_of_the_last_release() -> None:
    (version, day), *_ = re.findall(r"^## ([\d.]+) - ([\d-]+)$", text_of(CHANGELOG), re.MULTILINE)

    assert {version_in(ROOT, file) for file in VERSION_LINES} == {version}
    assert {day_in(ROOT, file) for file in DAY_LINES} == {day}


def test_a_figure_of_the_preprint_stands_on_the_page_that_it_is_from() -> None:
    rows = FIGURE_ROW.findall(text_of("docs/paper.md"))
    pages = {page: " ".join(text_of(f"docs/{page}").split()) for _, _, page in rows}

    assert len(rows) > 8
    assert [row for row in rows if row[1].replace("\\", "") not in pages[row[2]]] == []


def test_the_preprint_is_two_pages() -> None:
    words = len(text_of("docs/paper.md").split())

    assert 700 < words < 1100  # of two columns


def test_a_teacher_s_exercises_are_there() -> None:
    names = set(shipped_names("exercises"))
    said = re.findall(
        r"`(?:trainer run |trainer class )?([a-z]+(?:-[a-z0-9]+)+)[ `]", text_of("docs/teachers.md")
    )
    flown = [each for each in said if not each.startswith(("turning", "depth-gauge"))]

    assert len(flown) > 6
    assert sorted(set(flown) - names) == []


def test_a_development_container_sails_when_it_is_opened() -> None:
    container = json.loads(text_of(".devcontainer/devcontainer.json"))
    begin = container["postAttachCommand"].removeprefix(".venv/bin/")
    (port,) = container["forwardPorts"]

    assert f":{port}/" in text_of("docs/browser.md")
    assert f"\n{begin}\n" in text_of("docs/browser.md")  # where a test types it
    assert container["image"].endswith(f":{project()['requires-python'].removeprefix('>=')}")
