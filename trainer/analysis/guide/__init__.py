"""The automatic test guide of a vessel file.

Begin with ``programme``, the manoeuvres that are flown, and ``contents``, which flies and judges
all of them; ``page`` shows it, ``moves`` lays it beside an earlier one. ``trials`` reads published
figures, ``validation`` and ``verdicts`` judge by them. ``uncertainty`` says how far ours can be
trusted, ``reasons`` which dropped coefficient makes a difference.

``findings`` of 1969 flown again and the ``judged_page`` are chapters of the page alone.
"""

# The modules that other rooms may use.
# fmt: off
__all__ = [
    "contents", "moves", "page", "programme", "reasons", "trials", "uncertainty", "validation",
    "verdicts",
]
# fmt: on
