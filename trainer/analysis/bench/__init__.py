"""The cost of the trainer on this machine: what ``trainer dev bench`` measures."""

__all__ = ["delays", "ticks"]  # the modules that other rooms may use
