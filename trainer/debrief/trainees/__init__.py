"""Runs by trainee and by class: histories, progress, comparisons, forgetting.

Begin with ``run_summary``, a run in one record, and ``history``, the runs of a folder. ``progress``
is started by name.
"""

# The modules that other rooms may use.
__all__ = ["class_page", "forgetting", "history", "progress", "progress_words"]
