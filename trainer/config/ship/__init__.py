"""Surface ships and their recorded trials, read into records.

Begin with ``ship``. ``derivatives`` and ``nomoto`` are the two kinds of model, ``series`` a record,
``sensors`` what it was measured by.
"""

# The modules that other rooms may use.
__all__ = ["derivatives", "fit_options", "nomoto", "sensors", "series", "ship"]
