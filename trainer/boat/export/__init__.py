"""The compiled boat as a library for other programs.

Begin with ``library``, which makes the folder of an exported core; ``fmu`` makes a co-simulation
unit, ``wasm`` the module of a page, ``objects`` those of this package itself. ``targets`` are the
processors, ``header`` the records as C has them.

``lowering`` to LLVM, and the ``orders`` of a page as rows, stay here.
"""

# The modules that other rooms may use.
__all__ = ["fmu", "library", "objects", "targets", "wasm"]
