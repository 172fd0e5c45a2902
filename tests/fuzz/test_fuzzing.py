"""How a fuzzer has ended, its examples, and what once broke a reader."""

import os
import re
import sys
from pathlib import Path
from typing import Any

import pytest
from helpers.places import TESTS
from hypothesis import given, settings
from hypothesis import strategies as st

from fuzz.catalogue import TARGETS, corpus
from fuzz.fuzz import Found, Tally, Target, only, run_round
from trainer.config.boat.casualties import parse_casualties
from trainer.config.boat.vessel import parse_vessel
from trainer.config.exercise.exercise import parse_exercise
from trainer.config.files import ConfigError
from trainer.config.world.sea import parse_sea

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


def found_by(program: str, tally: Tally) -> Found:
    """Let a program stand for the fuzzer; return what it has found."""
    found = Found("orders", "a line")
    run_round([sys.executable, "-c", program], found, tally, lambda *_: None)
    return found


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
    found = found_by(program, tally)

    assert found.failure.endswith(told)
    assert tally.read() == inputs


@pytest.mark.process
def test_an_exception_told_beside_the_fuzzer_s_own_words_is_kept(tally: Tally) -> None:
    found = found_by(
        "import sys\n"
        "print(' === Uncaught Python exception: ===\\nValueError: here', flush=True)\n"
        "print('Test unit written to /x/crash-1', file=sys.stderr)\n"
        "sys.exit(77)",
        tally,
    )

    assert "ValueError: here" in found.failure
    assert found.saved == "/x/crash-1"


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
