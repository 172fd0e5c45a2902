"""What nobody can do to a session, by a file, by a line or from outside: docs/threat-model.md."""

import ast
import contextlib
import functools
import hmac
import os
import socket
import stat
import subprocess
import sys
import tempfile
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from helpers.syntax import tree_of
from helpers.waiting import await_that

import trainer
from trainer.cli.main import cli
from trainer.cli.run import be
from trainer.config.boat.vessel import load_vessel
from trainer.config.files import ConfigError
from trainer.io.client import dial
from trainer.io.orders.grammar import BadOrder, Order, parse
from trainer.io.paths import DEFAULT_HOST, recording_paths
from trainer.io.serial_line import LinkError
from trainer.io.server import Server, parse_address, private_folder
from trainer.session.stations import roles
from trainer.session.stations.roles import Access, read_tokens, refuse_open_door

HOME = Path(trainer.__file__).parent
SOURCES = sorted(HOME.rglob("*.py"))


@functools.cache
def trees() -> dict[Path, ast.Module]:
    """Return what each source file says."""
    return {path: tree_of(path) for path in SOURCES}


EVIL_MODULES = {
    "pickle",
    "marshal",
    "shelve",
    "dill",
    "yaml",
    "code",
    "codeop",
    "importlib.machinery",
}
TOKEN = "a-word"  # noqa: S105 not a secret
EVIL_CALLS = {"eval", "exec", "compile", "__import__", "system", "popen", "mktemp"}
TOLD = {
    "io/recording/file.py",  # when it happened, beside the tick
    "session/past/header.py",  # when it was begun
    "io/paths.py",  # a recording's name
    "session/nmea/outlets.py",  # when the boat's own clock, sent to instruments, begins
    "cli/workshop/guide.py",  # when a guide was made
    "debrief/marks/changes.py",  # when a mark was changed
    "debrief/trainees/progress_words.py",  # how many days ago an exercise was flown
    "console/exercise_choice.py",  # likewise
    "session/exercise/training.py",  # likewise, of the next one
}
TIME_OF_DAY = {"now", "utcnow", "today", "time", "time_ns"}  # of datetime, date and time


def imports(tree: ast.AST) -> Iterator[str]:
    """Yield the modules that a source imports."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (each.name for each in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            yield node.module


def calls(tree: ast.AST) -> Iterator[tuple[str, ast.Call]]:
    """Yield the calls of a source, by the last word of what is called."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Call):
            match node.func:
                case ast.Name(name) | ast.Attribute(ast.Name("os" | "tempfile"), name):
                    yield name, node
                case _:  # a method of whatever else
                    yield "", node


# What files and lines can make it run


def test_there_are_sources_to_read() -> None:
    assert SOURCES


def test_nothing_that_is_read_can_become_code() -> None:
    for path, tree in trees().items():
        found = EVIL_MODULES & set(imports(tree))
        found |= {name for name, _ in calls(tree) if name in EVIL_CALLS}
        assert not found, path


def test_no_program_is_started_through_a_shell() -> None:
    for path, tree in trees().items():
        for _, call in calls(tree):
            assert not any(each.arg == "shell" for each in call.keywords), (path, ast.unparse(call))


def test_a_shell_is_started_by_the_proofs_alone() -> None:
    shells = {
        path.name
        for path, tree in trees().items()
        for node in ast.walk(tree)
        if isinstance(node, ast.Constant) and node.value in ("/bin/sh", "sh", "bash", "cmd")
    }
    assert shells <= {"processes.py"}


# Who may come in


@pytest.mark.parametrize("name", ["run", "serve", "resume"])
def test_nobody_beyond_this_machine_is_listened_to_unless_told(name: str) -> None:
    command = cli.commands[name]
    options: dict[str, Any] = {each.name or "": each.default for each in command.params}
    listen = options["listen"]
    assert listen is None or parse_address(str(listen), "")[0] == DEFAULT_HOST == "127.0.0.1"
    assert not options["token"]


@pytest.mark.parametrize("host", ["0.0.0.0", "::", "192.168.1.10", "bridge", ""])  # noqa: S104
def test_beyond_this_machine_a_token_is_asked_for(host: str) -> None:
    with pytest.raises(ConfigError, match="only with --token"):
        refuse_open_door("--listen", host, {})
    refuse_open_door("--listen", host, {"": "word"})


@pytest.mark.skipif(not hasattr(socket, "AF_UNIX"), reason="no local sockets here")
def test_a_local_socket_is_its_owner_s_alone(tmp_path: Path) -> None:
    path = tmp_path / "door.sock"
    hub = Server(threading.Event())
    with contextlib.closing(contextlib.ExitStack()) as stack:
        stack.callback(hub.close, 0.0)
        hub.listen_here(path)
        mode = stat.S_IMODE(path.stat().st_mode)
    assert not mode & 0o077


def another_user(code: str, path: Path) -> str:
    """Return what a program of another user prints; only the superuser can have one."""
    if sys.platform != "linux" or os.geteuid() != 0:
        pytest.skip("needs the right to be another user")
    became = "import os, socket, sys; os.setgid(65534); os.setuid(65534)\n"
    ran = subprocess.run(
        [sys.executable, "-c", became + code, str(path)],
        capture_output=True,
        text=True,
        check=False,
        timeout=60,
    )
    return ran.stdout + ran.stderr


@pytest.fixture
def common() -> Iterator[Path]:
    """Return a folder that all may write to, as the temporary one is."""
    with tempfile.TemporaryDirectory(prefix="t-") as folder:
        path = Path(folder)
        path.chmod(0o1777)
        yield path


@pytest.mark.process
def test_a_folder_that_another_user_made_is_not_listened_in(common: Path) -> None:
    another_user("os.mkdir(sys.argv[1], 0o700)", common / "ours")
    with pytest.raises(LinkError, match=r"not a folder of yours alone; remove it, or set XDG"):
        private_folder(common / "ours")


@pytest.mark.skipif(not hasattr(os, "geteuid"), reason="no users here")
def test_a_folder_that_others_may_enter_or_a_link_is_not_listened_in(common: Path) -> None:
    (common / "open").mkdir(mode=0o755)
    (common / "open").chmod(0o755)
    (common / "link").symlink_to(common)
    for name in ("open", "link"):
        with pytest.raises(LinkError, match="not a folder of yours alone"):
            private_folder(common / name)
    private_folder(common / "own" / "deeper")
    assert stat.S_IMODE((common / "own" / "deeper").stat().st_mode) == 0o700


@pytest.mark.process
def test_nothing_is_said_to_a_session_of_another_user(common: Path) -> None:
    listening = (
        "end = socket.socket(socket.AF_UNIX); end.bind(sys.argv[1]); os.chmod(sys.argv[1], 0o777)\n"
        "end.listen(); end.settimeout(30); print('listening', flush=True)\n"
        "line, _ = end.accept(); line.settimeout(30); print('heard', line.recv(100))\n"
    )
    path, said = common / "door.sock", list[str]()
    thread = threading.Thread(target=lambda: said.append(another_user(listening, path)))
    if sys.platform != "linux" or os.geteuid() != 0:
        pytest.skip("needs the right to be another user")
    thread.start()

    def is_refused() -> bool:
        with pytest.raises(LinkError) as refused:
            dial(f"local:{path}", threading.Event())
        return "that session is another user's" in str(refused.value)

    await_that(is_refused)
    thread.join()
    assert "heard b''" in said[0]


def test_each_role_has_its_own_token_or_the_one_for_all() -> None:
    asks = Access(tokens=read_tokens(("helm=anchor", "ballast=b=c", "mast")))
    given = ("anchor", "b=c", "mast", "", "helm=anchor")
    assert [word for word in given if asks.admits("helm", word)] == ["anchor"]
    assert [word for word in given if asks.admits("ballast", word)] == ["b=c"]
    assert [word for word in given if asks.admits("instructor", word)] == ["mast"]
    assert "anchor" not in asks.hide("rloe helm Anchor")
    only = Access(tokens=read_tokens(("helm=anchor",)))
    assert not any(only.admits("instructor", word) for word in given)


@pytest.mark.parametrize("given", [("helm=a", "helm=b"), ("a", "b"), ("helm=",), ("hlem=a",)])
def test_a_token_given_twice_or_none_or_for_a_role_that_is_none_is_refused(
    given: tuple[str, ...],
) -> None:
    with pytest.raises(ConfigError, match="--token"):
        read_tokens(given)


@pytest.mark.parametrize("word", ["wörd", "two words", "a#b", 'a"b', "a$b", "a*b"])
def test_a_token_that_no_order_can_hold_is_refused_at_both_ends(word: str) -> None:
    with pytest.raises(ConfigError, match="--token: a word has plain letters") as refused:
        read_tokens((f"helm={word}",))
    assert word not in str(refused.value)
    with pytest.raises(ConfigError, match="--token: a word has plain letters"):
        be("tcp://127.0.0.1:9", "helm", word, teletype=True)


def test_a_token_is_compared_in_constant_time(monkeypatch: pytest.MonkeyPatch) -> None:
    compared, compare = [], hmac.compare_digest

    def watched(given: bytes, wanted: bytes) -> bool:
        compared.append((given, wanted))
        return compare(given, wanted)

    monkeypatch.setattr(roles.hmac, "compare_digest", watched)  # type: ignore[attr-defined]
    assert not Access(tokens={"": TOKEN}).admits("helm", "another")
    assert Access(tokens={"": TOKEN}).admits("helm", TOKEN)
    assert len(compared) == 2
    assert TOKEN not in repr(Access(tokens={"": TOKEN}))


def test_one_module_alone_decides_what_a_role_may() -> None:
    deciding = {"commands", "events"}  # the parts of a role that say what it may order and hear
    elsewhere = {
        path.relative_to(HOME).as_posix()
        for path, tree in trees().items()
        for node in ast.walk(tree)
        if isinstance(node, ast.Attribute) and node.attr in deciding
        if ast.unparse(node.value).endswith("role")
    }
    assert elsewhere <= {
        "session/stations/roles.py",
        "session/stations/station.py",  # tells a role what it may order
    }


# Where files can lead


@pytest.mark.parametrize("name", ["../up", "a/b", "a\\b", ".hidden", "a.b", "C:x", "a b"])
@pytest.mark.parametrize("order", ["snapshot", "restore", "casualty", "subscribe"])
def test_no_order_can_name_a_path(order: str, name: str) -> None:
    found = parse(f"{order} {name}")
    assert isinstance(found, BadOrder) or (isinstance(found, Order) and "/" not in found.text)
    assert not isinstance(found, Order) or name == "a b" or found.subject != name


@pytest.mark.parametrize("name", ["../../etc/passwd", "/etc/passwd", "..", "a/../../b", "~/x"])
def test_a_recording_without_a_name_lies_in_its_folder_whatever_is_flown(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    path = next(recording_paths(name))
    assert path.resolve().parent == (tmp_path / "submarine-trainer" / "recordings").resolve()


@pytest.mark.parametrize("name", ["../defaults", "bb2/../../x", "vessels/bb2"])
def test_a_shipped_file_s_name_is_a_name_and_no_path(name: str) -> None:
    with pytest.raises(ConfigError):
        load_vessel(name)


# The time of day


def test_nothing_but_notes_of_when_looks_at_the_time_of_day() -> None:
    looking = {
        path.relative_to(HOME).as_posix()
        for path, tree in trees().items()
        for node in ast.walk(tree)
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute)
        if node.func.attr in TIME_OF_DAY
        if ast.unparse(node.func.value) in ("datetime", "date", "time")
    }
    assert looking <= TOLD
