"""The screens: clients of the line protocol.

A screen is a process of its own and knows a session by its line alone, as a program of a user
would. Begin with ``client`` (the line kept open) and ``model`` (all that a screen knows); ``app``
shows it by ``layouts``, one a role, and ``keys``. ``drawing`` makes text of numbers.

Other rooms only start a screen: ``launch`` on a session that runs, ``own_session`` with one of its
own, after ``exercise_choice`` and if ``terminal`` says that this terminal can show one. A client
without a screen takes ``client`` and ``readings``.
"""

# The modules that other rooms may use.
__all__ = ["client", "exercise_choice", "launch", "own_session", "readings", "terminal"]
