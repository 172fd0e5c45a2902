"""The drawings of a screen, as text.

Each module draws one subject of a screen from the model. Begin with ``panels``, what stands above
the charts of each station, or ``chart``. What a panel consists of (``dials``, ``values``, ``aids``,
``crew_orders``) stays here.
"""

# The modules that other rooms may use.
__all__ = [
    "alerts",
    "attitude",
    "chart",
    "evaluation",
    "event_log",
    "gauges",
    "panels",
    "plant",
    "tanks",
]
