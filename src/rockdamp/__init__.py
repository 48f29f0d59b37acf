"""Convert the coefficient of restitution of a rocking masonry wall into an equivalent viscous damping ratio.

The names that this package offers stand in `__init__.pyi`. Each is imported when it is first used, so that a program
loads only what it needs.
"""

from importlib.metadata import version

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
__version__ = version("rockdamp")
