"""The crew: its orders, repeats and reports, and who mans what.

Begin with ``crew``, the talk aboard. ``manning`` knows what is worked by hand, ``watch_bill`` who
has what of it, and ``agenda`` the orders that are ahead. ``standing`` puts back the orders in force
after a jump in time.
"""

# The modules that other rooms may use.
__all__ = ["agenda", "crew", "manning", "messages", "standing"]
