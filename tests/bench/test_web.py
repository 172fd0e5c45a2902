"""Stations in a browser, timed: one short run within ten times each goal."""

import json
import re
from typing import Any

import pytest
from click.testing import CliRunner
from helpers.pages import find_chromium

from bench import web
from bench.__main__ import bench
from trainer.session.time.ledger import Spread

SPREAD = Spread(1_000, 2_000, 3_000, 4_000)


TRIES = 3  # a machine that others use may be held up once


def measured() -> dict[str, Any]:
    """Return the figures of the shortest run: a few seconds beside starting and stopping."""
    done = CliRunner().invoke(bench, ["--web", "--seconds", "2", "--json"])
    assert done.exit_code == 0, done.stderr
    found: dict[str, Any] = json.loads(done.stdout)["web"]
    return found


def beyond(found: dict[str, Any]) -> list[str]:
    """Return the figures that are not within ten times their goals."""
    seen, attended = found["looking"], found["attended"]
    bounds = {
        "first_picture": (seen["first_picture"], 5_000.0),
        "answer_median": (seen["answer_median"], 50.0),
        "answer_p95": (seen["answer_p95"], 100.0),
        "pixel_p95": (seen["pixel_p95"], 500.0),
        "ticks missed": (attended["missed"], 1),
        "lateness [ns]": (attended["lateness"]["p999_ns"], 0.5e9),
    }
    return [f"{name}: {is_} > {most}" for name, (is_, most) in bounds.items() if is_ > most]


@pytest.mark.process
@pytest.mark.slow
def test_stations_in_a_browser_are_within_ten_times_the_goals() -> None:
    find_chromium()

    for _ in range(TRIES):
        found = measured()
        seen, attended = found["looking"], found["attended"]
        assert seen["first_picture"] > 0.0
        assert 0.0 < seen["answer_median"] <= seen["answer_p95"]
        assert seen["answer_median"] < seen["pixel_p95"]
        assert (seen["loads"], seen["orders"]) == (2, 20)
        assert attended["stations"] == 30
        assert attended["ticks"] >= 4
        if not beyond(found):
            return
    pytest.fail("; ".join(beyond(found)))


def test_a_long_run_measures_more() -> None:
    assert web.Effort.of(60.0) == web.Effort(5, 200, 100, 2000)
    assert web.Effort.of(2.0).orders < 60


def test_the_page_names_each_figure_with_its_goal() -> None:
    looking = web.PageDelay("Chromium 1", 5, 200.0, 60, 4.0, 9.0, 8.0, 20.0, 19.9, 0.3, 0.5)
    figures = web.WebFigures(
        looking, web.WebTicks(0, 120, 0, SPREAD), web.WebTicks(30, 121, 1, SPREAD), "load"
    )

    page = "\n".join(web.lines(figures))

    assert "first picture    median 200 ms of 5 (500)" in page
    assert "order to answer  median 4.0 ms (5), 95 % 9.0 ms (10), 60 orders" in page
    assert "pictures         19.9 a second (20); script median 0.30 ms" in page
    assert re.search(r"30 stations +median +1\.0, 99 % +2\.0, 99\.9 % +3\.0, most +4\.0 us\n", page)
    assert "missed: 0 of 120 alone, 1 of 121 with stations (0)" in page
    assert page.endswith("  load")


def test_without_a_browser_the_bench_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(web, "find_browser", lambda: None)

    done = CliRunner().invoke(bench, ["--web"])

    assert done.exit_code == 0
    assert done.stdout == "tests.bench --web needs Chromium: install the package chromium\n"
