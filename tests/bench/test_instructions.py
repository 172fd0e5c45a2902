"""The instructions of a tick are counted the same twice, and told beside those that are kept."""

import shutil
from pathlib import Path

import pytest
from helpers.installation import installed

from bench import instructions
from bench.instructions import build_host, count
from trainer.boat import machine_code
from trainer.boat.platforms import platform_name
from trainer.config.files import ConfigError

counted = pytest.mark.skipif(
    machine_code.way_name() != "shipped" or platform_name() != instructions.MEASURED,
    reason=f"counted on {instructions.MEASURED}, of the shipped object",
)


@counted
@pytest.mark.slow
@pytest.mark.process
def test_a_count_is_exact_and_a_sea_costs_more(tmp_path: Path) -> None:
    installed("valgrind", "valgrind")
    installed("cc", "gcc libc6-dev")
    host = build_host(tmp_path)
    calm, again, rough = (
        count(host, instructions.PLACES[name]())
        for name in ("bb2, calm, 60 m", "bb2, calm, 60 m", "bb2, sea state 5, 60 m")
    )

    assert 1000 < calm == again < rough < 50_000


def test_without_valgrind_that_is_said(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(instructions, "platform_name", lambda: instructions.MEASURED)
    monkeypatch.setattr(shutil, "which", lambda _: None)

    with pytest.raises(ConfigError, match="there is no valgrind here"):
        build_host(tmp_path)
