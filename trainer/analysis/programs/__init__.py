"""The programs of 1969: a boat's numbers, and two runs of it compared.

Each module is one program or two, with its page; most first lines have the report's name (EC140,
ZC590, ...). Begin with ``characteristic`` (roots of the linear boat) or ``neutral`` (planes for
level flight), which other programs use as well. All modules are open to commands.
"""

# The modules that other rooms may use.
# fmt: off
__all__ = [
    "characteristic", "compare", "constants", "evaluate", "fit", "neutral", "tanks", "thrust",
]
# fmt: on
