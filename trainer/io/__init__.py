"""The edge: codecs that see bytes, ports that move them.

Bytes come in by ``serial_line``, ``server`` with its ``connection``, or a terminal; ``lines`` makes
text of them. Each port stands behind a ``line`` with threads of its own, so that none can hold up a
tick. What a line says is an order (``orders``); what a run leaves is a ``recording``. ``client`` is
the far end, ``nmea``, ``ais`` and ``udp`` speak to instruments, ``outputs`` and ``file_lock`` write
files that are never half there. Nothing here computes a boat.

Begin with ``line``, ``orders`` and ``recording``. All modules here are open; what is kept lies
within those two packages.
"""

# The modules that other rooms may use.
# fmt: off
__all__ = [
    "ais", "chart", "client", "connection", "file_lock", "line", "lines", "machine", "mcap", "nmea",
    "noise_log", "orders", "outputs", "paths", "recording", "serial_line", "server", "sides",
    "status_line", "tables", "udp",
]
# fmt: on
