"""An open, real-time submarine ship-control trainer.

Nothing is imported here: a run on an exported core needs neither numba nor its cache.
"""

__version__ = "0.1.0"
