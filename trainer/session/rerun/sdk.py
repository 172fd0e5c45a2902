"""Rerun's library is imported where it is needed. It takes a second, and is not always there.

Its own log is silenced, which would run over the console; what goes wrong is told by exceptions.
So is its clean-up at the end of the program, which waits for a viewer that hangs for as long as
that does: each outlet is closed by whoever opened it.
"""

import os

os.environ.setdefault("RUST_LOG", "off")

import rerun as rr
import rerun.blueprint as rrb

rr.unregister_shutdown()

__all__ = ["rr", "rrb"]
