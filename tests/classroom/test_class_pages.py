"""The pages of a class: coming aboard, what boats learn of each other, the instructor's tiles."""

import re
from collections.abc import Iterator
from contextlib import suppress

import pytest
from helpers import node
from helpers.browser import Look
from helpers.classes import Class, class_at_sea, kill, post
from helpers.waiting import PATIENCE, await_that
from helpers.wire import ask, dialled, request
from playwright.sync_api import Locator, Page, expect
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import ClientConnection

from trainer.classroom.entrance import NO_SEAT_TEXT
from trainer.io.orders.sentences import order_sentence
from trainer.web.bridge import OLDER_PAGE_CODE, REFUSED_CODE
from trainer.web.pages import PAGES

pytestmark = pytest.mark.process
BOATS = 3
WORD, CHIEF = "anchor-42", "chief-17"
COURSE = f"""\
boats = {BOATS}

[[course]]
exercise = "depth-changes"
reach = 70

[[course]]
exercise = "steady-course"
"""
DESK = {"width": 1366, "height": 768}
PHONE = {"width": 360, "height": 640}


@pytest.fixture(scope="module")
def lesson(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Class]:
    """Return one class for all tests of the module, with a course."""
    path = tmp_path_factory.mktemp("class") / "tuesday.toml"
    path.write_text(COURSE, encoding="utf-8")
    words = ("--token", WORD, "--token", f"instructor={CHIEF}")
    with class_at_sea(str(path), *words, boats=BOATS) as begun:
        yield begun


def come(lesson: Class, boat: int, role: str = "planes", name: str = "") -> str:
    """Take a seat on a boat; return the browser's cookies."""
    status, text, cookies = post(lesson, "/seat", f"{boat}\n{role}\n{WORD}\n{name}")
    assert (status, text) == (200, str(boat))
    return cookies


def test_what_one_boat_can_learn_of_another(lesson: Class) -> None:
    come(lesson, 3, name="B. Smith")
    cookies = come(lesson, 2)
    own = request(lesson.port, "/boat/2/planes", Cookie=cookies)
    assert own.status == 200
    pages = [*(page.name for page in PAGES), "debrief/x/y.html", "assets/shared.js", "word"]
    paths = [f"/boat/{boat}/{name}" for boat in (1, 3) for name in pages]
    paths += ["/boat/03/planes", "/boat/2/../3/planes", "/boat/2/%2e%2e/3/planes", "/boat/4/planes"]
    for path in [*paths, "/boat/3", "/boat/2/boat/3/planes", "/line", "/boat/3/line"]:
        found = request(lesson.port, path, Cookie=cookies)
        assert found.status in (303, 307, 404), path
        assert b"Planes" not in found.body
    told = request(lesson.port, "/boats", Cookie=cookies).body.decode()
    keys = re.findall(r'"(\w+)":', told.partition("]")[0])
    assert keys == ["boats", *["number", "name", "crew"] * BOATS]
    assert "Smith" not in told
    see_lines_apart(lesson, cookies)
    see_no_way_to_instruct(lesson, cookies)


def see_lines_apart(lesson: Class, cookies: str) -> None:
    """See that a line goes to the browser's own boat, and hears nothing of another."""
    for boat in (1, 3):
        with dialled(lesson.port, cookies=cookies, root=f"/boat/{boat}") as line:
            with pytest.raises(ConnectionClosed) as refused:
                line.recv(PATIENCE)
            assert refused.value.rcvd
            assert refused.value.rcvd.code == REFUSED_CODE
            assert refused.value.rcvd.reason == NO_SEAT_TEXT.format(boat)
    other = lesson.attach_with(3, "instructor", CHIEF)
    with dialled(lesson.port, cookies=cookies, root="/boat/2") as line:
        assert ask(line, "role planes")[0] == "ok"
        assert other.ask("order depth 77")[0]
        assert other.ask("mark xyzzy")[0]
        heard = told_until_answered(line, "log 20")
    assert any("planes" in text for text in heard)
    assert not [text for text in heard if "77" in text or "xyzzy" in text]


def told_until_answered(line: ClientConnection, words: str) -> list[str]:
    """Return all that a line is told until an order is answered."""
    line.send(order_sentence(words, "5"))
    told: list[str] = []
    while not any(text.startswith(("$TRA,5,ok", "$TRA,5,no")) for text in told):
        told.append(str(line.recv(PATIENCE)))
    return told


def see_no_way_to_instruct(lesson: Class, cookies: str) -> None:
    """See that a trainee's word takes no instructor's seat and no instructor's role."""
    status, text, kept = post(lesson, "/word", f"instructor {WORD}", cookies)
    assert (status, kept) == (403, "")
    assert "token" in text
    assert post(lesson, "/seat", f"3\ninstructor\n{WORD}\n", cookies)[0] == 400
    assert post(lesson, "/seat", "3\nplanes\nwrong\n")[::2] == (403, "")
    with dialled(lesson.port, cookies=cookies, root="/boat/2") as line:
        assert ask(line, f"role instructor {WORD}")[0] == "no"


def instruct(lesson: Class) -> str:
    """Take the instructor's seat; return the browser's cookies."""
    status, _, cookies = post(lesson, "/word", f"instructor {CHIEF}")
    assert status == 200
    return cookies


@pytest.fixture
def shown(lesson: Class) -> Iterator[str]:
    """Show boat 3 to all, until the end of a test; return the instructor's cookies."""
    cookies = instruct(lesson)
    assert post(lesson, "/shown", "3", cookies)[:2] == (200, "3")
    yield cookies
    assert post(lesson, "/shown", "0", cookies)[:2] == (200, "0")


def test_the_instructor_alone_shows_a_boat_to_all(lesson: Class) -> None:
    trainee, chief = come(lesson, 2), instruct(lesson)
    for cookies in ("", trainee):
        assert post(lesson, "/shown", "3", cookies)[0] == 403
    for wrong in ("4", "99", "-1", "3 ", "", "all"):
        answered = post(lesson, "/shown", wrong, chief)[:2]
        assert answered == (400, "say a boat, 1 to 3, or 0 for none"), wrong
    told = request(lesson.port, "/boats", Cookie=trainee).body
    assert told.endswith(b'"shown":0}')
    assert b"No boat is shown now" in request(lesson.port, "/wall", Cookie=trainee).body
    assert request(lesson.port, "/shown/3/wall", Cookie=trainee).headers["location"] == "/wall"
    with (
        dialled(lesson.port, cookies=trainee, root="/shown/3") as line,
        pytest.raises(ConnectionClosed) as closed,
    ):
        line.recv(PATIENCE)
    assert closed.value.rcvd
    assert closed.value.rcvd.code == OLDER_PAGE_CODE


def test_of_the_boat_that_is_shown_others_have_the_wall_and_nothing_else(
    lesson: Class, shown: str
) -> None:
    cookies = come(lesson, 2)
    assert request(lesson.port, "/wall", Cookie=cookies).headers["location"] == "/shown/3/wall"
    assert b"track-chart" in request(lesson.port, "/shown/3/wall", Cookie=cookies).body
    for path in ("/shown/1/wall", "/boat/3/wall", "/boat/3/planes", "/boat/3/debrief/x/y.html"):
        assert request(lesson.port, path, Cookie=cookies).status == 303, path
    for path in ("/shown/3/planes", "/shown/3/", "/shown/3/instructor", "/shown/03/line"):
        assert request(lesson.port, path, Cookie=cookies).status == 404, path
    wrong = f"role planes {WORD}"
    for words in (wrong, "order depth 50", "mark me", "log 20", "freeze", "nonsense"):
        with dialled(lesson.port, cookies=cookies, root="/shown/3") as line:
            assert ask(line, "role observer")[0] == "ok"
            line.send(order_sentence(words, "8"))
            assert close_code(line) == REFUSED_CODE, words
    with dialled(lesson.port, cookies=cookies, root="/shown/3") as line:
        line.send("role planes " + WORD)
        assert close_code(line) == REFUSED_CODE
    with dialled(lesson.port, root="/shown/3") as line:  # a stranger has no word
        assert ask(line, "role observer")[0] == "no"
    with dialled(lesson.port, cookies=shown, root="/shown/3") as line:
        assert ask(line, "role observer")[0] == "no"  # the instructor's opens no other role
    with dialled(lesson.port, cookies=cookies, root="/shown/3") as line:
        assert ask(line, "role observer")[0] == "ok"
        assert ask(line, "subscribe gauges")[0] == "ok"
        assert post(lesson, "/shown", "1", shown)[0] == 200
        assert close_code(line) == OLDER_PAGE_CODE


def close_code(line: ClientConnection) -> int:
    """Return the code with which a line is closed."""
    with suppress(ConnectionClosed):
        while True:
            line.recv(PATIENCE)
    return int(line.close_code or 0)


def test_all_see_the_boat_that_is_shown_until_it_is_taken_back(lesson: Class, look: Look) -> None:
    projector, desk = look(lesson, "wall"), class_page(lesson, look, DESK)
    expect(projector.locator("main")).to_contain_text("No boat is shown now")
    trainee = aboard(lesson, look, 2)
    way = trainee.locator("#shown-way")
    desk.click("#show")
    expect(desk.locator("#answer")).to_have_text("choose the one boat that all are to see")
    desk.check("#choose-3")
    desk.locator("#show").focus()
    desk.keyboard.press("Enter")
    expect(desk.locator("#answer")).to_have_text(f"boat 3 is shown to all: {lesson.url}/wall")
    expect(desk.locator("#show")).to_have_attribute("aria-pressed", "true")
    expect(tile(desk, 3).locator(".shown")).to_have_text("shown to all")
    expect(tile(desk, 2).locator(".shown")).to_be_hidden()
    assert desk.evaluate(EIGHT)[:2] == [True, 0]
    projector.fill("#word input", WORD)
    projector.press("#word input", "Enter")
    see_wall(projector)
    expect(way).to_have_text("Boat 3 is shown to all")
    with trainee.expect_popup() as opened:
        way.press("Enter")
    see_wall(opened.value)  # by his own word
    trainee.evaluate(node.axe())
    assert trainee.evaluate(node.BARRIERS) == []
    expect(tile(desk, 3).locator(".crew")).not_to_contain_text("wall")
    desk.locator("#show").press("Enter")
    expect(desk.locator("#answer")).to_have_text("no boat is shown any more")
    for page in (projector, opened.value):
        expect(page.locator("main")).to_contain_text("No boat is shown now")
        assert page.url == f"{lesson.url}/wall"
    expect(way).to_be_hidden()
    projector.set_viewport_size(PHONE)  # type: ignore[arg-type]
    projector.evaluate(node.axe())
    assert projector.evaluate(node.BARRIERS) == []
    assert projector.evaluate("document.documentElement.scrollWidth <= innerWidth")


def aboard(lesson: Class, look: Look, boat: int) -> Page:
    """Return the page of a trainee's station."""
    page = look(lesson)
    page.select_option("#station", "helm")
    page.check(f"#boat-{boat}")
    page.fill("#token", WORD)
    page.click("#come button")
    expect(page.locator("#state")).to_have_text(re.compile("FROZEN|RUNNING"))
    return page


def see_wall(page: Page) -> None:
    """See the wall of boat 3, with its readings."""
    expect(page.locator("#exercise")).to_have_text("Boat 3: Deep, then shallow")
    expect(page.locator("#depth")).to_have_text(re.compile(r"^\d+\.\d$"))


def test_two_who_come_at_once_get_two_boats_and_a_third_joins_where_he_chooses(
    lesson: Class, look: Look
) -> None:
    free = [post(lesson, "/seat", f"0\nplanes\n{WORD}\n")[1] for _ in range(2)]
    assert len(set(free)) == 2
    page = look(lesson)
    expect(page.locator("#boats label")).to_have_count(1 + BOATS)
    page.fill("#called", "Jörg Müller")
    page.select_option("#station", "helm")
    page.check("#boat-3")
    page.fill("#token", WORD)
    page.click("#come button")
    expect(page).to_have_url(re.compile(r"/boat/3/helm$"))
    expect(page.locator("#state")).to_have_text("FROZEN")
    desk = class_page(lesson, look, DESK)
    expect(tile(desk, 3).locator(".crew")).to_contain_text("Jörg Müller, helm")
    kept = [path for path in lesson.folder.rglob("*") if path.is_file()]
    assert len(kept) > BOATS
    assert not [path for path in kept if "Müller".encode() in path.read_bytes()]


def class_page(lesson: Class, look: Look, size: dict[str, int], **how: object) -> Page:
    """Return the instructor's page, with a line to each boat."""
    page = look(lesson, "class", **how)
    page.set_viewport_size(size)  # type: ignore[arg-type]
    page.fill("#word input", CHIEF)
    page.press("#word input", "Enter")
    expect(page.locator(".tile")).to_have_count(BOATS)
    expect(page.locator(".tile .state[data-state=connecting]")).to_have_count(0)
    return page


def tile(page: Page, boat: int) -> Locator:
    return page.locator(f'[data-boat="{boat}"]')


def test_words_go_to_the_chosen_boats_and_each_answers(lesson: Class, look: Look) -> None:
    page = class_page(lesson, look, DESK)
    page.click("[data-words=freeze]")
    expect(page.locator("#answer")).to_have_text("choose boats first")
    page.check("#choose-1")
    page.check("#choose-2")
    page.fill("#order", "order depth 90")
    page.press("#order", "Enter")
    expect(page.locator("#answer")).to_contain_text("obeyed by 2 of 2")
    expect(tile(page, 1).locator(".said")).to_contain_text("90")
    expect(tile(page, 3).locator(".said")).to_have_text("")
    page.fill("#order", "casualty no-such-thing")
    page.press("#order", "Enter")
    expect(page.locator("#answer")).to_contain_text("obeyed by 0 of 2")
    expect(tile(page, 2).locator(".said")).to_have_text(re.compile("^no: "))
    expect(page.locator("#order")).to_have_value("casualty no-such-thing")
    page.click("[data-words=run]")
    expect(tile(page, 1).locator(".state")).to_have_text("RUNNING")
    expect(tile(page, 3).locator(".state")).to_have_text("FROZEN")
    depth = tile(page, 1).locator(".curve").first
    expect(depth.locator("b")).to_have_text(re.compile(r"^6\d\.\d m$"))
    expect(depth.locator(".actual")).to_have_attribute("points", re.compile(r"\S+ \S+"))
    page.click("[data-words=freeze]")
    expect(tile(page, 2).locator(".state")).to_have_text("FROZEN")
    see_ways(page)


# A line that never comes about, to one boat.
NO_LINE = """
const Real = window.WebSocket;
window.WebSocket = function (url, ...more) {
  if (!String(url).includes("/boat/3/")) return new Real(url, ...more);
  return Object.assign(new EventTarget(), { readyState: 0, send() {}, close() {} });
};
Object.assign(window.WebSocket, { CONNECTING: 0, OPEN: 1, CLOSING: 2, CLOSED: 3 });
"""


def test_a_boat_without_a_line_refuses_for_itself_alone(lesson: Class, look: Look) -> None:
    page = look(lesson, "class", script=NO_LINE)
    page.set_viewport_size(DESK)  # type: ignore[arg-type]
    page.fill("#word input", CHIEF)
    page.press("#word input", "Enter")
    for boat in (1, 2):
        expect(tile(page, boat).locator(".state")).to_have_text("FROZEN")
    page.click("#all")
    page.fill("#order", "order depth 85")
    page.press("#order", "Enter")

    expect(page.locator("#answer")).to_contain_text("obeyed by 2 of 3")
    expect(page.locator("#answer")).to_contain_text("boat 3: ")
    for boat in (1, 2):
        expect(tile(page, boat).locator(".said")).to_contain_text("85")
    expect(tile(page, 3).locator(".said")).to_have_text(re.compile("^no: "))
    expect(page.locator("#order")).to_have_value("order depth 85")


def test_the_way_is_shown_in_all_chosen_boats_at_once(lesson: Class, look: Look) -> None:
    page = class_page(lesson, look, DESK)
    for boat in (1, 2):
        page.check(f"#choose-{boat}")
    page.click("[data-words=run]")
    page.click("[data-words=demonstrate]")
    expect(tile(page, 2).locator(".said")).to_contain_text("freeze first")
    page.click("[data-words=freeze]")
    for boat in (1, 2):
        expect(tile(page, boat).locator(".state")).to_have_text("FROZEN")
    page.click("[data-words=demonstrate]")
    expect(page.locator("#answer")).to_contain_text("obeyed by 2 of 2")
    for boat in (1, 2):
        expect(tile(page, boat).locator(".said")).to_contain_text("to show it for 120 s")
        expect(tile(page, boat).locator(".state")).to_have_text("RUNNING")
    expect(tile(page, 3).locator(".said")).to_have_text("")
    page.fill("#order", "demonstrate off")
    page.press("#order", "Enter")
    for boat in (1, 2):
        expect(tile(page, boat).locator(".state")).to_have_text("FROZEN")


def see_ways(page: Page) -> None:
    """See that a tile leads to the boat's own page, and that the page leads back, by keyboard."""
    page.locator("#by-number").focus()
    page.keyboard.press("2")
    page.keyboard.press("Enter")
    expect(page).to_have_url(re.compile(r"/boat/2/instructor$"))
    expect(page.locator("#state")).to_have_text("FROZEN")
    page.locator("#class").focus()
    page.keyboard.press("Enter")
    expect(page.locator(".tile")).to_have_count(BOATS)


# Tiles as eight boats have them, beside those that are there.
EIGHT = """() => {
  const main = document.querySelector("#tiles");
  while (main.children.length < 8) main.append(main.children[0].cloneNode(true));
  const fits = main.scrollHeight <= main.clientHeight
    && document.documentElement.scrollHeight <= innerHeight;
  const tiles = [...main.children];
  const cut = tiles.filter((each) => each.scrollHeight > each.clientHeight + 1);
  return [fits, cut.length, new Set(tiles.map((each) => each.offsetLeft)).size];
}"""


def test_eight_tiles_need_no_scrolling_and_a_phone_has_a_list(lesson: Class, look: Look) -> None:
    page = class_page(lesson, look, DESK)
    assert page.evaluate(EIGHT) == [True, 0, 4]
    page.set_viewport_size(PHONE)  # type: ignore[arg-type]
    assert page.evaluate(EIGHT)[1:] == [0, 1]
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")


@pytest.mark.parametrize("name", ["", "class"])
def test_nobody_is_shut_out_of_the_pages_of_a_class(lesson: Class, look: Look, name: str) -> None:
    page = class_page(lesson, look, DESK) if name else look(lesson)
    page.evaluate(node.axe())

    assert page.evaluate(node.BARRIERS) == []


def test_a_boat_that_dies_stands_first_until_it_is_back(lesson: Class, look: Look) -> None:
    page = class_page(lesson, look, DESK)
    before = lesson.process_of(3)
    kill(before)
    expect(tile(page, 3).locator(".need")).to_contain_text("resumed from its recording")
    await_that(lambda: page.locator(".tile").first.get_attribute("data-boat") == "3")
    expect(tile(page, 3).locator(".state")).to_have_text("FROZEN")
    assert lesson.process_of(3) != before
    page.check("#choose-3")
    page.click("[data-words=run]")
    expect(tile(page, 3).locator(".state")).to_have_text("RUNNING")


def test_the_class_page_speaks_german(lesson: Class, look: Look) -> None:
    page = look(lesson, "class", query="?lang=de")
    expect(page.locator("#word-title")).to_have_text(
        "Die Klasse fragt nach dem Wort des Ausbilders"
    )
    page.fill("#word input", CHIEF)
    page.press("#word input", "Enter")
    expect(tile(page, 1).locator("h2")).to_have_text("Boot 1")


def test_a_tile_shows_the_place_in_the_course_and_what_is_missing_to_go_on(
    lesson: Class, look: Look
) -> None:
    page = class_page(lesson, look, DESK)
    place = tile(page, 2).locator(".place")
    expect(place).to_have_text("1 of 2: depth-changes, 70 marks to go on")
    page.check("#choose-2")
    page.click("#next")
    expect(tile(page, 2).locator(".said")).to_contain_text("is not over")
    page.fill("#order", "step")  # marks are of what was flown
    page.press("#order", "Enter")
    page.click("[data-words='end exercise']")
    expect(place).to_have_text(re.compile(r"^1 of 2: depth-changes, \d+ of 70$"))
    page.click("#next")
    expect(tile(page, 2).locator(".said")).to_have_text(re.compile(r"^no: \d+ of 70 marks: again"))
    page.fill("#order", "next steady-course")
    page.press("#order", "Enter")
    expect(place).to_have_text("2 of 2: steady-course")
    expect(tile(page, 1).locator(".place")).to_contain_text("1 of 2")
