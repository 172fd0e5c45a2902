"""The people at the stations: who commands, who sits where, what they are shown.

``chair`` and ``muster`` know who is attached, ``command`` which instructor has command,
``briefing`` what a newcomer is told, and ``shown`` what the screens show.
"""

# The modules that other rooms may use.
__all__ = ["briefing", "chair", "command", "muster", "shown"]
