"""TOML files read into checked records.

A file becomes a frozen record with a unit and limits at each key, or an error that names file, key,
value, limit and the nearest name. Begin with ``schema``, which describes a record by its fields,
and ``files``, which finds and parses; then ``boat`` and ``exercise`` as the two large examples. A
fact that several rooms need is one table: ``words``, ``units``, and in the rooms ``condition``,
``coefficients``, the measures in ``score_rules``.
"""

# The modules and rooms that other rooms may use.
# fmt: off
__all__ = [
    "boat", "exercise", "extras", "files", "keywords", "schema", "ship", "tables", "units", "words",
    "world",
]
# fmt: on
