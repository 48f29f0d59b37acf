"""Convert the coefficient of restitution of a rocking masonry wall into an equivalent viscous
damping ratio.

`__init__.pyi` lists the public names. Each is imported when it is first used, so that a program
loads what it needs.
"""

import lazy_loader

_lazy, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)


def __getattr__(name: str) -> object:
    if name == "__version__":
        from importlib.metadata import version

        return version("rockdamp")
    return _lazy(name)
