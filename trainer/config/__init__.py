"""TOML files read into checked records.

A file becomes a frozen record with a unit and limits at each key, or an error that names file, key,
value, limit and the nearest name. Begin with ``schema``, which describes a record by its fields,
and ``files``, which finds and parses; then ``vessel`` and ``exercise`` as the two large examples. A
fact that several rooms need is one table: ``words``, ``condition``, ``coefficients``, the measures
in ``score_rules``.

The records are what other rooms use, so nearly all modules are open. ``similarity`` and
``sound_rows`` serve the readers alone.
"""

# The modules that other rooms may use.
# fmt: off
__all__ = [
    "ballast_records", "baseline", "bottom", "casualties", "check_case", "class_course",
    "class_file", "coefficients", "condition", "conformity", "contacts", "course", "current",
    "derivatives", "derived", "exercise", "extras", "file_schemas", "files", "fit_options", "hull",
    "loss_words", "nomoto", "outcome", "plant_records", "plausibility", "progress", "propulsion",
    "reference_crew", "schema", "score_rules", "sea", "sensors", "series", "ship", "soundings",
    "stated", "steps", "tables", "units", "vessel", "vessel_records", "vessel_template", "words",
    "world",
]
# fmt: on
