"""A class of boats, timed: two boats for some seconds, and what the page says of them."""

import asyncio
import json
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner

from bench import class_boats
from bench.__main__ import bench
from bench.class_boats import BoatUse, ClassUse, lines


@pytest.mark.process
@pytest.mark.long
def test_a_class_of_two_boats_is_timed_with_its_stations() -> None:
    words = ["--class", "2", "--seconds", "3", "--json"]
    with ThreadPoolExecutor(1) as apart:  # this thread may have a browser's loop
        done = apart.submit(CliRunner().invoke, bench, words).result()
    assert done.exit_code == 0, done.stderr
    found = json.loads(done.stdout)["class"]

    assert found["stations"] == 3
    assert found["seconds"] >= 3.0
    assert found["orders"] >= 10
    assert 0.0 < found["answer_median"] <= found["answer_p95"] < 2000.0
    assert found["class_mb"] > 10.0
    assert len(found["boats"]) == 2
    for boat in found["boats"]:
        assert boat["ticks"] >= 6  # of 0.5 s
        assert boat["session_mb"] > 20.0
        assert boat["judge_mb"] > 20.0
        assert 0.0 < boat["processor"] < 100.0


def test_each_boat_gets_both_orders_however_short_the_time(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    class Planes:
        def __init__(self) -> None:
            self.asked: list[str] = []

        async def ask(self, words: str) -> None:
            self.asked.append(words)

    monkeypatch.setattr(class_boats, "ORDER_PAUSE_S", 0.0)
    planes: Any = [Planes() for _ in range(5)]

    answers = asyncio.run(class_boats.give_orders(planes, 0.0))

    assert len(answers) == 10
    assert all(tuple(each.asked) == class_boats.PLANE_ORDERS for each in planes)


def test_the_page_has_a_row_for_each_boat() -> None:
    boats = (BoatUse(0, 120, 48.2, 46.9, 1.31), BoatUse(2, 119, 49.0, 47.0, 1.4))
    page = lines(ClassUse(60.0, 3, "load", 500, 1.25, 9.94, 33.4, 0.2, boats))

    assert page[1] == "A CLASS (2 boats for 60 s, 3 stations at each)"
    assert page[3] == "  500 orders answered: median 1.2 ms, 95 % in 9.9 ms"
    assert page[-1].split() == ["2", "119", "2", "49", "47", "1.40"]


def test_a_system_that_does_not_tell_what_processes_use_leaves_it_out(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(class_boats, "PROCESS_FILE", Path("/nowhere/smaps_rollup"))
    done = CliRunner().invoke(bench, ["--class", "2", "--json"])

    assert "does not tell" in json.loads(done.output)["class"]["left_out"]
