"""The machine-code cache: never old physics, always somewhere that can be written."""

import os
import random
import shutil
import stat
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from helpers.installation import run_program

import trainer
from trainer.core import cache
from trainer.core.cache import CODE_SUFFIXES, DIGEST_SUFFIX

pytestmark = pytest.mark.process

PACKAGE = Path(trainer.__file__).parent
GAUSSIAN = """
from trainer.core.noise import gaussian
print(repr(float(gaussian(1, 2, 3))))
"""
STEP_MOTION = """
import numpy as np
from trainer.config.boat.vessel import load_vessel
from trainer.identify.boat.filter import RecordNumbers, sail_controls
from trainer.identify.boat.motion import STATE, STATE_COUNT
from trainer.identify.boat.vessel import FittedVessel

boat, state = FittedVessel(load_vessel("bb2")), np.zeros(STATE_COUNT)
state[STATE.U] = 5.0
inputs = np.array([[0.0, 0.1, 0.0, 5.0]] * 3)
record = RecordNumbers(np.zeros((0, 5)), inputs, 1.0, 1)
print(repr(float(sail_controls(boat.numbers(boat.values), record, state)[-1, STATE.Z])))
"""
CAP = """
import numpy as np
from trainer.debrief.marks.tallies import HARD, TALLY, TALLY_RULE, cap_of

rules, tallies = np.zeros(1, TALLY_RULE), np.ones(1, TALLY)
rules["measure"] = HARD
print(repr(float(cap_of(rules.view(np.recarray), tallies.view(np.recarray)))))
"""
SINE = """
import os
from pathlib import Path
from trainer.core.elementary import sine

assert abs(sine(1.0) - 0.8414709848078965) < 1e-15
folder = Path(os.environ["NUMBA_CACHE_DIR"])
print(folder)
print(len(list(folder.rglob("*.nbi"))))
"""


def said(code: str, where: Path, **environment: str) -> list[str]:
    """Return the lines a fresh interpreter prints; it imports the trainer that is in ``where``."""
    own = {"NUMBA_CACHE_DIR", "XDG_CACHE_HOME", "PYTHONPATH", "NUMBA_DISABLE_JIT"}
    kept = {name: value for name, value in os.environ.items() if name not in own}
    ran = run_program(
        [sys.executable, "-c", code], cwd=where, env=kept | {"PYTHONPATH": str(where)} | environment
    )
    return ran.stdout.splitlines()


@pytest.fixture
def copied(tmp_path: Path) -> Path:
    """Return a folder with a copy of the package, to be changed."""
    leave = shutil.ignore_patterns("__pycache__", "*.nbi", "*.nbc")
    shutil.copytree(PACKAGE, tmp_path / "trainer", ignore=leave)
    if not (PACKAGE / "configs").exists():  # in a checkout they lie beside the package
        shutil.copytree(PACKAGE.parent / "configs", tmp_path / "configs")
    return tmp_path


@pytest.mark.slow
@pytest.mark.parametrize(
    ("asked", "file", "old", "new"),
    [
        (
            GAUSSIAN,
            "core/elementary.py",
            "np.array([1.0 / (2 * k + 1)",
            "np.array([100.0 / (2 * k + 1)",
        ),
        (STEP_MOTION, "identify/boat/motion.py", "rate[STATE.Z] = ", "rate[STATE.Z] = 123.0 + "),
        (
            CAP,
            "debrief/marks/mark_numbers.py",
            "LOST_CAP, HARD_CAP = 25.0, 0.0",
            "LOST_CAP, HARD_CAP = 25.0, 7.0",
        ),
    ],
)
def test_a_number_changed_in_another_file_changes_what_a_kernel_returns(
    asked: str, file: str, old: str, new: str, copied: Path
) -> None:
    # numba looks at a kernel's own file only, and that does not change
    cache = str(copied / "cache")
    before = said(asked, copied, NUMBA_CACHE_DIR=cache)
    again = said(asked, copied, NUMBA_CACHE_DIR=cache)

    source = copied / "trainer" / file
    text = source.read_text()
    assert text.count(old) == 1
    source.write_text(text.replace(old, new))
    after = said(asked, copied, NUMBA_CACHE_DIR=cache)

    assert before == again
    assert abs(float(after[0]) - float(before[0])) > 1e-3


def test_machine_code_is_kept_in_a_folder_of_this_version_the_users_alone_and_mended(
    tmp_path: Path,
) -> None:
    # numba reads its cache folder when imported; left at that it would write beside the sources
    folder, files = said("import numba\n" + SINE, PACKAGE.parent, XDG_CACHE_HOME=str(tmp_path))
    assert Path(folder).parent == tmp_path
    assert Path(folder).name.startswith("submarine-trainer-")
    assert int(files) > 0
    assert Path(folder).stat().st_mode & 0o777 == 0o700

    Path(folder).chmod(0o775)  # as an earlier version made it where umask is 002
    (hurt,) = tmp_path.rglob(f"elementary.sine-*{CODE_SUFFIXES[0]}")
    flipped(hurt)
    damaged, again = said(TELL, PACKAGE.parent, XDG_CACHE_HOME=str(tmp_path))
    assert damaged == f"['{hurt.name}.damaged']"
    assert again == files
    assert hurt.is_file()
    assert Path(folder).stat().st_mode & 0o777 == 0o700


@pytest.mark.slow
def test_the_users_own_numba_folder_is_the_parent_also_of_a_process_it_starts(
    tmp_path: Path,
) -> None:
    folder, _ = said(SINE, PACKAGE.parent, NUMBA_CACHE_DIR=str(tmp_path / "mine"))
    child, _ = said(SINE, PACKAGE.parent, NUMBA_CACHE_DIR=folder)

    assert Path(folder).parent == tmp_path / "mine"
    assert child == folder


@pytest.mark.slow
def test_without_a_home_to_write_to_it_still_runs_and_leaves_nothing_behind(
    tmp_path: Path,
) -> None:
    (tmp_path / "file").write_text("a home below a file cannot be made, not even by root")
    temporary = tmp_path / "temporary"
    temporary.mkdir()
    home = str(tmp_path / "file" / "home")
    none = {"HOME": home, "USERPROFILE": home, "LOCALAPPDATA": home}

    folder, files = said(SINE, PACKAGE.parent, TMPDIR=str(temporary), **none)

    assert Path(folder).parent.parent == temporary
    assert int(files) > 0
    assert list(temporary.iterdir()) == []


@pytest.mark.skipif(not hasattr(os, "geteuid"), reason="owners of POSIX")
def test_a_folder_where_another_user_could_put_code_is_not_used(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "above" / "code"
    folder.mkdir(0o700, parents=True)
    planted = folder / "kernel.nbi"
    planted.write_text("planted")
    above, link = folder.parent, tmp_path / "link"
    link.symlink_to(folder)
    real = os.stat_result

    def judged(path: Path, modes: dict[Path, int], owners: dict[Path, int]) -> str:
        def seen(asked: Path, status: os.stat_result) -> os.stat_result:
            place = Path(os.path.realpath(asked))  # `resolve` asks `stat`
            mode = stat.S_IFMT(status.st_mode) | modes.get(place, stat.S_IMODE(status.st_mode))
            owner = owners.get(place, os.geteuid() if place.is_relative_to(tmp_path) else 0)
            return real((mode, *status[1:4], owner, *status[5:]))

        stat_of = Path.stat
        with monkeypatch.context() as faked:
            faked.setattr(Path, "stat", lambda each, **how: seen(each, stat_of(each, **how)))
            return cache._foreign_place(path)  # noqa: SLF001  the rule itself

    stranger = os.geteuid() + 1
    assert judged(folder, {}, {}) == ""
    assert judged(folder, {folder: 0o775, above: 0o775}, {}) == ""
    assert judged(folder, {above: 0o1777}, {}) == ""
    assert judged(folder, {above: 0o777}, {}) == f"who may write in {above}"
    assert judged(folder, {}, {above: stranger}) == f"who may write in {above}"
    assert judged(folder, {}, {folder: stranger}) == "who owns it"
    assert judged(folder, {folder: 0o777}, {planted: stranger}) == "who has left kernel.nbi"
    assert judged(link, {}, {}) == "who owns it"


@pytest.mark.skipif(not hasattr(os, "geteuid"), reason="owners of POSIX")
def test_a_shared_folder_for_code_is_told_and_code_is_made_for_this_run_alone(
    tmp_path: Path,
) -> None:
    shared, temporary = tmp_path / "shared", tmp_path / "temporary"
    temporary.mkdir()
    shared.mkdir()
    shared.chmod(0o777)
    where = {"XDG_CACHE_HOME": str(shared), "TMPDIR": str(temporary)}

    folder, files = said(SINE, PACKAGE.parent, **where)

    assert Path(folder).parent.name.startswith("trainer-private-")
    assert Path(folder).parent.parent == temporary
    assert int(files) > 0
    assert not list(shared.rglob("*.nbi"))
    assert list(temporary.iterdir()) == []


# Damage


def flipped(path: Path) -> None:
    dice = random.Random(path.name)  # noqa: S311  which bits, no secret
    data = bytearray(path.read_bytes())
    for _ in range(30):
        data[dice.randrange(len(data))] ^= 1 << dice.randrange(8)
    path.write_bytes(data)


def a_folder(path: Path) -> None:
    path.unlink()
    path.mkdir()


DAMAGE: dict[str, Callable[[Path], object]] = {
    "flipped": flipped,
    "cut": lambda path: path.write_bytes(path.read_bytes()[:-9]),
    "empty": lambda path: path.write_bytes(b""),
    "garbage": lambda path: path.write_bytes(b"cos\nsystem\n(S'exit'\ntR."),
    "a folder": a_folder,
    "without a digest": lambda path: path.with_name(path.name + DIGEST_SUFFIX).unlink(),
    "with another digest": lambda path: path.with_name(path.name + DIGEST_SUFFIX).write_text("0"),
}


TELL = SINE.replace("print(folder)", "print(sorted(p.name for p in folder.rglob('*.damaged')))")


@pytest.fixture(scope="module")
def compiled(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a cache that a first start filled, to be copied."""
    folder = tmp_path_factory.mktemp("compiled")
    assert said(TELL, PACKAGE.parent, NUMBA_CACHE_DIR=str(folder))[0] == "[]"
    return folder


@pytest.mark.slow
@pytest.mark.parametrize("ending", CODE_SUFFIXES)
@pytest.mark.parametrize("way", DAMAGE)
def test_damaged_machine_code_is_set_aside_and_compiled_again(
    compiled: Path, tmp_path: Path, way: str, ending: str
) -> None:
    shutil.copytree(compiled, tmp_path, dirs_exist_ok=True)
    cache = str(tmp_path)
    (hurt,) = tmp_path.rglob(f"elementary.sine-*{ending}")
    DAMAGE[way](hurt)

    damaged, _ = said(TELL, PACKAGE.parent, NUMBA_CACHE_DIR=cache)  # it does not fail
    assert damaged == f"['{hurt.name}.damaged']"
    again, _ = said(TELL, PACKAGE.parent, NUMBA_CACHE_DIR=cache)
    assert again == damaged  # nothing more
    assert hurt.is_file()


@pytest.mark.slow
def test_that_code_was_damaged_is_said_in_one_line(tmp_path: Path) -> None:
    cache = str(tmp_path)
    said(SINE, PACKAGE.parent, NUMBA_CACHE_DIR=cache)
    for path in [each for each in tmp_path.rglob("*") if each.suffix in CODE_SUFFIXES]:
        flipped(path)
    own = {name: value for name, value in os.environ.items() if name != "NUMBA_DISABLE_JIT"}
    ran = run_program(
        [sys.executable, "-c", SINE],
        cwd=PACKAGE.parent,
        env=own | {"PYTHONPATH": str(PACKAGE.parent), "NUMBA_CACHE_DIR": cache},
    )
    assert ran.stderr == "trainer: compiled code was damaged, and is compiled again\n"


def test_code_that_another_process_is_about_to_replace_is_not_damaged(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(cache, "_tell_damage", lambda: None)
    kept, *made = (tmp_path / name for name in ("sine.nbi", "one's", "another's"))
    made[0].write_bytes(b"old")
    cache.keep_digest(str(made[0]), str(kept))
    made[0].replace(kept)

    for path, code in zip(made, (b"new", b"newer"), strict=True):
        path.write_bytes(code)
        cache.keep_digest(str(path), str(kept))
    cache.check_digest(str(kept))
    assert kept.read_bytes() == b"old"
    for path in made:
        path.replace(kept)
        cache.check_digest(str(kept))
        assert kept.exists()

    kept.write_bytes(b"hurt")
    cache.check_digest(str(kept))
    assert not kept.exists()
