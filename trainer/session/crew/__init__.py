"""The crew: its orders, repeats and reports, and who mans what.

Begin with ``crew``, the talk aboard. ``manning`` knows what is worked by hand, ``watch_bill`` who
has what of it, and ``agenda`` the orders that are ahead. ``orders_in_force`` puts back after a
jump in time what stood then.
"""

# The modules that other rooms may use.
__all__ = ["agenda", "crew", "manning", "messages", "orders_in_force"]
