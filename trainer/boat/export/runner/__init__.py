"""A run on an exported core, with nothing imported that it does not need.

Neither numba nor numpy, and of the standard library only what costs no time to import: no typing,
no dataclasses, no pathlib, no regular expressions.
"""
