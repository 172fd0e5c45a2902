"""What tables of the 1969 report hold, by content: names of terms, and printed figures.

The page of the report, the column of docs/coefficients.md and their tests take them from here.
Names are as printed; those that the scan misread are as ``core.terms`` has them.
"""

from typing import Final

# fmt: off
TERMS_OF_TABLES: Final = {  # by table and part
    "6": (  # longitudinal, necessary
        "XUD", "XDSDS", "XDBDB", "ZQD", "ZWD", "ZQ", "ZSTR", "ZW", "ZDS", "ZDB",
        "MQD", "MWD", "MQ", "MSTR", "MW", "MDS", "MDB",
    ),
    "6, to be investigated": (
        "XQQ", "XWQ", "XWW", "ZAQDS", "ZWAQ", "ZWAW", "MAQDS", "MAWQ", "MWAW",
    ),
    "8": (  # lateral, necessary
        "YRD", "YPD", "YVD", "YR", "YP", "YV", "YDR", "KRD", "KPD", "KVD", "KP", "KV",
        "NRD", "NPD", "NVD", "NR", "NP", "NV", "NDR",
    ),
    "8, to be investigated": (
        "YARDR", "YVAR", "YVAV", "KPAP", "KVAV", "NARDR", "NAVR", "NVAV",
    ),
    "10": (  # cross-coupling that is not zero
        "XRR", "XRP", "XVR", "XVV", "YPQ", "YWP", "YVW", "ZRR", "ZVR", "ZVV", "ZRP", "ZVP",
        "KQR", "KWP", "MRR", "MVR", "MVV", "MVP", "MRP", "NPQ", "NWP", "NVW",
    ),
}
# fmt: on


def table_of(mnemonic: str) -> str:
    """Return in which of tables 6, 8 and 10 a term stands, and its part; "" if in none."""
    found = [table for table, names in TERMS_OF_TABLES.items() if mnemonic in names]
    return "; ".join(found)


# Tables 12 and 13: change of change [%] of u, theta, z in an overshoot, deep to surface
NEAR_SURFACE: Final = {  # by speed [kn]
    6.0: (7.7, -1.1, -4.3),
    12.0: (13.0, 3.7, 10.9),
}
NEAR_SURFACE_STARS_DEEP: Final = (3.6, 1.1, 1.3)  # at 12 kn, Z* and M* those of deep water
# Table 16: the compact program on the 16-bit machine, in words
CORE_WORDS: Final = {
    "UPDATE": 1253,
    "SQRT and SIN/COS": 317,
    "floating point": 664,
    "data transfer": 130,
    "COMMON": 268,
}
HOST_WORDS: Final = {"MAIN": 417, "FORTRAN I/O": 1698, "error check": 215}
# Table 17: computers with 4K words and a teletypewriter, or 8K, in dollars of 1969
COMPUTER_DOLLARS: Final = {
    "Varian 620i": 14_500,
    "DataMate 8 (8K)": 15_000,
    "HP 2114A": 12_000,
    "Interdata 3": 11_200,
    "NOVA": 10_000,
    "MAC 16 (8K)": 12_000,
}


def three_figures(figures: tuple[float, float, float]) -> str:
    """Return per cent of u, theta and z as the page has them: ``7.7, -1.1, -4.3``."""
    return ", ".join(f"{figure:.1f}" for figure in figures)


def words_in_parts(words: dict[str, int]) -> str:
    """Return the parts of a program with their words, and the sum."""
    return ", ".join(f"{name} {count}" for name, count in words.items()) + (
        f": {sum(words.values())}"
    )
