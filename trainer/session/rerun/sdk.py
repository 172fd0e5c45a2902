"""The import of Rerun's library, which takes a second and may be missing.

``drawing`` takes the library from here. Two things of it are switched off. Its log would write over
the console, and exceptions tell its errors anyway. Its clean-up at the end of the program would
wait for a viewer that hangs, and who opened an outlet closes it.
"""

import os

os.environ.setdefault("RUST_LOG", "off")

import rerun as rr
import rerun.blueprint as rrb

rr.unregister_shutdown()

__all__ = ["rr", "rrb"]
