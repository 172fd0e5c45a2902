"""The fuzzer's own bookkeeping, its examples, and what once broke a reader."""

import os
import re
import sys
from pathlib import Path
from typing import Any

import pytest
from helpers.places import TESTS
from hypothesis import given, settings
from hypothesis import strategies as st

from fuzz.catalogue import TARGETS, choose_targets, corpus
from fuzz.fuzz import Effort, Found, Tally, Target, dictionary, fuzz, only, pieces, run_round
from trainer.config.casualties import parse_casualties
from trainer.config.exercise import parse_exercise
from trainer.config.files import ConfigError
from trainer.config.sea import parse_sea
from trainer.config.vessel import parse_vessel

CORPUS = TESTS / "corpus"
FAULT = re.compile(r"[a-z]+(-[a-z]+)+")  # not the digest that a fuzzer gives
posix = pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")
each_target = pytest.mark.parametrize("target", [pytest.param(t, id=n) for n, t in TARGETS.items()])
# What a fuzzer puts into a good input.
TOKENS = [
    b'"',
    b"[",
    b"]",
    b"{}",
    b"1e999",
    b"-",
    b"\n",
    b",",
    b"=",
    b"9" * 20,
    b"nan",
    b"\0",
    b"\xff",
]


@pytest.fixture
def tally(tmp_path: Path) -> Tally:
    return Tally(tmp_path / "orders.inputs")


def told_by(program: str, found: Found, tally: Tally) -> list[int]:
    """Let a program stand for the fuzzer; return the inputs that the progress was told of."""
    seen: list[int] = []
    run_round([sys.executable, "-c", program], found, tally, lambda _, inputs: seen.append(inputs))
    return seen


@pytest.mark.process
def test_inputs_of_an_earlier_run_are_added_up(tally: Tally) -> None:
    found = Found("orders", "a line", inputs=7000)
    seen = told_by("print('#100\\tpulse  cov: 5 ft: 5 corp: 3/9b')", found, tally)

    assert seen == [7100]
    assert (found.inputs, found.paths, found.failure) == (7100, 5, "")
    assert tally.read() == 7100


def test_a_tally_that_is_no_number_is_told(tally: Tally, tmp_path: Path) -> None:
    assert tally.read() == 0
    (tmp_path / "orders.inputs").write_text("many")
    with pytest.raises(ConfigError, match=r"orders\.inputs: must hold a number; remove it"):
        tally.read()


# what stands for the fuzzer, the end of the failure that is told, and the inputs that are kept
ENDS = {
    "killed": (
        "import os; print('#8\\tNEW', flush=True); os.kill(os.getpid(), 9)",
        "killed by SIGKILL",
        8,
    ),
    "gives up": ("import sys; print('INFO: begun'); sys.exit(72)", "INFO: begun\nexit code 72", 0),
    "tries nothing": ("print('INFO: so')", "INFO: so\nit ended without an input", 0),
}


@pytest.mark.process
@posix
@pytest.mark.parametrize("end", ENDS)
def test_a_fuzzer_that_ends_too_early_says_how(end: str, tally: Tally) -> None:
    program, told, inputs = ENDS[end]
    found = Found("orders", "a line")
    told_by(program, found, tally)

    assert found.failure.endswith(told)
    assert tally.read() == inputs


@pytest.mark.process
def test_an_exception_told_beside_the_fuzzer_s_own_words_is_kept(tally: Tally) -> None:
    found = Found("orders", "a line")
    told_by(
        "import sys\n"
        "print(' === Uncaught Python exception: ===\\nValueError: here', flush=True)\n"
        "print('Test unit written to /x/crash-1', file=sys.stderr)\n"
        "sys.exit(77)",
        found,
        tally,
    )

    assert "ValueError: here" in found.failure
    assert found.saved == "/x/crash-1"


def test_without_atheris_the_words_that_install_it_are_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("fuzz.fuzz.find_spec", lambda _name: None)

    with pytest.raises(ConfigError, match="needs atheris: pip install --group fuzz"):
        list(fuzz([TARGETS["orders"]], tmp_path, Effort(1, 1, 1), 1, lambda *_: None))


@each_target
def test_no_example_is_longer_than_what_its_reader_is_fuzzed_with(target: Target) -> None:
    assert max(map(len, target.seeds())) <= target.longest


def test_a_file_in_pieces_has_each_table_with_those_inside_it() -> None:
    text = (
        'name = "it"  # so\n\n# of it\n[a]\nx = 1\n[[a.rows]]\ny = 2\n[b.c]\n[b.d]\nz = [1,\n 2]\n'
    )
    assert pieces(text) == [
        'name = "it"  # so\n',
        "[a]\nx = 1\n[[a.rows]]\ny = 2\n",
        "[b.c]\n",
        "[b.d]\nz = [1,\n 2]\n",
    ]


@pytest.mark.parametrize("name", ["vessel", "exercise", "casualties", "sea"])
def test_an_example_of_a_file_is_accepted(name: str) -> None:
    readers: dict[str, Any] = {
        "vessel": parse_vessel,
        "exercise": parse_exercise,
        "casualties": lambda text, path: parse_casualties(text, path, {}),
        "sea": parse_sea,
    }
    refused = []
    for seed in TARGETS[name].seeds():
        with only("proof.toml", seed.decode()) as path:
            try:
                readers[name](seed.decode(), path)
            except ConfigError as error:
                refused.append((seed, error))

    assert not refused


# The readers


def test_what_once_broke_a_reader_is_taken_or_refused_as_declared() -> None:
    for target in TARGETS.values():
        for data in corpus(CORPUS, target):
            target.take(data)


def test_what_once_broke_a_reader_lies_under_its_target_and_is_named_after_its_fault() -> None:
    kept = [path for path in CORPUS.rglob("*") if path.is_file()]

    assert kept
    assert {path.parent for path in kept} <= {CORPUS / name for name in TARGETS}
    assert not [path for path in kept if not FAULT.fullmatch(path.name)]


@st.composite
def spoilt(draw: st.DrawFn, target: Target) -> bytes:
    """Return one of a target's examples with a few places changed."""
    data = bytearray(draw(st.sampled_from(target.seeds())))
    for _ in range(draw(st.integers(0, 4))):
        at = draw(st.integers(0, len(data)))
        gone = draw(st.integers(0, 8))
        data[at : at + gone] = draw(st.sampled_from(TOKENS) | st.binary(max_size=4))
    return bytes(data)


@pytest.mark.long
@each_target
@settings(max_examples=15)
@given(data=st.data())
def test_a_spoilt_example_is_taken_or_refused_as_declared(
    target: Target, data: st.DataObject
) -> None:
    target.take(data.draw(spoilt(target)))


def test_a_target_that_is_none_is_told_with_the_nearest() -> None:
    with pytest.raises(ConfigError, match="no target vesel; nearest is vessel; there are: orders"):
        choose_targets(("vesel",))


def test_a_fuzzer_s_dictionary_has_the_words_of_the_seeds() -> None:
    assert dictionary([b"rudder left 15", b"\xffstep_s = 0.5"]) == '"left"\n"rudder"\n"step_s"\n'
