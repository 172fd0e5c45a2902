"""The stations of a session: their rights, their orders, and what each is sent.

Begin with ``station``, one line with one role, and ``roles``, the table of who may order, see and
hear what. A tick becomes a ``view``; ``channels``, ``panels`` and ``plot`` read their fields from
it; ``display`` writes them for people and programs; ``subscriptions`` send them by threads that no
tick waits for. ``event_log`` tells what happens, and of ``alerts``, which debriefs read too.
``briefing`` and ``past`` serve who comes late.

The session uses nearly all of it; ``aid_channels`` stays here.
"""

# The modules that other rooms may use.
# fmt: off
__all__ = [
    "aids", "alerts", "channels", "display", "event_log", "panels", "past", "plot", "roles",
    "station", "status", "subscriptions", "view",
]
# fmt: on
