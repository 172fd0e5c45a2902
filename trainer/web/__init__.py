"""Stations in a browser: pages, and the server that carries their lines to a session.

The server is a process of its own, which dies or hangs without the session. Begin with ``server``
(pages, tokens, files) and ``bridge`` (a page's line, both ways); ``gate`` and ``admission`` say who
may ask and who may stay, ``front`` what a proxy before them changes. ``pages`` and ``words`` make
the HTML, ``packing`` and ``modules`` its scripts, which lie in ``assets/js``: ``protocol``,
``model``, ``tab``, elements, ``stations``.

Other rooms start the server by ``launch`` and ``front``, or make a page a file by ``single_file``.
A class makes its own pages, and those of its boats, of the same parts.
"""

# The modules that other rooms may use.
# fmt: off
__all__ = [
    "address", "admission", "bridge", "front", "gate", "launch", "packing", "pages", "server",
    "single_file",
]
# fmt: on
