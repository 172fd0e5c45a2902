"""Vessel files and what they consist of, read into records; casualties too.

Begin with ``vessel``, a file read and checked. ``vessel_records`` has its tables, ``coefficients``
the names of the equations, ``hull`` a boat of one's own by ``similarity``; ``plausibility`` says
what is odd in one.
"""

# The modules that other rooms may use.
# fmt: off
__all__ = [
    "ballast_records", "casualties", "coefficients", "hull", "plant_records", "plausibility",
    "propulsion", "vessel", "vessel_records", "vessel_template",
]
# fmt: on
