"""The forms of a page: phone, tablet and desk are said once, and nothing else cuts the screen."""

import re
from pathlib import Path

import pytest

from trainer.web.modules import ASSETS_FOLDER, STYLESHEET_TAG
from trainer.web.pages import PAGES, Page, render
from trainer.web.styles import FORM_IN_CONDITION, NAMED_FORM, join_styles

STYLES = ASSETS_FOLDER / "css"
FORMS = {"upright", "on-side", "wide-side", "phone", "tablet", "desk"}
MEDIA = re.compile(r"@media ([^{]+) \{")
SHEETS = sorted(STYLES.glob("*.css"))


def cuts_of(sheet: str) -> list[str]:
    """Return conditions of a sheet that cut the screen by a number of their own."""
    return [each for each in MEDIA.findall(sheet) if re.search(r"\d|width|height", each)]


def test_one_file_has_the_cuts_of_the_screen_each_with_a_name() -> None:
    named = dict(NAMED_FORM.findall(text_of("forms.css")))
    assert {name.removeprefix("--") for name in named} == FORMS
    used = {name for path in SHEETS for name in FORM_IN_CONDITION.findall(path.read_text())}
    assert used == named.keys()


def text_of(name: str) -> str:
    return (STYLES / name).read_text(encoding="utf-8")


@pytest.mark.parametrize("path", SHEETS, ids=lambda path: path.stem)
def test_no_sheet_cuts_the_screen_by_itself(path: Path) -> None:
    sheet = path.read_text(encoding="utf-8")
    assert cuts_of(sheet) == []
    assert ("@custom-media" in sheet) == (path.name == "forms.css")


def test_a_cut_of_its_own_is_seen() -> None:
    assert cuts_of("@media (width < 820px) {\n}\n@media (--phone) {\n}") == ["(width < 820px)"]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name or "choice")
def test_a_browser_is_served_conditions_and_no_names(page: Page) -> None:
    sheet = join_styles(STYLESHEET_TAG.findall(render(page)))
    conditions = MEDIA.findall(sheet)
    assert any("width >= 1000px" in each for each in conditions)
    assert not [each for each in conditions if "(--" in each]
    assert "@custom-media" not in sheet


def test_a_form_that_nobody_named_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "a.css").write_text("@media (--watch) {\n}\n")
    monkeypatch.setattr("trainer.web.modules.ASSETS_FOLDER", tmp_path)
    with pytest.raises(KeyError, match="watch"):
        join_styles(["a.css"])
