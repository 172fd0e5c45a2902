"""Faults of one place, drawn by a seed, and what finds them.

``places`` reads the rooms ``session``, ``io`` and ``boat`` as syntax trees, and names each place
where a fault can be made: a comparison turned, a number off by one, a call dropped, branches
swapped. Drawn are places on lines that whole sessions by seeds execute. ``trials`` puts one fault
after the other into a copy of the tree, never into the tree itself, and asks twice whether anybody
notices: sessions by twenty seeds (``child``), and the quick tests of the fault's room.

What nothing finds has to be read. It becomes a law or a test, or it changes nothing that anybody
can see; then it is told in ``equivalent.toml``, with the reason.
"""
