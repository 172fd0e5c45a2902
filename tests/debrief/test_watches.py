"""Who had the watch at a station, from the journal to the page, and names that are forgotten."""

from pathlib import Path

import pytest
from helpers.recorded import record

from trainer.debrief.page.data import debrief_figures
from trainer.debrief.page.page import read_dossier, render
from trainer.debrief.passage.watches import Watch, named
from trainer.debrief.trainees.forgetting import forget_trainee

SAID = {
    1.0: "stern planes dive 1",
    2.0: "relief Anna Ott",
    3.0: "stern planes dive 2",
    4.0: "bow planes zero",
    5.0: "relief Berg",
    6.0: "stern planes zero",
}


@pytest.fixture(scope="module")
def relieved(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("relieved") / "depth.trainer"
    return record(path, "first-depth-change", SAID, duration=10.0)


def test_a_debrief_tells_who_had_each_watch(relieved: Path) -> None:
    debrief = read_dossier(relieved, None)
    ticks = round(1.0 / debrief.step)

    assert debrief.watches == (
        Watch("planes", "Anna Ott", 2 * ticks, 5 * ticks, 2),
        Watch("planes", "Berg", 5 * ticks, None, 1),
    )
    assert debrief_figures(debrief)["watches"][0] == {
        "role": "planes",
        "person": "Anna Ott",
        "begun_s": 2.0,
        "ended_s": 5.0,
        "orders": 2,
    }
    page = render(debrief)
    assert "<th>has the watch</th>" in page
    assert "<td>Anna Ott</td>" in page


def test_a_station_is_named_with_who_has_the_watch_then() -> None:
    stood = (Watch("planes", "Ott", 20, 50), Watch("planes", "Berg", 50), Watch("helm", "Ann", 0))

    named_then = [named(stood, "planes", tick) for tick in (19, 20, 49, 50)]

    assert named_then == ["planes", "planes (Ott)", "planes (Ott)", "planes (Berg)"]


def test_a_name_of_a_watch_is_forgotten(relieved: Path) -> None:
    list(forget_trainee("anna ott", [relieved], []))

    assert b"Ott" not in relieved.read_bytes()
    assert [each.person for each in read_dossier(relieved, None).watches][1:] == ["Berg"]
