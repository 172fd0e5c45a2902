"""Parameters estimated from a record: the problem, its cost, the search and where it starts.

Begin with ``problem``: which parameters are sought, from which samples; ``study_problem`` poses it
from a file, with where the search begins. ``likelihood`` has its costs, ``minimise`` and
``estimate`` the search. ``armax`` and ``nonlinear`` fit in ways of their own. All modules are open.
"""

# The modules that other rooms may use.
__all__ = ["armax", "estimate", "likelihood", "minimise", "nonlinear", "problem", "study_problem"]
