"""What tables of the 1969 report hold: names of terms, and words of its program.

The column of docs/coefficients.md, the footprint and their tests take them from here.
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


# Table 16: the compact program on the 16-bit machine, in words
CORE_WORDS: Final = {
    "UPDATE": 1253,
    "SQRT and SIN/COS": 317,
    "floating point": 664,
    "data transfer": 130,
    "COMMON": 268,
}
