"""The page of a debrief, and that to sail on from a moment.

Begin with ``data``, all that is shown; ``sections`` and ``charts`` make it HTML, which ``page``
writes. ``boat_page`` is a boat that sails on in a browser.
"""

# The modules that other rooms may use.
__all__ = ["boat_page", "data", "page"]
