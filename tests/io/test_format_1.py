"""Recordings of format 1, in which givers, causes and repeats stand in words alone."""

import contextlib
import sqlite3
from contextlib import closing
from pathlib import Path

import pytest
from helpers.altered import alter

from trainer.io.recording import file, format_1
from trainer.io.recording.facts import (
    GUARD_GIVER,
    NO_CREW_FACT,
    REFERENCE_GIVER,
    SCHEDULE_GIVER,
    BranchCause,
    CrewFact,
    CrewNews,
    Giver,
    meeting,
    plan_of,
    station,
)
from trainer.io.recording.recording import Moment, Recording

ORDERED, REPEATED, WRONG = CrewNews.ORDERED, CrewNews.REPEATED, CrewNews.WRONG_REPEAT
SAID = (  # who, text, answer, accepted, what it is
    (
        "schedule",
        "order depth 100 m",
        "ordered: depth 100 m",
        1,
        SCHEDULE_GIVER,
        (ORDERED, "depth 100 m"),
    ),
    (
        *("diving at line 2", "depth 100 aye", "depth 100 m aye", 1),
        *(station("diving", "line 2"), (REPEATED, "depth 100 m")),
    ),
    (
        *("planes at x", "depth 90 aye", "WRONG REPEAT: depth 90; ordered is depth 100 m", 1),
        *(station("planes", "x"), (WRONG, "depth 100 m")),
    ),
    (
        *("instructor at plan 12", "casualty stern-stuck", "now", 1),
        *(plan_of("instructor", 12), NO_CREW_FACT),
    ),
    ("guard", "planes auto", "planes auto", 1, GUARD_GIVER, NO_CREW_FACT),
    ("helm meeting her", "rudder amidships", "0", 1, meeting("helm"), NO_CREW_FACT),
    ("reference crew", "order speed 99 kn", "too fast", 0, REFERENCE_GIVER, NO_CREW_FACT),
    (
        "helm at x",
        "tell look out",
        "told: look out",
        1,
        station("helm", "x"),
        (ORDERED, "look out"),
    ),
    ("helm at x", "order clear depth", "cleared", 1, station("helm", "x"), NO_CREW_FACT),
)


@pytest.fixture
def old(tmp_path: Path) -> Path:
    """Return a recording as programs of format 1 wrote it, with words of every kind."""
    path = tmp_path / "old.trainer"
    with closing(sqlite3.connect(path, isolation_level=None)) as connection:
        connection.executescript(
            file.FORMAT_SCHEMAS[1].replace("user_version = 2", "user_version = 1")
        )
        branch = "INSERT INTO branches VALUES (?, ?, ?, 0, 0, ?, ?, '')"
        connection.execute(branch, (1, None, 0, "the start", b"begun"))
        connection.execute(branch, (2, 1, 2, "backtrack 60, by instructor at x", b"back"))
        connection.execute(branch, (3, 2, 3, "not recorded after tick 9: 4 ticks lost", b"gone"))
        order = "INSERT INTO orders VALUES (?, 3, 3, ?, ?, NULL, ?, ?, '')"
        for number, (who, text, answer, accepted, *_) in enumerate(SAID, start=1):
            connection.execute(order, (number, who, text, accepted, answer))
        event = "INSERT INTO events VALUES (1, 3, 3, 'mark', 'scope at line 4', 'contact 029', '')"
        connection.execute(event)
    return path


def check_facts(recording: Recording) -> None:
    causes = [branch.cause for branch in recording.branches()]
    assert causes == [BranchCause.START, BranchCause.JUMP, BranchCause.GAP]
    orders = recording.orders(3)
    assert [order.giver for order in orders] == [said[4] for said in SAID]
    assert [tuple(order.crew) for order in orders] == [tuple(said[5]) for said in SAID]
    assert [(order.who, order.text) for order in orders] == [said[:2] for said in SAID]
    assert [event.role for event in recording.events()] == ["scope"]


def test_what_stood_in_words_is_read_as_facts(old: Path) -> None:
    before = old.read_bytes()
    with closing(Recording.look(old)) as recording:
        check_facts(recording)
    assert old.read_bytes() == before  # who looks changes nothing


def test_a_recording_that_is_gone_on_with_is_brought_to_the_format_of_today(old: Path) -> None:
    with closing(Recording.reopen(old)) as recording:
        check_facts(recording)
        number = recording.order(4, plan_of("instructor", 3), "order depth 60 m")
        recording.answered(
            number, "nach Tiefe", accepted=True, crew=CrewFact(ORDERED, "depth 60 m")
        )
        recording.fork(Moment(3, 3, b"gone", 0, 0), "zurück")
    with closing(Recording.look(old)) as recording:
        assert recording.orders(3)[-1].giver.plan == 3
        assert recording.orders(3)[-1].crew == CrewFact(ORDERED, "depth 60 m")
        assert recording.branches()[-1].cause is BranchCause.JUMP
    with closing(sqlite3.connect(old)) as connection:
        assert connection.execute("PRAGMA user_version").fetchone() == (file.FILE_FORMAT,)
        assert connection.execute("PRAGMA integrity_check").fetchone() == ("ok",)


def test_a_file_that_cannot_be_brought_up_stays_as_it_was(
    old: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(who: str) -> Giver:
        raise KeyboardInterrupt(who)

    with monkeypatch.context() as stopped, contextlib.suppress(KeyboardInterrupt):
        stopped.setattr(format_1, "giver_of", broken)
        Recording.reopen(old)
    with closing(Recording.look(old)) as recording:
        check_facts(recording)


TEXTS = ("orders.who", "orders.text", "orders.answer", "events.who", "branches.why")


@pytest.mark.parametrize("place", TEXTS)
@pytest.mark.parametrize("format_number", [1, 2])
def test_a_text_that_is_none_is_damage_to_whoever_goes_on_or_reads_and_changes_nothing(
    old: Path, place: str, format_number: int
) -> None:
    if format_number == file.FILE_FORMAT:
        Recording.reopen(old).close()
    table, _, column = place.partition(".")
    with closing(sqlite3.connect(old, isolation_level=None)) as connection:
        connection.execute(f"UPDATE {table} SET {column} = x'ff00' WHERE id = 1")
        before = list(connection.iterdump())

    for opens in (Recording.reopen, Recording.look):
        with (
            pytest.raises(file.RecordingError, match=r"is damaged: a (text|value)"),
            closing(opens(old)) as read,
        ):
            check_facts(read)
    with closing(sqlite3.connect(old, isolation_level=None)) as connection:
        assert list(connection.iterdump()) == before
        assert connection.execute("PRAGMA user_version").fetchone() == (format_number,)


def test_a_remark_that_is_no_text_is_damage_to_whoever_forgets_a_name(old: Path) -> None:
    alter(old, "UPDATE events SET text = x'6d61726b20'")  # "mark "
    with pytest.raises(file.RecordingError, match="is damaged: a text"):
        file.erase_texts(old, {}, str.upper)


@pytest.mark.parametrize(
    "change",
    [
        "UPDATE orders SET giver = 'a ghost'",
        "UPDATE orders SET crew_news = 'none'",
        "UPDATE branches SET cause = ''",
        "UPDATE orders SET plan = 'x'",
    ],
)
def test_a_fact_of_no_kind_is_damage(old: Path, change: str) -> None:
    Recording.reopen(old).close()
    alter(old, change)
    with (
        pytest.raises(file.RecordingError, match="is damaged"),
        closing(Recording.look(old)) as read,
    ):
        check_facts(read)
