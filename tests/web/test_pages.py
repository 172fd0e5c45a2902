"""Pages in a real browser: they show what the session says, and ask nowhere else."""

import re

import pytest
from helpers.browser import Look, Serve
from helpers.hands import WAYS, work
from helpers.pages import IN_SHORT, Served
from playwright.sync_api import Browser, Page, expect

# The exercises, and the stations that they want before all others.
WANTED = {
    "stern-plane-jam": ["helm", "planes", "pilot"],
    "steady-course": ["helm"],
    "visitor-dive": ["kiosk"],
}


def test_the_first_page_tells_what_is_sailed_and_who_is_where(serve: Serve, look: Look) -> None:
    session = serve("stern-plane-jam")
    page = look(session)

    expect(page.locator("#title")).to_have_text("Passage, fast and deep")
    expect(page.locator("#time")).to_have_text("00:00 / 10:00")
    expect(page.locator("#says")).to_have_text("It has not begun yet.")
    expect(page.locator("nav small")).to_have_text(["free"] * 12)
    see_wanted(page, WANTED["stern-plane-jam"])
    wall, helm, instructor = look(session, "wall"), session.attach("helm"), session.attach()
    session.attach("helm")
    expect(wall.locator("#state")).to_have_text("FROZEN")
    counts = {"wall": 1, "helm": 2, "instructor": 1}
    for name in ("instructor", "helm", "planes", "observer", "wall", "kiosk"):
        told = re.compile(f"^{counts[name]} aboard: local") if name in counts else "free"
        expect(page.locator(f"[href='./{name}'] small")).to_have_text(told)
    wall.close()
    helm.hang_up()
    expect(page.locator("[href='./wall'] small")).to_have_text("free")
    expect(page.locator("[href='./helm'] small")).to_have_text(re.compile("^1 aboard: local"))

    assert instructor.ask("run")[0]
    expect(page.locator("#says")).to_have_text("Time runs.")
    assert instructor.ask("end exercise")[0]
    expect(page.locator("#says")).to_have_text("The exercise is over.")
    expect(look(session).locator("#says")).to_have_text("The exercise is over.")
    late = look(session, "instructor")
    expect(late.locator("#state")).to_have_text("ENDED")
    expect(late.locator("#exercise-body .big")).to_contain_text("marks of 100")


@pytest.mark.slow
@pytest.mark.parametrize("exercise", WANTED)
def test_the_first_page_has_the_stations_that_the_exercise_wants_first_and_large(
    serve: Serve, look: Look, exercise: str
) -> None:
    see_wanted(look(serve(exercise)), WANTED[exercise])


def see_wanted(page: Page, names: list[str]) -> None:
    """See that these stations come first and large, and all others behind a key."""
    wanted = page.locator("#wanted a")
    expect(wanted).to_have_count(len(names))
    assert [each.get_attribute("data-name") for each in wanted.all()] == names
    boxes = [each.bounding_box() for each in wanted.all()]
    assert all(box and box["height"] >= 110 for box in boxes)
    expect(page.locator("#facts")).to_contain_text("By hand: ")
    expect(page.locator("#about")).not_to_be_empty()

    other = page.locator("[data-name=wall]")
    expect(other).to_be_hidden()
    page.locator("#others summary").click()
    expect(other).to_be_visible()
    large, small = boxes[0], other.bounding_box()
    assert large
    assert small
    assert large["height"] > small["height"]


@pytest.mark.slow
def test_the_first_page_follows_the_session_to_another_exercise(serve: Serve, look: Look) -> None:
    session = serve("steady-course")
    page = look(session)
    expect(page.locator("#wanted a")).to_have_count(1)
    page.locator("#ask a").first.focus()
    caller = session.attach()
    assert caller.ask("end exercise")[0]
    assert caller.ask("next stern-plane-jam")[0]
    expect(page.locator("#title")).to_have_text("Passage, fast and deep")
    expect(page.locator("#wanted a")).to_have_count(3)
    expect(page.locator("#about")).to_have_text(re.compile(r"^On passage: .*as ordered\.$"))
    expect(page.locator("#ask a").first).to_be_focused()


@pytest.mark.parametrize("address", ["helmet", "debrief/none/watch.html"])
def test_what_is_not_found_has_a_way_back(shared: Served, browser: Browser, address: str) -> None:
    with browser.new_page() as page:
        answer = page.goto(f"{shared.url}/{address}")
        assert answer
        assert answer.status == 404
        key = page.get_by_role("link", name="Back to all stations")
        box = key.bounding_box()
        assert box
        assert box["height"] >= 48
        key.click()
        expect(page.locator("#state")).to_have_text("CONNECTED")


@pytest.mark.parametrize("way", WAYS)
def test_a_session_with_a_word_tells_nothing_before_and_takes_it_by_every_hand(
    serve: Serve, look: Look, way: str
) -> None:
    session = serve("stern-plane-jam", "--token", "mast")
    page = look(session)

    expect(page.locator("#title")).to_have_text("A session that asks for a word")
    expect(page.locator("body")).not_to_contain_text("Passage")
    page.locator("[href='./helm']").click()
    expect(page.locator("#word-title")).to_contain_text("asks for a word")
    expect(page.locator("#refusal")).to_have_text("this session needs a token")

    page = look(session, "helm", has_touch=True)  # a wrong word, away and back, and the right one
    field, enter = page.locator("#word input"), page.locator("#word form button")
    field.fill("boom")
    work(page, enter, way)
    expect(page.locator("#refusal")).to_contain_text("wrong token")
    work(page, page.locator("#word a"), way)
    expect(page.locator("#state")).to_have_text("CONNECTED")
    work(page, page.locator("[href='./helm']"), way)
    field.fill("mast")
    work(page, enter, way)
    expect(page.locator("#state")).to_have_text("FROZEN")


@pytest.mark.parametrize("size", IN_SHORT)
def test_the_keys_of_the_first_page_are_large(shared: Served, look: Look, size: str) -> None:
    page = look(shared, size=size)

    expect(page.locator("#state")).to_have_text("CONNECTED")
    expect(page.locator("#scenarios")).to_be_visible()
    boxes = [key.bounding_box() for key in page.locator("a, select").all() if key.is_visible()]
    assert len(boxes) == 17  # without a kiosk, since no visitor may begin again here
    for box in boxes:
        assert box
        assert min(box["width"], box["height"]) >= 44
