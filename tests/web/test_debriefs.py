"""Debriefs are served to whom the session has told of them, and nothing else is."""

import contextlib
from collections.abc import Iterator
from pathlib import Path

import pytest
from helpers.waiting import await_that
from helpers.wire import Pages, dialled, hear, pages, request
from websockets.sync.client import ClientConnection

from trainer.io.orders.sentences import fact
from trainer.web.bridge import MAX_DEBRIEFS, DebriefShelf, leads_here
from trainer.web.gate import hash_of, policy_of

PAGE = '<h1>Debrief</h1><style>i{display:block}</style><i style="width:30%"></i><script>1</script>'


@pytest.fixture(scope="module")
def served() -> Iterator[Pages]:
    """Return the pages' server, with a stub in place of the session."""
    with pages() as each:
        yield each


@pytest.fixture
def debrief(tmp_path: Path) -> Path:
    """Return a debrief that a session has written."""
    written = tmp_path / "watch 1.branch1.html"
    written.write_text(PAGE)
    return written


@contextlib.contextmanager
def opened(served: Pages) -> Iterator[ClientConnection]:
    """Yield a page's line that has come through to the session."""
    before = len(served.sessions)
    with dialled(served.port) as line:
        await_that(lambda: len(served.sessions) != before)
        yield line


def tell(served: Pages, line: ClientConnection, *sentences: str) -> list[str]:
    """Have the session say something on a page's line; return what the page is told of pages."""
    end = served.sessions[-1]
    over = fact(9, 9.0, "over", "")
    end.sendall("".join(f"{each}\r\n" for each in (*sentences, over)).encode())
    told = []
    while (said := hear(line)) is None or said.fields[2] != "over":
        if said and said.fields[2] == "debrief-page":
            told.append(said.fields[3])
    return told


def address_of(served: Pages, line: ClientConnection, path: Path) -> str:
    """Return where a debrief is served, which is told to a page beside it."""
    (address,) = tell(served, line, fact(1, 0.5, "debrief", str(path)))
    assert address.startswith("./")
    return address[1:]


def test_a_debrief_is_served_with_its_own_styles_and_no_script(
    served: Pages, debrief: Path
) -> None:
    with opened(served) as line:
        address = address_of(served, line, debrief)
        got = request(served.port, address)

        assert got.status == 200
        assert got.body.decode() == PAGE
        policy = got.headers["content-security-policy"]
        assert policy == policy_of(PAGE)
        assert hash_of("i{display:block}") in policy
        assert hash_of("width:30%") in policy
        assert "script" not in policy
        assert "sandbox allow-popups" in policy
        assert got.headers["x-content-type-options"] == "nosniff"
        assert address_of(served, line, debrief) == address
        assert request(served.port, address, Host="evil.example").status == 403

        debrief.unlink()
        assert request(served.port, address).status == 404


def test_no_other_name_is_served(served: Pages, debrief: Path) -> None:
    secret = debrief.with_name("secret.html")
    secret.write_text("not told")
    with opened(served) as line:
        address = address_of(served, line, debrief)
    key = address.split("/")[2]
    names = [
        *("secret.html", "../secret.html", "..%2fsecret.html", "%2e%2e/secret.html"),
        *(str(secret), f"%2f{secret}", f"{debrief.name}%00", "", ".", "watch%201.branch1.HTML"),
        f"{debrief.name.replace(' ', '%20')}/../secret.html",
    ]
    for path in [f"/debrief/{key}/{name}" for name in names] + [
        *(f"/debrief/{debrief.name.replace(' ', '%20')}", f"/debrief/{'x' * 22}/{debrief.name}"),
        *("/debrief", "/debrief/", f"/debrief//{key}", f"/debrief/{key}"),
        f"/debrief/%2e%2e/{key}/secret.html",
    ]:
        got = request(served.port, path.replace(" ", "%20"))
        assert got.status == 404, path
        assert b"Back to all stations" in got.body, path
        assert b"not told" not in got.body, path


@pytest.mark.parametrize(
    "told", ["/etc/passwd", "", "watch.html", "/none/watch.html", "/*/*", "/?"]
)
def test_what_is_no_debrief_here_has_no_address(served: Pages, told: str) -> None:
    with opened(served) as line:
        assert tell(served, line, fact(1, 0.5, "debrief", told)) == []


def test_a_link_to_another_file_has_no_address(tmp_path: Path) -> None:
    link = tmp_path / "a.html"
    link.symlink_to("/etc/passwd")
    assert DebriefShelf().keep(str(link)) == ""


def test_words_about_a_debrief_are_none(served: Pages, debrief: Path) -> None:
    mark = fact(1, 0.5, "mark", f"x,debrief,{debrief}")
    broken = fact(1, 0.5, "debrief", str(debrief)).replace("*", "1*")
    with opened(served) as line:
        assert tell(served, line, mark, broken) == []


def test_a_path_beyond_plain_ascii_is_found(served: Pages, tmp_path: Path) -> None:
    folder = tmp_path / "Müller"
    folder.mkdir()
    written = folder / "Übung.html"
    written.write_text(PAGE, encoding="utf-8")
    with opened(served) as line:
        address = address_of(served, line, written)
    assert request(served.port, address).status == 200


def test_the_oldest_debrief_gives_way(tmp_path: Path) -> None:
    shelf = DebriefShelf()
    addresses = []
    for number in range(MAX_DEBRIEFS + 1):
        path = tmp_path / f"{number}.html"
        path.write_text(PAGE)
        addresses.append(shelf.keep(str(path)))
    assert len(shelf.files) == MAX_DEBRIEFS
    assert addresses[0].split("/")[2] not in shelf.files
    assert addresses[-1].split("/")[2] in shelf.files


class Far:
    """A socket whose far end is at an address."""

    def __init__(self, peer: object) -> None:
        self.peer = peer

    def getpeername(self) -> object:
        return self.peer


@pytest.mark.parametrize(
    ("peer", "here"),
    [
        *(("", True), (("127.0.0.1", 1), True), (("::1", 1, 0, 0), True)),
        *((("192.168.1.4", 1), False), (("fe80::1%eth0", 1, 0, 2), False)),
    ],
)
def test_a_session_on_another_machine_has_its_debriefs_there(peer: object, *, here: bool) -> None:
    assert leads_here(Far(peer)) is here  # type: ignore[arg-type]
