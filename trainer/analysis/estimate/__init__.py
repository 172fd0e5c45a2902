"""A boat from the drawing of its hull, with a deviation on each coefficient.

Begin with ``coefficients``, the method part by part, on the ``geometry`` of the hull; both stay
here. ``boat_file`` writes the vessel file, ``survey`` says how the boat would behave, ``page``
shows it. ``uncertainty`` draws whole sets of coefficients, for guides and sweeps too.
"""

# The modules that other rooms may use.
__all__ = ["boat_file", "page", "survey", "uncertainty"]
