"""The pages' words: English and German whole, any other language by one file, lengths by choice."""

import json
import re
import subprocess
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import pytest
from helpers import node, wire
from helpers.browser import NAME_LINE, Look, hear_all
from helpers.lanes import sample_cases
from helpers.pages import Served
from helpers.waiting import PATIENCE
from playwright.sync_api import Browser, Page, expect
from soak.session_process import Caller

from trainer.config.boat.casualties import clause_of, load_casualties
from trainer.io import client
from trainer.web import words as words_module
from trainer.web.modules import ASSETS_FOLDER
from trainer.web.pages import (
    CLASS_PAGE,
    ENTRANCE_PAGE,
    MISSING_DEBRIEF,
    MISSING_PAGE,
    NOTHING_SHOWN_PAGE,
    PAGES,
    render,
)
from trainer.web.single_file import said_in_tab
from trainer.web.words import (
    LOCALE_FOLDER,
    OWN_NAME,
    READ_ATTRIBUTES,
    catalogues,
    said_in_page,
    written_in,
)

ODD = "ж"  # a letter of the made-up language
LACKING = "Depth"  # that its catalogue has not
# What is not said by the pages but by the session, or named after it, and the units.
SESSIONS = """#title, #exercise-title, #log, #said, #offers, #lessons, .rules td, #aboard,
  #completions, #mission, #briefing-text, #says, #broken, #ahead, #answer, .masthead, #marks,
  #exercise, #chosen-name, #exercise-body p, #exercise-body li, #language, #open-choices, #link,
  #drawer-body li"""
UNITS = {"m", "kn", "t", "s", "MPa", "ft", "x", "deg", "C"}
SHOWN = """(outside) => {
  const walker = document.createTreeWalker(document.documentElement, NodeFilter.SHOW_TEXT);
  const found = [];
  while (walker.nextNode()) {
    const within = walker.currentNode.parentElement;
    if (within.closest(`script, style, ${outside}`)) continue;
    found.push(walker.currentNode.data.trim());
  }
  for (const name of ["aria-label", "aria-valuetext", "placeholder", "title"]) {
    for (const each of document.querySelectorAll(`[${name}]`)) {
      if (!each.closest(outside)) found.push(each.getAttribute(name));
    }
  }
  return found.filter(Boolean);
}"""


def all_said() -> set[str]:
    """Return all that the pages say in English."""
    said = {OWN_NAME, *said_in_tab()}
    said |= {clause_of(each.description) for each in load_casualties().values()}
    for page in (
        *PAGES,
        ENTRANCE_PAGE,
        CLASS_PAGE,
        NOTHING_SHOWN_PAGE,
        MISSING_PAGE,
        MISSING_DEBRIEF,
    ):
        said |= said_in_page(render(page))
    return said


@pytest.mark.parametrize("language", sorted(catalogues()))
def test_every_word_of_the_pages_is_translated_and_no_entry_is_left_over(language: str) -> None:
    translated = set(catalogues()[language])

    assert not all_said() - translated
    assert not translated - all_said()


def test_the_pages_read_the_same_attributes_as_their_words_are_taken_from() -> None:
    script = (ASSETS_FOLDER / "js" / "words.js").read_text(encoding="utf-8")
    (listed,) = re.findall(r"const READ = \[(.*?)\];", script, re.DOTALL)

    assert set(re.findall(r'"([a-z-]+)"', listed)) == READ_ATTRIBUTES


def test_texts_and_read_attributes_are_words_and_figures_are_none() -> None:
    html = '<b title="Up" data-order="dive">Down <i>12 m</i></b><script>let it</script><p>a\n b'

    assert written_in(html) == {"Up", "Down", "a b"}


def test_a_page_holds_its_own_words_alone() -> None:
    helm, kiosk = (
        json.loads(re.findall(r'id="words">(.*?)</script>', render(page))[0])["de"]
        for page in PAGES
        if page.name in ("kiosk", "helm")
    )
    assert "Take the submarine down" in kiosk.keys() - helm.keys()
    assert "Rudder angle" in helm.keys() - kiosk.keys()


@pytest.mark.parametrize("name", [each.name for each in PAGES])
def test_no_two_parts_of_a_page_have_one_id(name: str) -> None:
    """A script that asks for an id is given the first, be it the page's words."""
    (html,) = (render(page) for page in PAGES if page.name == name)
    found = Counter(re.findall(r'<[^<>]*\bid="([^"]+)"', html))
    assert len(found) > 5
    assert [each for each, count in found.items() if count > 1] == []


def shown_untranslated(sources: dict[str, str]) -> list[list[str]]:
    """Return words that scripts show without having them translated."""
    tool = Path(__file__).with_name("visible.mjs")
    done = subprocess.run(
        ["node", str(tool), str(node.modules())],
        input=json.dumps(sources),
        capture_output=True,
        text=True,
        check=True,
    )
    found: list[list[str]] = json.loads(done.stdout)
    return found


FAULTS = (
    'write(one("#a"), "Depth");',
    "write(one('#a'), `${depth} below`);",
    'html("p", {}, on ? say("on") : "off");',
    'html("b", { "aria-label": "Depth" });',
    'node.setAttribute("aria-label", name ?? "Chart");',
    'node.textContent = "Depth";',
    'text([1, 2], "label", "metres");',
)


@pytest.mark.process
def test_no_script_shows_a_word_that_is_not_said() -> None:
    folder = ASSETS_FOLDER / "js"
    sources = {
        path.relative_to(folder).as_posix(): path.read_text("utf-8")
        for path in folder.rglob("*.js")
    }
    assert not shown_untranslated(sources), 'write say("...") about it (words.js)'
    assert {name for name, _ in shown_untranslated({fault: fault for fault in FAULTS})} == {*FAULTS}


# A made-up language, by one file


def odd_catalogue() -> str:
    """Return a catalogue that has another letter for every letter, and lacks one word."""
    entries = []
    for words in sorted(all_said() - {LACKING}):
        odd = "".join(
            part if part.startswith("{") else re.sub(r"[A-Za-z]", ODD, part)
            for part in re.split(r"(\{\d\})", words)
        )
        keyed = json.dumps(words, ensure_ascii=False)
        entries.append(f"msgid {keyed}\nmsgstr {json.dumps(odd, ensure_ascii=False)}\n")
    return "\n".join(entries)


@pytest.fixture(scope="module")
def odd(shared: Served, tmp_path_factory: pytest.TempPathFactory) -> Iterator[wire.Pages]:
    """Return pages of the session, in whose folder of languages a third file has been laid."""
    folder = tmp_path_factory.mktemp("locale")
    for path in LOCALE_FOLDER.glob("*.po"):
        (folder / path.name).write_bytes(path.read_bytes())
    (folder / "xx.po").write_text(odd_catalogue(), encoding="utf-8")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(words_module, "LOCALE_FOLDER", folder)
        with wire.pages(reach=lambda: client.reach(str(shared.socket))) as served:
            yield served


def is_english(text: str) -> bool:
    """Return whether a shown text has words that the odd language would not have."""
    return bool(set(re.findall(r"[A-Za-z]+", text)) - UNITS) and LACKING not in text


@pytest.mark.process
@pytest.mark.parametrize(
    "name", sample_cases([each.name for each in PAGES], "instructor", "trainee", "kiosk", "helm")
)
def test_a_third_language_is_one_file_and_no_english_is_left(
    odd: wire.Pages, browser: Browser, name: str
) -> None:
    with browser.new_context(locale="xx") as context:
        page = context.new_page()
        page.add_init_script(NAME_LINE)
        page.goto(f"http://127.0.0.1:{odd.port}/{name}?lang=xx")
        expect(page.locator("html")).to_have_attribute("lang", "xx")
        if name != "kiosk":
            expect(page.locator("#state")).not_to_have_attribute("data-state", "connecting")
        for key in ("#open-exercise", "#open-drawer"):
            if page.locator(key).count():
                page.locator(key).click()
        hear_all(page)
        for _ in range(20):  # what is being drawn on a busy machine is drawn at last
            shown = page.evaluate(SHOWN, SESSIONS)
            english = set(filter(is_english, shown))
            if not english:
                break
            page.wait_for_timeout(200)

    assert any(ODD in text for text in shown)
    assert not english


@pytest.mark.process
def test_a_word_that_a_catalogue_lacks_is_english(odd: wire.Pages, browser: Browser) -> None:
    with browser.new_context() as context:
        page = context.new_page()
        page.goto(f"http://127.0.0.1:{odd.port}/planes?lang=xx")
        expect(page.locator("#h-depth")).to_contain_text(LACKING)
        expect(page.locator("#h-stern")).to_contain_text(f"{5 * ODD} {6 * ODD}")


# Chosen on the page, and kept


@pytest.mark.process
def test_language_and_units_are_chosen_on_the_page_and_kept(
    shared: Served, instructor: Caller, look: Look
) -> None:
    page = look(shared, "pilot", query="?lang=en&units=m")
    expect(page.locator("#state")).to_have_text("FROZEN")
    metres = digits_of(page)
    see_decimals(page, ".")

    page.locator("#open-choices").click()
    page.locator("#language").select_option("de")
    expect(page.locator("#state")).to_have_text("ANGEHALTEN")
    expect(page.locator("#h-depth")).to_contain_text("Tiefe")
    see_decimals(page, ",")
    assert instructor.ask("order depth 70.5")[0]
    expect(page.locator("#ordered")).to_contain_text("Tiefe 70,5 m")
    knob = page.locator("order-lever[name=stern] [role=slider]")
    knob.press("ArrowUp")  # whose order is in the grammar's words in any language
    expect(page.locator("#answer")).to_contain_text("stern rise 1")
    expect(knob).to_have_attribute("aria-valuetext", "1 oben")
    page.locator("#open-choices").click()
    page.locator("#units").select_option("ft")
    expect(page.locator("depth-gauge .label")).to_have_text("Fuß")
    assert digits_of(page) == pytest.approx(metres / 0.3048, abs=1.0)

    page.goto(f"{shared.url}/wall")
    expect(page.locator("#state")).to_have_text("ANGEHALTEN")
    expect(page.locator("#depth-unit")).to_have_text("ft")
    expect(page.locator("#depth")).to_have_text(f"{metres / 0.3048:.0f}")
    page.goto(f"{shared.url}/instructor")
    expect(page.locator("#truth [data-of=depth] th")).to_have_text("Tiefe, ft")


def see_decimals(page: Page, mark: str) -> None:
    """See that figures have the decimal mark of the language, and values for machines a point."""
    for place in ("depth-gauge", "pitch-gauge", "angle-dial#rudder"):
        digits = page.locator(f"{place} .digits")
        expect(digits).to_have_text(re.compile(rf"^\d+\{mark}\d\D*$"))  # and which way
    expect(page.locator("#speed .head b")).to_have_text(re.compile(rf"^\d+\{mark}\d kn$"))
    expect(page.locator("[role=slider]").first).to_have_attribute(
        "aria-valuenow", re.compile(r"^-?\d+$")
    )


def digits_of(page: Page) -> float:
    """Return what the depth gauge shows."""
    digits = page.locator("depth-gauge .digits")
    expect(digits).not_to_be_empty(timeout=1000.0 * PATIENCE)
    return float(digits.text_content() or "")


@pytest.mark.process
def test_the_language_is_the_browsers_own_until_one_is_chosen(shared: Served, look: Look) -> None:
    page = look(shared, "helm", locale="de-AT")
    expect(page.locator("html")).to_have_attribute("lang", "de")
    expect(page.locator("#h-rudder")).to_contain_text("Seitenruder")
    expect(look(shared, "helm", locale="fr").locator("html")).to_have_attribute("lang", "en")


@pytest.mark.process
def test_an_address_without_a_page_says_so_in_the_browsers_language(
    shared: Served, browser: Browser
) -> None:
    with browser.new_context(locale="de-DE") as context:
        page = context.new_page()
        page.goto(f"{shared.url}/hlem")
        expect(page.locator("h1")).to_have_text("Diese Seite gibt es nicht")
