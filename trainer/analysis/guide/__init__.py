"""The automatic test guide of a vessel file.

Begin with ``programme``, the manoeuvres that are flown, and ``contents``, which flies and judges
all of them, and lays them beside an earlier guide; ``page`` shows it. ``trials`` reads published
figures, ``validation`` and ``verdicts`` judge by them. ``uncertainty`` says how far ours can be
trusted, ``reasons`` which dropped coefficient makes a difference.

``findings`` of 1969 flown again and the ``judged_page`` are chapters of the page alone.
"""

# The modules that other rooms may use.
# fmt: off
__all__ = [
    "contents", "page", "programme", "reasons", "trials", "uncertainty", "validation", "verdicts",
]
# fmt: on
