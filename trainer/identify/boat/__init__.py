"""A boat from its trials: all coefficients of its ahead range fitted to records.

Begin with ``fit``, what is done in which order, then ``prior``, ``trial``, ``search``. The model is
``regressors`` and ``motion``, the likelihood ``filter``; ``report`` judges, ``figures`` makes the
bands, ``fitted_file`` writes the boat, ``page`` shows it.
"""

# The modules that other rooms may use.
__all__ = ["figures", "fit", "instruments", "page", "report"]
