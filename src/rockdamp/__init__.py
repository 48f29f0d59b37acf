"""Convert the coefficient of restitution of a rocking masonry wall into an equivalent viscous damping ratio.

The names that this package offers stand in `__init__.pyi`. Each is imported when it is first used, so that a program
loads only what it needs. So does the command line, which must import little before it can end by Ctrl-C.
"""

import lazy_loader

_imported, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)


def __getattr__(name: str) -> object:
    if name == "__version__":
        from importlib.metadata import version

        return version("rockdamp")
    try:
        return _imported(name)
    except AttributeError:
        if name in __all__:  # its own module is at fault
            raise
        from difflib import get_close_matches

        near = " or ".join(get_close_matches(name, __all__, 3))
        slip = f": did you mean {near}?" if near else "; dir(rockdamp) lists its names"
        raise AttributeError(f"rockdamp has no {name!r}{slip}") from None
