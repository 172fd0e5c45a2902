"""A boat put together from its file, and the orders that it obeys.

Begin with ``assemble``, which turns a vessel file into the core's records, and ``boat``, which
ticks them; ``machine_code`` calls the compiled kernels. Orders are carried out, or refused with a
reason, by ``helm``, ``ballast_orders``, ``sea_orders`` and ``casualties``; what only writes numbers
has a row in ``effects``. ``limits``, ``depths``, ``grounding``, ``pilot`` and ``plant_alerts`` look
at each tick and call out (``calls`` says how urgent). ``reference_crew`` flies an exercise by its
rules, ``due_orders`` a boat without a session. ``readings`` are those that others are told.
``linear`` and ``stability`` judge a boat, ``plant`` what feeds it, ``safe_depth`` where it
is safe.

``world`` writes what is around the boat, ``ship`` is one that is no submarine, ``export`` makes
machine code for others. ``entries`` is the table of kernels that are called from outside.
"""

# The modules that other rooms may use.
# fmt: off
__all__ = [
    "assemble", "ballast_orders", "boat", "calls", "casualties", "compilation", "crew_hands",
    "crew_orders", "depths", "due_orders", "effects", "entries", "envelope", "export",
    "flown_ticks", "grounding", "helm", "limits", "linear", "machine_code", "mute_crew",
    "order_controls", "pilot", "plant", "plant_alerts", "plant_effects", "platforms", "quantities",
    "readings", "reference_crew", "safe_depth", "sea_orders", "ship", "stability", "world",
]
# fmt: on
