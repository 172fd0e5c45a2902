"""The fuzzer's own bookkeeping, and the examples that it begins with."""

import os
import sys
from pathlib import Path
from typing import Any

import pytest

from trainer.config.casualties import parse_casualties
from trainer.config.exercise import parse_exercise
from trainer.config.files import ConfigError
from trainer.config.sea import parse_sea
from trainer.config.vessel import parse_vessel
from trainer.verify.fuzz.catalogue import TARGETS
from trainer.verify.fuzz.fuzz import Found, Tally, Target, only, pieces, run_round

posix = pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")
each_target = pytest.mark.parametrize("target", [pytest.param(t, id=n) for n, t in TARGETS.items()])


@pytest.fixture
def tally(tmp_path: Path) -> Tally:
    return Tally(tmp_path / "orders.inputs")


def told_by(program: str, found: Found, tally: Tally) -> list[int]:
    """Let a program stand for the fuzzer; return the inputs that the progress was told of."""
    seen: list[int] = []
    run_round([sys.executable, "-c", program], found, tally, lambda _, inputs: seen.append(inputs))
    return seen


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


@posix
def test_a_fuzzer_that_was_killed_says_by_which_signal(tally: Tally) -> None:
    found = Found("orders", "a line")
    told_by("import os; print('#8\\tNEW', flush=True); os.kill(os.getpid(), 9)", found, tally)

    assert found.failure.endswith("killed by SIGKILL")
    assert tally.read() == 8


def test_a_fuzzer_that_gives_up_says_with_which_exit_code(tally: Tally) -> None:
    found = Found("orders", "a line")
    told_by("import sys; print('INFO: begun'); sys.exit(72)", found, tally)

    assert found.failure == "INFO: begun\nexit code 72"


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


def test_a_fuzzer_that_tried_nothing_has_failed(tally: Tally) -> None:
    found = Found("orders", "a line")
    told_by("print('INFO: nothing to do')", found, tally)

    assert found.failure == "INFO: nothing to do\nit ended without an input"


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
