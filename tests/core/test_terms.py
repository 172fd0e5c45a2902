"""The table of the 131 terms, and the page that is made of it."""

import re
from pathlib import Path

from helpers.document_tables import term_row
from helpers.tables_1969 import TERMS_OF_TABLES

from trainer.core.terms import (
    BASIC_DROPS,
    COEFFICIENTS,
    COMPACT_TERMS,
    EXTRA_TERMS,
    LENGTH_POWERS,
    TERM_TABLE,
    THRUST_KEYS,
)

PAGE = Path(__file__).parents[2] / "docs" / "coefficients.md"
FACTOR = re.compile(r"([uvwpqr]dot|eta|uc|d[rsb]|[uvwpqrV])(?:\^(\d))?")


def test_the_page_has_every_term() -> None:
    found = [line for line in PAGE.read_text(encoding="utf-8").splitlines() if "`" in line]
    rows = [line for line in found if line.startswith("| ") and line[3] == " "]
    assert rows == [term_row(term) for term in TERM_TABLE]


def test_the_sets_are_of_the_table() -> None:
    assert len(COEFFICIENTS) == len(LENGTH_POWERS) == 131 - len(THRUST_KEYS)
    assert set(BASIC_DROPS) < set(COMPACT_TERMS) < set(LENGTH_POWERS)
    assert set(EXTRA_TERMS) < set(LENGTH_POWERS) - set(COMPACT_TERMS)


def test_tables_6_8_and_10_of_1969_name_terms_and_the_compact_set_keeps_the_necessary() -> None:
    by_name = {term.mnemonic: term for term in TERM_TABLE}
    named = [name for names in TERMS_OF_TABLES.values() for name in names]
    necessary = [*TERMS_OF_TABLES["6"], *TERMS_OF_TABLES["8"]]
    kept = {
        table: [name for name in names if by_name[name].kept]
        for table, names in TERMS_OF_TABLES.items()
    }

    assert len(named) == len(set(named)) == 75
    assert set(named) <= set(by_name)
    assert all(by_name[name].equation in "XZM" for name in TERMS_OF_TABLES["6"])
    assert all(by_name[name].equation in "YKN" for name in TERMS_OF_TABLES["8"])
    assert [name for name in necessary if not by_name[name].kept] == []
    # of the others what Table 18 keeps
    assert kept["6, to be investigated"] == ["ZWAW", "MAWQ", "MWAW"]
    assert kept["8, to be investigated"] == ["YVAV", "KVAV", "NVAV"]
    assert kept["10"] == ["ZRR", "ZVR", "ZVV", "MRR", "MVR", "MVV", "MRP", "NPQ"]


def test_the_power_of_the_length_makes_a_force_or_a_moment() -> None:
    """rho/2 L^n times the motion is a force [N], or for K, M, N a moment [N m]."""
    for term in TERM_TABLE:
        factors = FACTOR.findall(term.multiplies)
        angular = sum(int(power or 1) for name, power in factors if name in {"p", "q", "r"})
        accelerations = [name for name, _ in factors if name.endswith("dot")]
        angular += sum(1 if name in {"udot", "vdot", "wdot"} else 2 for name in accelerations)
        assert term.power == 2 + angular + (term.equation in "KMN"), term
