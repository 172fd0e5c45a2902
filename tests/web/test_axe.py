"""Every page is one that people with other eyes, ears and hands can use: axe-core finds nothing."""

from collections.abc import Callable

import pytest
from helpers import node
from helpers.lanes import sample_cases
from helpers.pages import PALETTES, Served
from helpers.waiting import await_that
from playwright.sync_api import Page, expect

from trainer.web.pages import PAGES

Look = Callable[..., Page]
RUN = """async () => (await axe.run(document, { resultTypes: ["violations"] })).violations
  .map(({ id, nodes }) => `${id}: ${nodes.map((each) => each.target.join(" ")).join(", ")}`)"""


@pytest.fixture(scope="session")
def axe() -> str:
    """Return the script of axe-core."""
    return (node.modules() / "axe-core" / "axe.min.js").read_text(encoding="utf-8")


@pytest.mark.parametrize("size", sample_cases(["phone", "laptop"], "phone"))
@pytest.mark.parametrize("palette", sample_cases(PALETTES, "dusk"))
@pytest.mark.parametrize("name", [page.name for page in PAGES], ids=lambda name: name or "first")
def test_a_page_has_no_barrier(
    shared: Served, look: Look, axe: str, name: str, palette: str, size: str
) -> None:
    page = look(shared, name, size, f"?palette={palette}")
    expect(page.locator("[data-state=connecting]")).to_have_count(0)

    page.evaluate(axe)  # as a tool of the browser would: no page may load it

    await_that(lambda: page.evaluate(RUN) == [], lambda: page.evaluate(RUN))  # once it is drawn
