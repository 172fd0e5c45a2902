"""Tables that documents have from code are those that the code makes now."""

import pytest
from helpers.made_pages import MADE, SHOWN, words_by_hand
from helpers.places import ROOT

from trainer.io.orders.grammar import MAX_LINE_LETTERS
from trainer.io.orders.sentences import MAX_ANSWER_LETTERS

WORDS_BY_HAND = 70_000  # that a maintainer reads and keeps true
JOBS = {  # by the page that a job is done with, how many words it may have
    "engineer.md": 3_000,
    "identification.md": 1_500,
    "instructor.md": 900,
    "teachers.md": 900,
}


@pytest.mark.parametrize(
    ("module", "page", "table"),
    [(module, page, table) for (module, page), tables in SHOWN.items() for table in tables],
)
def test_a_page_has_the_table_that_is_made(module: str, page: str, table: str) -> None:
    text = (ROOT / "docs" / page).read_text(encoding="utf-8")

    assert MADE[module][table]() in text, f"renew: python -m helpers.{module} {table}"


@pytest.mark.parametrize("module", MADE)
def test_every_table_that_is_made_is_in_a_page(module: str) -> None:
    shown = [table for (by, _), tables in SHOWN.items() if by == module for table in tables]

    assert sorted(shown) == sorted(MADE[module])


def test_the_page_of_orders_says_how_long_a_line_may_be() -> None:
    text = " ".join((ROOT / "docs" / "orders.md").read_text(encoding="utf-8").split())

    assert f"An order is one line of at most {MAX_LINE_LETTERS} characters" in text
    assert (
        f"A line in has at most {MAX_LINE_LETTERS} characters, a line out {MAX_ANSWER_LETTERS}."
        in text
    )


def test_the_documents_have_no_more_words_by_hand_than_can_be_kept_true() -> None:
    assert sum(words_by_hand().values()) <= WORDS_BY_HAND, "python -m helpers.made_pages"


@pytest.mark.parametrize("page", JOBS)
def test_a_job_is_done_with_a_page_that_is_short(page: str) -> None:
    assert words_by_hand()[page] <= JOBS[page]
