"""The pages' server: who may come in, what is refused, what comes back by itself."""

import contextlib
import functools
import http.client
import operator
import os
import re
import signal
import socket
import ssl
import subprocess
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import pytest
from helpers.browser import Look, Serve
from helpers.hands import skip_until
from helpers.installation import installed
from helpers.nursery import start_trainer
from helpers.pages import Served, free_port, served
from helpers.places import environment
from helpers.waiting import PATIENCE, await_that, children_of, stay_for
from helpers.wire import (
    Answered,
    ask,
    dialled,
    hear,
    make_certificate,
    make_certificate_of,
    pages,
    request,
)
from playwright.sync_api import Browser, expect
from soak.session_process import Caller
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import ClientConnection

from trainer.cli.main import cli
from trainer.config import extras
from trainer.config.files import ConfigError
from trainer.io.noise_log import ENTRY_PERIOD_S, MAX_ENTRIES
from trainer.io.orders import sentences
from trainer.io.orders.sentences import order_sentence, parse_sentence
from trainer.session.doors import page_server
from trainer.session.past.options import RunOptions
from trainer.web.address import Address, announce_address
from trainer.web.bridge import (
    MAX_PAGES_OF_MACHINE,
    MAX_REMOTE_PAGES,
    NO_ROOM_CODE,
    NO_SESSION_CODE,
    OLDER_PAGE_CODE,
    REFUSED_CODE,
    Bridge,
    RefusedError,
)
from trainer.web.gate import SECURITY_HEADERS, Refusals, ServerNames, page_policy
from trainer.web.pages import PAGES
from trainer.web.server import KEPT_FOREVER, MAX_TOKEN_LETTERS

WORD = "anchor-42"  # of the helm
FLOOD = 10_000
OLDER = """new MutationObserver(() => {
  const page = document.documentElement;
  if (page?.dataset.version > "0.0.9") page.dataset.version = "0.0.9";
}).observe(document, { childList: true, subtree: true });"""
FEW_S = 2  # without a sign of life
FEW = 20  # lines that a session says of itself
FEW_MISSED = 2  # ticks: a machine that others use may stand still once


def said(session: Served) -> str:
    return (session.folder / "said").read_text()


def missed_ticks(account: str) -> int:
    """Return how many ticks a session's account says were not on time."""
    found = re.search(r"overruns (\d+), caught up \d+, slipped (\d+), gaps (\d+)", account)
    assert found, account
    return sum(map(int, found.groups()))


def server_of(session: Served) -> int:
    """Return the process of a session's pages."""
    if not Path("/proc/self/task").is_dir():
        pytest.skip("this system does not tell the children of a process")
    return children_of(session.process.pid)[0]


def refused(line: ClientConnection) -> int:
    """Return by which code a line is closed, whatever comes before."""
    with contextlib.suppress(ConnectionClosed):
        while True:
            line.recv(PATIENCE)
    assert line.close_code
    return line.close_code


def leave(line: ClientConnection) -> None:
    """End the session, with a second word where others are attached."""
    if ask(line, "quit")[0] != "ok":
        assert ask(line, "quit")[0] == "ok"


def is_free(port: int) -> bool:
    with contextlib.suppress(OSError), socket.create_server(("127.0.0.1", port)):
        return True
    return False


# What every answer carries


ASKED: dict[str, tuple[str, str, dict[str, str], int]] = {
    "the first page": ("GET", "/", {}, 200),
    "a station": ("GET", "/helm", {}, 200),
    "a style sheet": ("GET", "steering.css", {}, 200),
    "a script": ("GET", "shared.js", {}, 200),
    "an asset that is not there": ("GET", "/assets/none.js", {}, 404),
    "a page that is not there": ("GET", "/none", {}, 404),
    "a method that a page has not": ("POST", "/helm", {"Origin": "own"}, 405),
    "no word": ("POST", "/word", {"Origin": "own"}, 400),
    "another host": ("GET", "/", {"Host": "evil.example"}, 403),
    "another origin": ("POST", "/word", {"Origin": "http://evil.example"}, 403),
}


@pytest.mark.parametrize("what", ASKED)
def test_every_answer_says_what_a_browser_may_do_with_it(shared: Served, what: str) -> None:
    method, path, asked, status = ASKED[what]
    headers = {name: value.replace("own", shared.url) for name, value in asked.items()}

    kept = asset_of(shared, path)
    got = request(shared.port, kept or path, method, context=None, **headers)

    assert got.status == status
    wanted = dict(SECURITY_HEADERS)
    if kept:
        wanted["Cache-Control"] = KEPT_FOREVER
    elif got.headers["content-type"].startswith("text/html"):
        (inline,) = re.findall(r'<script type="importmap">(.*?)</script>', got.body.decode())
        wanted["Content-Security-Policy"] = page_policy(inline)
    assert {name: got.headers.get(name.casefold()) for name in wanted} == wanted


def asset_of(session: Served, name: str) -> str:
    """Return the address of a file that the helm asks for, "" for what is none."""
    stem, _, kind = name.partition(".")
    html = request(session.port, "/helm").body.decode()
    return next(iter(re.findall(rf'"\.(/assets/{stem}\.[0-9a-f]{{16}}\.{kind})"', html)), "")


# Data for scripts is no script.
CODE_WITHIN = re.compile(
    r'<script(?![^>]*(src=|type="(application/json|importmap)"))|\son\w+=|\sstyle='
)


def test_no_page_holds_a_script_or_a_style_of_its_own(shared: Served) -> None:
    for name in (*(page.name for page in PAGES), "hlem"):
        html = request(shared.port, f"/{name}").body.decode()
        assert "<style" not in html
        assert not CODE_WITHIN.search(html)


@pytest.mark.parametrize(
    "path",
    [
        *("/assets/../pages.py", "/assets/%2e%2e/pages.py", "/assets/..%2fpages.py"),
        *("/assets//etc/passwd", "/assets/%2fetc/passwd", "/assets/js/..\\..\\pages.py"),
        *("/assets/css/../../templates/page.html", "/assets/%00", "/assets/", "/assets"),
    ],
)
def test_nothing_but_assets_is_served_as_one(shared: Served, path: str) -> None:
    assert request(shared.port, path).status in {307, 400, 404, 405}


# Names and origins


@pytest.mark.parametrize(
    "name",
    [
        *("evil.example", "127.0.0.1.evil.example", "localhost.evil.example", "2130706433"),
        *("0.0.0.0", "0x7f.1", "127.1", "", "127.0.0.1@evil.example", "[::1].evil"),  # noqa: S104
        *("127.0.0.2", "127.0.0.1:80:80", "[127.0.0.1"),
    ],
)
def test_a_name_that_is_none_of_its_own_is_refused(shared: Served, name: str) -> None:
    got = request(shared.port, "/", Host=name)

    assert got.status in {400, 403}
    assert b"html" not in got.body


@pytest.mark.parametrize("name", ["127.0.0.1:17880", "localhost", "LOCALHOST:1", "[::1]:17880"])
def test_this_machine_has_three_names(name: str) -> None:
    assert ServerNames.at("127.0.0.1").admits(name)


def test_a_server_for_all_addresses_answers_to_numbers_and_to_its_own_name_alone() -> None:
    door = ServerNames.at("0.0.0.0")  # noqa: S104
    assert door.admits("192.168.1.10:8080")
    assert door.admits(f"{socket.gethostname()}.local:8080")
    assert not door.admits("evil.example:8080")
    assert not door.admits("192.168.1.10%evil:8080")
    assert not ServerNames.at("192.168.1.10").admits("192.168.1.11")


@pytest.mark.parametrize("origin", ["http://evil.example", "null", None, "https://127.0.0.1:{}"])
def test_a_line_that_another_page_opens_is_refused(shared: Served, origin: str | None) -> None:
    own = origin.format(shared.port) if origin else origin
    with (
        pytest.raises(InvalidStatus) as refused,
        dialled(shared.port, origin=own),
    ):
        pass
    assert refused.value.response.status_code == 403


# Words


@pytest.fixture(scope="module")
def guarded() -> Iterator[Served]:
    """Return a session whose helm has a word, and the other roles another."""
    with served("--token", f"helm={WORD}", "--token", "mast") as session:
        yield session


def keep(session: Served, body: str, context: ssl.SSLContext | None = None) -> Answered:
    scheme = "https" if context else "http"
    origin = f"{scheme}://127.0.0.1:{session.port}"
    return request(session.port, "/word", "POST", body, context, Origin=origin)


@pytest.mark.process
def test_a_word_is_kept_where_no_script_and_no_other_site_has_it(guarded: Served) -> None:
    cookie = keep(guarded, f"helm {WORD}").headers["set-cookie"]

    assert "HttpOnly" in cookie
    assert "SameSite=strict" in cookie
    assert "Path=/line" in cookie
    assert "Secure" not in cookie


@pytest.mark.process
@pytest.mark.parametrize(
    "body",
    [
        *("", "helm", "captain word", "helm a b", "helm a\nb", "helm \x00", "helm a$b", "helm é"),
        *("helm " + "x" * (MAX_TOKEN_LETTERS + 1), "x" * 100_000),
    ],
)
def test_what_can_be_no_word_is_not_kept(guarded: Served, body: str) -> None:
    got = keep(guarded, body)

    assert got.status == 400
    assert "set-cookie" not in got.headers


@pytest.mark.process
def test_an_empty_word_is_forgotten(guarded: Served) -> None:
    assert "Max-Age=0" in keep(guarded, "helm ").headers["set-cookie"]


@pytest.mark.process
def test_a_role_is_given_for_its_own_word_alone(guarded: Served) -> None:
    for cookies, given in (
        ("", "no"),
        ("word-helm=wrong", "no"),
        ("word-planes=mast", "no"),
        (f"word-helm={WORD}", "ok"),
    ):
        with dialled(guarded.port, cookies=cookies) as line:
            assert ask(line, "role helm")[0] == given, cookies


@pytest.mark.process
def test_a_longest_word_still_fits_a_line(guarded: Served) -> None:
    word = "w" * MAX_TOKEN_LETTERS
    assert keep(guarded, f"instructor {word}w").status == 400
    with dialled(guarded.port, cookies=f"word-helm={word}") as line:
        answer = ask(line, "role helm", tag="999999")
    assert answer[0] == "no"
    assert "longest" not in answer[1]


def test_three_wrong_words_close_a_line_and_are_those_of_the_browsers_machine(
    serve: Serve,
) -> None:
    session = serve("--token", WORD)
    with dialled(session.port, cookies="word-helm=wrong") as line:
        assert [ask(line, "role helm")[1] for _ in range(2)] == 2 * ["wrong token"]
        assert ask(line, "role helm")[0] == "no"
        assert refused(line) == NO_SESSION_CODE
    with dialled(session.port, cookies="word-helm=wrong") as line:  # of the same machine
        assert "answered after 1 s" in ask(line, "role helm")[1]
    caller = Caller(session.socket, PATIENCE)
    assert caller.ask("role planes wrong") == (False, "wrong token")  # a program of this user
    caller.hang_up()
    with dialled(session.port, cookies=f"word-helm={WORD}") as line:
        assert ask(line, "role helm")[0] == "ok"


def test_a_word_typed_at_the_page_opens_the_station_and_is_seen_nowhere(
    serve: Serve, look: Look
) -> None:
    session = serve("--token", WORD, "--record", "kept.trainer")
    page = look(session, "helm")
    field = page.locator("#word input")

    field.fill("wrong-word")
    field.press("Enter")
    expect(page.locator("#refusal")).not_to_be_empty()
    field.fill(WORD)
    field.press("Enter")
    expect(page.locator("#state")).to_have_text("FROZEN")
    page.reload()
    expect(page.locator("#state")).to_have_text("FROZEN")  # the browser has kept it

    assert WORD not in page.content() + page.url
    assert WORD not in page.evaluate("document.cookie + JSON.stringify({...localStorage})")
    with dialled(session.port, cookies=f"word-instructor={WORD}") as line:
        assert ask(line, "role instructor")[0] == "ok"
        leave(line)
    assert session.process.wait(PATIENCE) == 0
    for path in session.folder.rglob("*"):
        if path.is_file():
            assert WORD.encode() not in path.read_bytes(), path


def test_with_a_certificate_pages_and_lines_are_encrypted(
    serve: Serve, browser: Browser, tmp_path: Path
) -> None:
    cert, key = make_certificate(tmp_path)
    session = serve("--token", WORD, "--web-cert", str(cert), "--web-key", str(key))
    known = ssl.create_default_context(cafile=str(cert))
    assert request(session.port, "/helm", context=known).status == 200
    assert "Secure" in keep(session, f"helm {WORD}", known).headers["set-cookie"]
    with dialled(session.port, cookies=f"word-helm={WORD}", scheme="wss", ssl=known) as line:
        assert ask(line, "role helm")[0] == "ok"

    url = f"https://127.0.0.1:{session.port}"
    with browser.new_context() as context, pytest.raises(Exception, match="ERR_CERT"):
        context.new_page().goto(f"{url}/instructor")
    with browser.new_context(ignore_https_errors=True) as context:
        page = context.new_page()
        dialled_at: list[str] = []
        page.on("websocket", lambda line: dialled_at.append(line.url))
        page.goto(f"{url}/instructor")
        page.locator("#word input").fill(WORD)
        page.locator("#word input").press("Enter")
        expect(page.locator("#state")).to_have_text("FROZEN")
        page.locator("#order").fill("depth 80")
        page.locator("#order").press("Enter")
        expect(page.locator("#log")).to_contain_text("depth 80")
        assert {url.partition(":")[0] for url in dialled_at} == {"wss"}
        (cookie,) = context.cookies(f"{url}/line")
        assert (cookie["secure"], cookie["httpOnly"]) == (True, True)

    with contextlib.suppress(OSError, http.client.HTTPException):  # no page without encryption
        got = request(session.port, "/helm")
        raise AssertionError(got.status)


@pytest.mark.process
@pytest.mark.parametrize(
    ("begins", "ends", "why"),
    [
        ("20200101000000Z", "20200201000000Z", "certificate has expired"),
        ("20990101000000Z", "20990201000000Z", "certificate is not yet valid"),
    ],
)
def test_a_certificate_out_of_its_time_is_refused_in_one_line(
    tmp_path: Path, begins: str, ends: str, why: str
) -> None:
    cert, key = make_certificate_of(tmp_path, begins, ends)
    for words in (["serve", "--web", "127.0.0.1:0"], ["web"]):
        with program(tmp_path, *words, "--cert", str(cert), "--key", str(key)) as process:
            _, told = process.communicate(timeout=PATIENCE)
        assert process.returncode == 2
        assert told == f"trainer: --cert {cert}: {why}: no browser takes it; make a new one\n"


# What could never be an order


@pytest.mark.parametrize(
    "frame",
    [
        *(b"\x00\xff", b"role helm", "x" * 81, "role helm\nrole instructor", "role\x1b[2J"),
        *("mark \u202e", "mark \x85", "caf\u00e9"),
    ],
)
def test_a_frame_that_can_be_no_order_closes_its_line(shared: Served, frame: str | bytes) -> None:
    with dialled(shared.port) as other, dialled(shared.port) as line:
        line.send(frame)

        assert refused(line) == REFUSED_CODE
        assert ask(other, "role observer")[0] == "ok"
    assert "\x1b" not in said(shared)


def test_a_frame_too_long_to_be_read_closes_its_line(shared: Served) -> None:
    with dialled(shared.port) as line:
        line.send("x" * 1_000_000)
        assert refused(line) == 1009


@pytest.mark.clock
def test_ten_thousand_frames_and_refusals_move_no_tick_and_fill_no_log(serve: Serve) -> None:
    session = serve("--no-record", frozen=False)
    begun = time.monotonic()
    with dialled(session.port) as helm:
        assert ask(helm, "role helm")[0] == "ok"
        with dialled(session.port) as line, contextlib.suppress(ConnectionClosed):
            for _ in range(FLOOD):
                line.send("$TRO,1,status*00")
        for _ in range(FLOOD // 50):
            request(session.port, "/", Host="evil\x9b[2J.example")
            with contextlib.suppress(InvalidStatus), dialled(session.port, origin="http://evil"):
                pass
        assert ask(helm, "rudder left 5")[0] == "ok"
    with dialled(session.port) as line:
        assert ask(line, "role instructor")[0] == "ok"
        leave(line)
    assert session.process.wait(PATIENCE) == 0

    told = said(session)
    whiles = (time.monotonic() - begun) // ENTRY_PERIOD_S + 1
    assert len(told.splitlines()) < FEW + whiles * (MAX_ENTRIES + 1), told
    assert "frames a second: its line is closed" in told
    assert "more of the same" in told
    assert "\x9b" not in told
    assert missed_ticks(told) <= FEW_MISSED


def summed(body: str) -> str:
    """Return a sentence with its sum."""
    return f"${body}*{functools.reduce(operator.xor, body.encode()):02X}"


LAST_TAG = "99"
FORGED = {
    "a fact of the session": summed("TRF,1,0.5,debrief,/etc/hostname"),
    "an event of the session": summed("TRE,1,0.5,casualty,jam"),
    "an answer of the session": summed("TRA,7,ok,the role is yours"),
    "an order without its sum": "$TRO,7,role helm",
    "an order with a wrong sum": "$TRO,7,role helm*00",
    "an order for a role with another's word": summed("TRO,7,role planes wrong"),
    "what the line of another browser has carried": summed("TRO,7,role planes"),
    "two orders in one": summed("TRO,7,role helm") + summed("TRO,8,quit"),
    "a tag without end": summed(f"TRO,{'9' * 60},role helm"),
    "no tag": summed("TRO,,role helm"),
    "a word in the tag": summed("TRO,role helm,role helm"),
}


@pytest.mark.process
@pytest.mark.parametrize("forged", FORGED)
def test_a_forged_or_replayed_sentence_gives_no_role_no_word_and_no_debrief(
    guarded: Served, forged: str
) -> None:
    cookies = f"word-helm={WORD}; word-instructor=wrong"
    heard: list[str] = []
    with dialled(guarded.port, cookies=cookies) as line:
        for _ in range(3):
            line.send(FORGED[forged])
        line.send(order_sentence("status", LAST_TAG))  # answered when all before is
        with contextlib.suppress(ConnectionClosed):
            while not heard or f"$TRA,{LAST_TAG}," not in heard[-1]:
                heard.append(str(line.recv(PATIENCE)))
    with dialled(guarded.port, cookies=f"word-helm={WORD}") as line:
        assert ask(line, "role instructor")[0] == "no"
        assert ask(line, "role helm")[0] == "ok"
        assert ask(line, "quit")[0] == "no"

    sentences = [sentence for sentence in map(parse_sentence, heard) if sentence]
    answers = [sentence.fields[0] for sentence in sentences if sentence.kind == "TRA"]
    assert set(answers) == {"no"}  # the third wrong word may close the line before its answer
    assert not any("debrief-page" in sentence.fields for sentence in sentences)
    assert WORD not in "".join(heard)
    assert WORD not in said(guarded)


def test_markup_in_a_remark_is_carried_as_words(shared: Served) -> None:
    remark = "<img src=x onerror=alert(1)> & <script>"
    with dialled(shared.port) as line, dialled(shared.port) as other:
        assert ask(other, "role instructor")[0] == "ok"
        assert ask(line, "role observer")[0] == "ok"
        assert ask(line, f"mark {remark}")[0] == "ok"
        while True:
            heard = hear(other)
            if heard and heard.kind == "TRE" and "mark by" in heard.fields[3]:
                break
    assert remark in heard.fields[3]


def test_another_machine_has_so_many_lines_and_no_more() -> None:
    bridge = Bridge(socket.socket, Refusals(print))
    with contextlib.ExitStack() as stack:
        for _ in range(100):
            stack.enter_context(bridge.count_page("127.0.0.1"))
        for _ in range(MAX_PAGES_OF_MACHINE):
            stack.enter_context(bridge.count_page("192.0.2.1"))
        with pytest.raises(RefusedError, match="close one"), bridge.count_page("192.0.2.1"):
            pass
        for number in range(MAX_REMOTE_PAGES - MAX_PAGES_OF_MACHINE):
            stack.enter_context(bridge.count_page(f"192.0.2.{10 + number}"))
        with pytest.raises(RefusedError, match="no room"), bridge.count_page("192.0.2.99"):
            pass
    assert not bridge.machines


def test_a_page_for_which_the_session_has_no_room_is_told_so() -> None:
    with pages() as stub, dialled(stub.port) as line:
        await_that(lambda: len(stub.sessions) == 1)
        stub.sessions[0].sendall(f"{sentences.fact(0, 0.0, 'no-room', '40')}\n".encode("ascii"))
        stub.sessions[0].shutdown(socket.SHUT_WR)  # a close would take it back with what is unread
        assert refused(line) == NO_ROOM_CODE
        assert line.close_reason == "no room: 40 stations are here; close a page"


# Lines that are slow, old or gone


def test_a_page_that_does_not_read_loses_its_own_lines_alone() -> None:
    line = b"$TRE,1,0.5,order,%s*00\n" % (b"x" * 1000)
    with pages() as stub, contextlib.ExitStack() as lines:
        lines.enter_context(dialled(stub.port, max_queue=1))
        await_that(lambda: len(stub.sessions) == 1)
        good = lines.enter_context(dialled(stub.port))
        await_that(lambda: len(stub.sessions) == 2)
        slow, quick = stub.sessions
        slow.settimeout(0.5)
        with contextlib.suppress(TimeoutError):  # it waits in the sockets; then the session knows
            for _ in range(100_000):
                slow.sendall(line)
            pytest.fail("a page that does not read has taken 100 MB")
        for _ in range(100):
            quick.sendall(line)
            assert str(good.recv(PATIENCE)) == line.decode().strip()


def test_what_the_session_says_at_once_is_one_frame_of_whole_lines() -> None:
    with pages() as stub, dialled(stub.port) as line:
        await_that(lambda: len(stub.sessions) == 1)
        session = stub.sessions[0]
        session.sendall(b"first\r\nsecond\nthi")
        assert ClientConnection.recv(line, PATIENCE) == "first\nsecond"
        session.sendall(b"rd\n")
        assert ClientConnection.recv(line, PATIENCE) == "third"


def test_a_line_without_an_end_closes_the_page_and_takes_no_memory() -> None:
    with pages() as stub, dialled(stub.port) as line:
        await_that(lambda: len(stub.sessions) == 1)
        with contextlib.suppress(ConnectionError):  # it is closed on the way
            stub.sessions[0].sendall(b"x" * 100_000)
        assert refused(line) == NO_SESSION_CODE


def test_a_page_of_another_version_is_told_so(shared: Served, look: Look) -> None:
    with dialled(shared.port, version="0.0.9") as line:
        assert refused(line) == OLDER_PAGE_CODE

    page = look(shared)
    page.add_init_script(OLDER)
    for name in ("helm", ""):
        page.goto(f"{shared.url}/{name}")
        expect(page.locator("#older")).to_be_visible()
        expect(page.locator("#older a")).to_have_text("Load it again")


# What comes back, and what ends


def test_a_server_that_is_stopped_is_begun_again_and_its_pages_come_back(
    shared: Served, look: Look, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert page_server.SILENCE_TIMEOUT_S == 10  # as docs/promises.md says
    monkeypatch.setattr(page_server, "SILENCE_TIMEOUT_S", FEW_S)
    told: list[str] = []
    with page_server.serving_pages(RunOptions(web="127.0.0.1:0")) as server:
        assert server
        server.attend(str(shared.socket), told.append)
        page = look(replace(shared, port=server.port))
        page.clock.install()
        page.goto(f"http://127.0.0.1:{server.port}/helm")
        state = page.locator("#state")
        expect(state).to_have_text("FROZEN")
        first = process_at(server.port)

        os.kill(first, signal.SIGSTOP)

        expect(state).to_have_text("NO LINK")
        assert request(server.port, "/helm").status == 200
        assert process_at(server.port) not in {0, first}
        skip_until(page, lambda: state.text_content() == "FROZEN")  # it dials again
    assert any("hangs" in each for each in told)


def process_at(port: int) -> int:
    """Return the process of this one that serves pages at a port, 0 for none."""
    for process in children_of(os.getpid()):
        with contextlib.suppress(OSError):
            if f"127.0.0.1:{port}" in Path(f"/proc/{process}/cmdline").read_text():
                return process
    return 0


@pytest.mark.slow
@pytest.mark.clock
def test_a_server_that_was_stopped_together_with_its_session_is_left_alone(serve: Serve) -> None:
    session = serve()
    server = server_of(session)
    both = (session.process.pid, server)
    for process in both:
        os.kill(process, signal.SIGSTOP)
    stay_for(
        session.process, page_server.SILENCE_TIMEOUT_S + 2
    )  # both are away for longer than one may be
    for process in both:
        os.kill(process, signal.SIGCONT)

    stay_for(session.process, 3)  # its server would be killed in the first second
    assert server_of(session) == server
    assert request(session.port, "/helm").status == 200


@pytest.fixture
def limit_descriptors() -> Callable[[int, int], None]:
    """Return what leaves a process so many descriptors of files."""
    resource = pytest.importorskip("resource")
    if not hasattr(resource, "prlimit"):
        pytest.skip("this system sets no limits of another process")

    def limit(process: int, most: int) -> None:
        hard = resource.prlimit(process, resource.RLIMIT_NOFILE)[1]
        resource.prlimit(process, resource.RLIMIT_NOFILE, (most, hard))

    return limit


def test_a_server_out_of_descriptors_still_serves_who_asks_for_something(
    serve: Serve, limit_descriptors: Callable[[int, int], None]
) -> None:
    session = serve()
    assert request(session.port, "/helm").status == 200  # it has begun, and asked for its own
    limit_descriptors(server_of(session), 24)
    with contextlib.ExitStack() as silent:
        for _ in range(100):
            silent.enter_context(socket.create_connection(("127.0.0.1", session.port), PATIENCE))
        assert request(session.port, "/helm").status == 200
        with dialled(session.port) as line:
            assert ask(line, "role helm")[0] == "ok"
    assert "no room for a connection: Too many open files" in said(session)


def test_a_session_out_of_descriptors_begins_its_pages_again_once_it_has_some(
    serve: Serve, limit_descriptors: Callable[[int, int], None]
) -> None:
    session = serve()
    instructor = session.attach()
    before = len(list(Path(f"/proc/{session.process.pid}/fd").iterdir()))
    limit_descriptors(session.process.pid, before)

    os.kill(server_of(session), signal.SIGKILL)
    await_that(
        lambda: instructor.ask("log")[0] and any("cannot begin" in x for x in instructor.said)
    )
    limit_descriptors(session.process.pid, 1024)

    assert request(session.port, "/helm").status == 200


@pytest.mark.process
def test_pages_are_served_and_end_where_the_time_of_day_is_a_made_up_one(tmp_path: Path) -> None:
    faketime = installed("faketime", "faketime")
    words = ["run", "--web", "--web-at", "127.0.0.1:0", "--no-record"]
    made_up = (faketime, "--exclude-monotonic", "-f", "+400d")
    with program(tmp_path, *words, before=made_up) as process:
        found = re.search(r"127.0.0.1:([0-9]+)/", await_said(process, "pages at"))
        assert found
        assert request(int(found[1]), "/helm").status == 200
        for each in children_of(process.pid) or [process.pid]:
            os.kill(each, signal.SIGINT)
        _, told = process.communicate(timeout=PATIENCE)
    assert process.returncode == 0, told


def test_a_killed_session_takes_its_pages_server_with_it(serve: Serve) -> None:
    session = serve()

    session.process.kill()

    session.process.wait(PATIENCE)
    await_that(lambda: is_free(session.port))


def test_the_end_of_a_session_is_the_end_of_its_pages(serve: Serve) -> None:
    session = serve()
    with dialled(session.port) as line:
        assert ask(line, "role instructor")[0] == "ok"
        leave(line)
        assert refused(line) in {NO_SESSION_CODE, 1012}

    assert session.process.wait(PATIENCE) == 0
    assert is_free(session.port)
    assert "Traceback" not in said(session)


def test_the_next_exercise_is_at_the_same_address(serve: Serve) -> None:
    session = serve("periscope-depth", "--no-record")
    server = server_of(session)
    with dialled(session.port) as line:
        assert ask(line, "role instructor")[0] == "ok"
        assert ask(line, "end exercise")[0] == "ok"
        assert ask(line, "next depth-changes")[0] == "ok"
        refused(line)

    def is_back() -> bool:
        with contextlib.suppress(ConnectionClosed), dialled(session.port) as line:
            return ask(line, "role helm")[0] == "ok"
        return False

    await_that(is_back)
    assert server_of(session) == server


@contextlib.contextmanager
def program(
    folder: Path, *words: str, before: tuple[str, ...] = (), **own: str
) -> Iterator["subprocess.Popen[str]"]:
    """Run a command of the trainer while the block lasts, by another command ``before`` it."""
    own = {**environment(), "XDG_RUNTIME_DIR": str(folder), "BROWSER": "true", **own}
    pipe = subprocess.PIPE
    with start_trainer(
        *words, before=before, env=own, cwd=folder, stdout=pipe, stderr=pipe
    ) as process:
        try:
            yield process
        finally:
            process.kill()


def await_said(process: "subprocess.Popen[str]", words: str) -> str:
    """Return what a program says on stderr until these words."""
    lines = []
    for line in process.stderr or ():
        lines.append(line)
        if words in line:
            return "".join(lines)
    raise AssertionError("".join(lines))


@pytest.mark.slow
def test_a_server_of_its_own_serves_one_session_after_the_other(
    serve: Serve, tmp_path: Path
) -> None:
    first = serve()
    port = free_port()
    words = ["web", "--connect", str(first.socket), "--web", f"127.0.0.1:{port}"]
    with program(tmp_path, *words) as process:
        await_said(process, "pages at")
        with dialled(port) as line, dialled(first.port) as other:
            assert ask(line, "role helm")[0] == "ok"
            assert ask(other, "role helm")[0] == "ok"  # two servers on one session, two helms
        first.process.terminate()
        first.process.wait(PATIENCE)
        with dialled(port) as line:
            assert refused(line) == NO_SESSION_CODE
        second = serve()
        first.socket.unlink(missing_ok=True)
        os.link(second.socket, first.socket)
        with dialled(port) as line:
            assert ask(line, "role helm")[0] == "ok"
        process.send_signal(signal.SIGINT)
        _, told = process.communicate(timeout=PATIENCE)
        assert (process.returncode, told) == (0, "")


# Wrong input


WRONG = {
    "serve --web 0.0.0.0:8080": "--web 0.0.0.0: beyond this machine only with --token WORD",
    "run --web-at 0.0.0.0:8080": "--web-at 0.0.0.0: beyond this machine only with --token WORD",
    "serve --web here": "--web here: say HOST:PORT, such as 127.0.0.1:17880",
    "serve --web http://127.0.0.1:8080/": "leave http:// out, say 127.0.0.1:8080",
    "serve --listen tcp://127.0.0.1:17800": "leave tcp:// out, say 127.0.0.1:17800",
    "serve --web 127.0.0.1:{taken}": "in use already; give another port, or 0 for any",
    "run --web-at 127.0.0.1:{taken}": "--web-at 127.0.0.1:{taken}: in use already",
    "web --web 127.0.0.1:{taken}": "--web 127.0.0.1:{taken}: in use already; give another port",
    "web --connect loop://": "--connect loop://: say tcp://HOST:PORT or the path of a local",
    "web --connect tcp://x": "--connect tcp://x: say tcp://HOST:PORT",
    "web --connect tcp://x:99999": "a port is 1 to 65535",
    "run --web --cert c.pem": "--cert c.pem: a certificate needs its key: add --key FILE",
    "web --key k.pem": "--key k.pem: a key needs its certificate: add --cert FILE",
    "web --cert c.pem --key k.pem": "--cert c.pem: No such file",
    "web --cert {file} --key {file}": "not a certificate and its own key, both PEM",
    "run --cert c.pem --key k.pem": "--public-url and --proxy are of pages: add --web",
    "run --web --speed max": "--web: pages show a boat in its own time: leave out --speed max",
    "run --web --headless": "trainer serve --web 127.0.0.1:17880 serves pages and opens none",
    "run --web --serial loop://": "--web: add --line instructor=loop:// in place of --serial",
}


@pytest.mark.parametrize("words", WRONG)
def test_wrong_input_is_told_with_the_next_step(
    words: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "x.pem").write_text("no certificate")
    with socket.create_server(("127.0.0.1", 0)) as taken:
        names = {"taken": str(taken.getsockname()[1]), "file": "x.pem"}

        with pytest.raises(ConfigError) as told:
            cli(words.format(**names).split(), standalone_mode=False)

    assert WRONG[words].format(**names) in str(told.value)
    assert "\n" not in str(told.value)


def test_without_the_extra_one_line_says_what_to_install(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(extras, "find_spec", lambda name: None if name == "uvicorn" else name)
    for words in (["run", "--web"], ["serve", "--web", "127.0.0.1:1"], ["web"]):
        with pytest.raises(
            ConfigError, match=r"needs uvicorn: pip install 'submarine-trainer\[web"
        ):
            cli(words, standalone_mode=False)


def test_a_session_without_a_token_is_not_carried_beyond_this_machine(
    serve: Serve, tmp_path: Path
) -> None:
    session = serve()
    words = ["web", "--connect", str(session.socket), "--web", "0.0.0.0:0"]
    with program(tmp_path, *words) as process:
        _, told = process.communicate(timeout=PATIENCE)
    assert process.returncode == 2
    assert told == (
        "trainer: --web 0.0.0.0:0: beyond this machine only for a session with --token WORD\n"
    )


def test_beyond_this_machine_a_camera_reads_the_address_and_no_token() -> None:
    told = announce_address(Address("192.0.2.7", 8080))

    assert told.startswith("pages at http://192.0.2.7:8080/\n")
    assert "█" in told
    assert "█" not in announce_address(Address("127.0.0.1", 8080))


def test_a_telephone_reads_the_code_of_a_short_address_too() -> None:
    told = announce_address(Address("a.b", 80))

    drawn = [line for line in told.splitlines()[1:] if line.strip()]
    assert len(drawn) > 11  # lines of two modules: a Micro QR code has 17 and its edge


@pytest.mark.process
def test_run_opens_its_pages_and_takes_another_port_where_the_usual_is_taken(
    tmp_path: Path,
) -> None:
    opened = tmp_path / "opened"
    browser = tmp_path / "browser"
    browser.write_text(f'#!/bin/sh\necho "$1" > {opened}.new && mv {opened}.new {opened}\n')
    browser.chmod(0o755)
    with contextlib.ExitStack() as stack:
        with contextlib.suppress(OSError):  # taken already is as good
            stack.enter_context(socket.create_server(("127.0.0.1", 17880)))
        words = ["run", "--web", "--no-record", "--duration", "30"]
        run = stack.enter_context(program(tmp_path, *words, BROWSER=f"{browser} %s"))
        told = await_said(run, "pages at")
        await_that(opened.exists)
        url = opened.read_text().strip()
        assert f"pages at {url}" in told
        assert ":17880/" not in url
        run.send_signal(signal.SIGINT)
        run.communicate(timeout=PATIENCE)
        assert run.returncode == 0


@pytest.mark.process
def test_without_a_browser_the_user_is_told_what_to_open(tmp_path: Path) -> None:
    words = ["web", "--connect", str(tmp_path / "none"), "--web", "127.0.0.1:0"]
    nowhere = {"PATH": str(tmp_path), "BROWSER": "", "DISPLAY": "", "WAYLAND_DISPLAY": ""}
    with program(tmp_path, *words, before=(), **nowhere) as process:
        told = await_said(process, "no browser was found")
    assert re.search(r"no session listens there.*the pages wait for one", told)
    assert re.search(r"no browser was found: open http://127.0.0.1:[0-9]+/ in one", told)
