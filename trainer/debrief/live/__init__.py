"""What is judged or written beside a session that goes on.

``evaluator`` finds what can still be earned from here, ``beside`` writes a debrief. Both are
processes of their own, started by name.
"""

# The modules that other rooms may use.
__all__ = ["beside", "evaluator"]
