"""Pages behind a reverse proxy: at a public address, under a path, each machine with its limits."""

import contextlib
import re
import ssl
import subprocess
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import pytest
from helpers.installation import installed
from helpers.pages import free_port, served
from helpers.places import ROOT
from helpers.waiting import PATIENCE, await_begun, await_that
from helpers.wire import Answered, Pages, ask, dialled, make_certificate, pages, request
from playwright.sync_api import Browser, expect
from websockets.exceptions import ConnectionClosed, InvalidStatus

from trainer.cli.main import cli
from trainer.config.files import ConfigError
from trainer.web.address import Address, announce_address
from trainer.web.admission import ConnectionRoom
from trainer.web.bridge import MAX_PAGES_OF_MACHINE, NO_ROOM_CODE
from trainer.web.front import EXAMPLE_URL, Front, front_of

HERE = "127.0.0.1"  # where a proxy is, in these tests
ORIGIN = "https://school.example"
CLIENT = "192.0.2.7"
WORD = "anchor-42"
PAGE = (ROOT / "docs" / "reverse-proxy.md").read_text(encoding="utf-8")


def front(url: str = EXAMPLE_URL, *proxies: str) -> Front:
    """Return what stands before the pages."""
    found = front_of(url, proxies, None)
    assert found
    return found


@contextlib.contextmanager
def behind(*proxies: str, url: str = EXAMPLE_URL) -> Iterator[Pages]:
    """Serve the pages of a stub behind proxies while the block lasts."""
    with pages(front=front(url, *proxies)) as stub:
        yield stub


# What is asked, and of whom


HOSTS = {
    "school.example": 200,
    "school.example:443": 200,
    "127.0.0.1:17880": 200,  # a proxy that puts its own address of us there
    "evil.example": 403,
    "school.example.evil": 403,
}


@pytest.mark.parametrize("host", HOSTS)
def test_a_proxy_may_keep_the_host_or_write_ours_and_no_other_passes(host: str) -> None:
    with behind() as stub:
        assert request(stub.port, "/helm", Host=host).status == HOSTS[host]


ORIGINS = {
    ORIGIN: 200,
    "http://school.example": 403,  # whoever is on the line may write such a page
    "https://school.example:8443": 403,
    "http://127.0.0.1:{port}": 403,
    "https://evil.example": 403,
    "null": 403,
}


@pytest.mark.parametrize("origin", ORIGINS)
@pytest.mark.parametrize("host", ["school.example", "127.0.0.1:{port}"])
def test_only_pages_of_the_public_address_keep_a_word_or_open_a_line(
    host: str, origin: str
) -> None:
    with behind() as stub:
        given, asked = origin.format(port=stub.port), host.format(port=stub.port)
        kept = request(stub.port, "/word", "POST", "helm x", Host=asked, Origin=given)
        assert kept.status == ORIGINS[origin]
        told = contextlib.nullcontext() if kept.status == 200 else pytest.raises(InvalidStatus)
        with told, dialled(stub.port, origin=given):
            pass


def cookie_of(url: str, path: str) -> str:
    """Return the cookie of a word that is given at a public address."""
    before = front(url)
    with behind(url=url) as stub:
        got = request(stub.port, path, "POST", "helm x", Host=before.host, Origin=before.origin)
        return got.headers["set-cookie"]


def test_the_cookie_is_for_the_public_address_alone() -> None:
    for path in ("/word", "/trainer/word"):
        cookie = cookie_of(EXAMPLE_URL, path)
        assert "Path=/trainer/line;" in cookie
        assert "Secure" in cookie
    bare = cookie_of("http://bridge:8080", "/word")
    assert "Path=/line;" in bare
    assert "Secure" not in bare


@pytest.mark.parametrize("root", ["", "/trainer"], ids=["taken away", "left there"])
def test_a_page_asks_for_what_is_below_its_own_path(root: str) -> None:
    with behind() as stub:
        html = request(stub.port, f"{root}/helm").body.decode()
        links = re.findall(r'(?:href|src)="([^"]*)"', html)
        assert not [link for link in links if link.startswith("/") or "://" in link]
        assert sum(link.startswith("./assets/") for link in links) >= 3
        for link in links:
            if link.startswith("./assets/"):
                assert request(stub.port, root + link[1:]).status == 200
        with dialled(stub.port, origin=ORIGIN):
            pass


@pytest.mark.parametrize(
    ("path", "link"),
    [("/none", "./"), ("/helm/none", "../"), ("/debrief/key/none.html", "../../")],
)
@pytest.mark.parametrize("root", ["", "/trainer"], ids=["taken away", "left there"])
def test_a_missing_page_leads_back_from_any_folder(root: str, path: str, link: str) -> None:
    with behind() as stub:
        got = request(stub.port, root + path)
    html = got.body.decode()
    assert got.status == 404
    assert f'href="{link}">Back' in html
    assert f'href="{link}assets/' in html
    assert '"./' not in html or link == "./"


def test_an_address_that_lacks_its_last_stroke_is_led_to_the_public_one() -> None:
    with behind() as stub:
        for asked, right in (("/trainer", "/trainer/"), ("/helm/", "/trainer/helm")):
            for host in ("school.example", f"{HERE}:{stub.port}"):
                got = request(stub.port, asked, Host=host)
                assert (got.status, got.headers["location"]) == (307, ORIGIN + right)


# Whom a proxy speaks for


FORWARDED = {
    CLIENT: CLIENT,
    f"127.0.0.1, {CLIENT}": CLIENT,  # the client has forged the first
    f"{CLIENT}, 127.0.0.1": CLIENT,  # two proxies, both trusted
    "10.1.2.3, 192.0.2.9": "192.0.2.9",
    "::ffff:192.0.2.7": CLIENT,
    "2001:db8::1": "2001:db8::1",
    HERE: HERE,
}


@pytest.mark.parametrize("forwarded", FORWARDED)
def test_the_last_address_that_is_no_trusted_proxy_is_the_client(forwarded: str) -> None:
    with (
        behind("127.0.0.0/8") as stub,
        dialled(stub.port, origin=ORIGIN, headers={"X-Forwarded-For": forwarded}),
    ):
        assert named_client(stub) == FORWARDED[forwarded]


def named_client(stub: Pages) -> str:
    """Return for whom the stub's session was dialled."""
    await_that(lambda: stub.sessions)
    return stub.sessions[0].recv(4096).decode().split()[2]


def test_a_stranger_who_names_a_client_is_not_believed() -> None:
    with (
        behind("10.0.0.1") as stub,
        dialled(stub.port, origin=ORIGIN, headers={"X-Forwarded-For": CLIENT}),
    ):
        assert named_client(stub) == HERE


@pytest.mark.parametrize("named", [{}, {"X_Forwarded_For": "unknown"}], ids=["none", "no address"])
def test_a_trusted_proxy_that_names_no_client_is_refused_and_told_what_it_lacks(
    named: dict[str, str],
) -> None:
    with behind(HERE) as stub:
        got = request(stub.port, "/helm", context=None, **named)
    assert got.status == 403
    assert got.body == b"the proxy names no client: let it set X-Forwarded-For\n"


def test_no_header_but_the_clients_is_believed() -> None:
    headers = {"X_Forwarded_For": CLIENT, "X_Forwarded_Host": "evil.example"}
    headers |= {"X_Forwarded_Proto": "http", "X_Forwarded_Prefix": "/evil"}
    with behind(HERE) as stub:
        got = request(stub.port, "/trainer", context=None, **headers)
    assert got.headers["location"] == EXAMPLE_URL


def test_behind_a_proxy_each_machine_has_its_own_limit_of_pages() -> None:
    with behind(HERE) as stub, contextlib.ExitStack() as stack:

        def open_page(client: str) -> int:
            named = {"X-Forwarded-For": f"{HERE}, {client}"}  # whatever the client has put before
            line = stack.enter_context(dialled(stub.port, origin=ORIGIN, headers=named))
            with contextlib.suppress(ConnectionClosed, TimeoutError):
                line.recv(0.2)
            return line.close_code or 0

        assert {open_page(CLIENT) for _ in range(MAX_PAGES_OF_MACHINE)} == {0}
        assert open_page(CLIENT) == NO_ROOM_CODE
        assert open_page("192.0.2.8") == 0
    assert any(f"{CLIENT}: 8 pages of this machine" in text for text in stub.told)


def test_the_connections_of_a_proxy_are_not_those_of_one_machine_nor_of_this_one() -> None:
    room = ConnectionRoom(here=1, elsewhere=6, machine=1)
    named = {"X-Forwarded-For": CLIENT}
    with pages(room=room, front=front(EXAMPLE_URL, HERE)) as stub, contextlib.ExitStack() as stack:
        for _ in range(room.elsewhere):
            stack.enter_context(dialled(stub.port, origin=ORIGIN, headers=named))
        assert stub.machines == {"proxies": room.elsewhere}
        assert request(stub.port, "/helm").status == 503


# Options


WRONG = {
    "--public-url school.example": "such as https://school.example/trainer/",
    "--public-url ftp://school.example/": "http or https",
    "--public-url https://school.example/?word=x": "nothing behind the path",
    "--public-url https://school.example/#x": "nothing behind the path",
    "--public-url https://me@school.example/": "a host",
    "--public-url https:///trainer/": "a host",
    "--public-url https://school.example:70000/": "--public-url https://school.example:70000/: say",
    "--public-url https://school.example/a/../b": "plain letters",
    "--public-url https://school.example/%2e/": "plain letters",
    "--public-url https://school.example/helm/": "the pages have a /helm of their own",
    "--public-url https://school.example/assets": "the pages have a /assets of their own",
    "--proxy 127.0.0.1": "--proxy 127.0.0.1: add --public-url, such as https://school.example/",
    "--public-url https://x/ --proxy bridge": "--proxy bridge: say the proxy's address or network",
    "--public-url https://x/ --proxy 10.0.0.1/24": "--proxy 10.0.0.1/24: say the proxy's address",
    "--public-url https://x/ --proxy 0.0.0.0/0": "--proxy 0.0.0.0/0: say the proxy's address",
}
BRIEF = ("serve", "--duration", "1", "--no-record", "--socket", "none")  # if it were not refused
COMMANDS = ("serve --web 127.0.0.1:0", "run --web", "web --web 127.0.0.1:0")


@pytest.mark.parametrize("words", WRONG)
def test_wrong_options_are_refused_before_anything_starts(
    words: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    for command in COMMANDS:
        with pytest.raises(ConfigError) as told:
            cli(f"{command} {words}".split(), standalone_mode=False)
        assert WRONG[words] in str(told.value)
        assert "\n" not in str(told.value)
    assert not list(tmp_path.iterdir())


def test_a_public_address_without_encryption_is_refused_beside_a_certificate() -> None:
    with pytest.raises(ConfigError, match="say https://, or no --cert"):
        front_of("http://school.example/", (), Path("cert.pem"))
    assert front_of("https://school.example/", (), Path("cert.pem"))


def test_options_of_a_proxy_without_pages_are_refused() -> None:
    for words in (["--public-url", EXAMPLE_URL], ["--proxy", HERE]):
        with pytest.raises(ConfigError, match="of pages: add --web HOST:PORT"):
            cli([*BRIEF, *words], standalone_mode=False)


def test_who_lets_browsers_in_by_a_proxy_has_to_give_a_word() -> None:
    words = [*BRIEF, "--web", "127.0.0.1:0", "--public-url", EXAMPLE_URL]
    with pytest.raises(ConfigError, match="beyond this machine only with --token WORD"):
        cli(words, standalone_mode=False)


URLS = {
    "https://school.example": "https://school.example/",
    "HTTPS://School.Example:443/Trainer": "https://school.example/Trainer/",
    "http://10.0.0.5:0080/a/b/": "http://10.0.0.5/a/b/",
    "https://[2001:db8::1]:8443/": "https://[2001:db8::1]:8443/",
}


@pytest.mark.parametrize("given", URLS)
def test_the_address_that_is_told_is_the_public_one_as_a_browser_writes_it(given: str) -> None:
    told = announce_address(Address(HERE, 17880, front=front(given)))
    assert told.startswith(f"pages at {URLS[given]}\n")
    assert "█" in told


# Behind the proxies themselves


@dataclass
class Proxied:
    """A session behind a reverse proxy."""

    port: int  # of the proxy
    pages_port: int
    context: ssl.SSLContext

    @property
    def url(self) -> str:
        """Return where browsers find the pages."""
        return f"https://{HERE}:{self.port}/trainer/"

    def request(self, path: str, method: str = "GET", body: str = "", **headers: str) -> Answered:
        """Return what comes back by the proxy."""
        return request(self.port, path, method, body, self.context, **headers)


def settings_of(program: str, places: Mapping[str, object]) -> str:
    """Return a proxy's settings as the page has them, with this test's own places."""
    text: str
    (text,) = re.findall(rf"```{program}\n(.*?)```", PAGE, re.DOTALL)
    for written, here in places.items():
        assert written in text, written
        text = text.replace(written, str(here))
    return text


def nginx_words(folder: Path, port: int, pages_port: int) -> list[str]:
    """Return the command of nginx, with the settings of the page in a file."""
    text = settings_of(
        "nginx",
        {
            "listen 443 ssl": f"listen {HERE}:{port} ssl",
            "school.example": HERE,
            "/etc/ssl/school.pem": folder / "cert.pem",
            "/etc/ssl/school.key": folder / "key.pem",
            "127.0.0.1:17880": f"{HERE}:{pages_port}",
        },
    )
    kinds = ("client_body", "proxy", "fastcgi", "uwsgi", "scgi")
    folders = "".join(f"{kind}_temp_path {folder}/{kind};\n" for kind in kinds)
    whole = f"pid {folder}/pid;\nevents {{}}\nhttp {{\naccess_log off;\n{folders}{text}}}\n"
    (folder / "nginx.conf").write_text(f"error_log stderr;\n{whole}")
    program = installed("nginx", "nginx")
    return [program, "-e", "stderr", "-c", f"{folder}/nginx.conf", "-g", "daemon off;"]


def caddy_words(folder: Path, port: int, pages_port: int) -> list[str]:
    """Return the command of caddy, with the settings of the page in a file."""
    own = f"https://{HERE}:{port} {{\n\ttls {folder}/cert.pem {folder}/key.pem"
    places = {"school.example {": own, "127.0.0.1:17880": f"{HERE}:{pages_port}"}
    text = settings_of("caddy", places)
    (folder / "Caddyfile").write_text(f"{{\n\tadmin off\n\tauto_https off\n}}\n{text}")
    return [installed("caddy", "caddy"), "run", "--config", f"{folder}/Caddyfile"]


@pytest.fixture(scope="module", params=["nginx", "caddy"])
def proxied(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[Proxied]:
    """Return a session behind each of the page's proxies, by TLS and under a path."""
    folder = tmp_path_factory.mktemp(request.param)
    cert, _ = make_certificate(folder)
    port, pages_port = free_port(), free_port()
    words = {"nginx": nginx_words, "caddy": caddy_words}[request.param](folder, port, pages_port)
    found = Proxied(port, pages_port, ssl.create_default_context(cafile=str(cert)))
    given = ("--token", WORD, "--public-url", found.url, "--proxy", HERE)
    said = folder / "said"
    with said.open("w") as heard, served(*given, port=pages_port):
        own = {"HOME": str(folder), "PATH": "/usr/bin"}
        with subprocess.Popen(words, stdout=heard, stderr=heard, env=own) as process:
            try:
                await_begun(process, lambda: answers(found), said.read_text)
                yield found
            finally:
                process.terminate()
                process.wait(PATIENCE)


def answers(found: Proxied) -> bool:
    """Return whether the pages are there by now."""
    with contextlib.suppress(OSError):
        return found.request("/trainer/").status == 200
    return False


@pytest.mark.process
def test_by_tls_and_under_a_path_pages_words_and_lines_are_there(proxied: Proxied) -> None:
    assert proxied.request("/trainer/helm").status == 200
    assert request(proxied.pages_port, "/helm").status == 403  # it is asked whom it speaks for
    led = proxied.request("/trainer")
    assert led.status in {301, 302, 307, 308}
    assert led.headers["location"] in {proxied.url, "/trainer/"}
    origin = f"https://{HERE}:{proxied.port}"
    kept = proxied.request("/trainer/word", "POST", f"helm {WORD}", Origin=origin)
    cookie = kept.headers["set-cookie"]
    assert "Secure" in cookie
    assert "Path=/trainer/line;" in cookie
    forged = proxied.request("/trainer/word", "POST", f"helm {WORD}", Origin="https://evil.example")
    assert forged.status == 403
    with dialled(
        proxied.port,
        cookies=cookie.partition(";")[0],
        scheme="wss",
        ssl=proxied.context,
        root="/trainer",
    ) as line:
        assert ask(line, "role helm")[0] == "ok"


@pytest.mark.process
def test_a_browser_works_a_station_behind_a_proxy(proxied: Proxied, browser: Browser) -> None:
    with browser.new_context(ignore_https_errors=True) as context:
        page = context.new_page()
        asked: list[str] = []
        page.on("request", lambda each: asked.append(each.url))
        page.goto(proxied.url)
        page.locator('a[data-name="helm"]').click()
        page.locator("#word input").fill(WORD)
        page.locator("#word input").press("Enter")
        expect(page.locator("#state")).to_have_text("FROZEN")
        assert all(each.startswith((proxied.url, "data:")) for each in asked), asked
