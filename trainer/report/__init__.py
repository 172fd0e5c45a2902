"""Pages and plots.

What every page is made of: ``text`` for a terminal, ``html`` with its templates, ``columns`` with
their units, ``pdf`` by a browser; ``progress`` is told meanwhile. Begin with ``plots``, which says
what is drawn, and draws it by matplotlib; ``panels`` draws the same as SVG by ``svg``. The room
knows numbers and texts, never a boat, so that each program can use it. All modules are open.
"""

# The modules that other rooms may use.
__all__ = ["columns", "html", "panels", "pdf", "plots", "progress", "svg", "text"]
