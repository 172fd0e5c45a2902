"""The doors of a session: ports, pages, and the start of a program.

``ports`` opens serial lines and sockets, ``page_server`` the pages; ``attach`` finds a session that
runs. ``warm_up`` makes a boat ready, ``alarm`` sets a thread's timer, ``owner`` ends a session with
the program that began it.
"""

# The modules that other rooms may use.
__all__ = ["alarm", "attach", "owner", "page_server", "ports", "warm_up"]
