"""Convert the coefficient of restitution of a rocking masonry wall into an equivalent viscous damping ratio.

The names that this package offers stand in `__init__.pyi`. Each is imported when it is first used, so that a program
loads only what it needs. So does the command line, which must import little before it can end by Ctrl-C.
"""

from collections.abc import Callable
from functools import wraps
from types import FunctionType
from typing import Any

import lazy_loader

_imported, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)


SYMBOLS = {"a1": "yield_displacement_ratio", "b1": "strength_ratio", "a3": "ultimate_displacement_ratio"}
SYMBOLS |= {"e": "restitution", "xi": "damping_ratio", "g": "exponent", "t": "thickness", "h": "height"}


def __getattr__(name: str) -> object:
    if name == "__version__":
        from importlib.metadata import version

        return version("rockdamp")
    try:
        globals()[name] = found = _answering(_imported(name))
    except AttributeError:
        if name in __all__:  # its own module is at fault
            raise
        slip = _near(name, __all__) or "; dir(rockdamp) lists its names"
        raise AttributeError(f"rockdamp has no {name!r}{slip}") from None
    return found


def _near(name: str, names: list[str]) -> str:
    """Return a question with the names that are near to one, or what the symbol of a quantity stands for."""
    from difflib import get_close_matches

    alike = get_close_matches(name, names, 3) or [each for each in names if len(name) > 3 and name in each]
    near = " or ".join(alike if SYMBOLS.get(name) not in names else [SYMBOLS[name]])
    return f": did you mean {near}?" if near else ""


def _answering(found: Any) -> Any:
    """Let a public function, or class, answer a call with wrong arguments by those that it takes."""
    if isinstance(found, type):
        for name, member in vars(found).copy().items():
            if isinstance(member, classmethod) and not name.startswith("_"):
                setattr(found, name, classmethod(_with_arguments(member.__func__)))
        if isinstance(vars(found).get("__init__"), FunctionType):
            setattr(found, "__init__", _with_arguments(vars(found)["__init__"]))  # noqa: B010
        return found
    if not isinstance(found, FunctionType):
        return found
    public = _with_arguments(found)
    public.__module__ = __name__  # where pickle finds it
    return public


def _with_arguments(function: Callable[..., Any]) -> Callable[..., Any]:
    @wraps(function)
    def answer(*values: Any, **named: Any) -> Any:
        try:
            return function(*values, **named)
        except TypeError as error:
            if error.__traceback__ is None or error.__traceback__.tb_next is not None:  # it was called
                raise
            from inspect import signature

            takes = [name for name in signature(function).parameters if name not in ("self", "cls")]
            slip = next((_near(name, takes) for name in named if name not in takes), "")
            said = str(error).replace(".__init__()", "()")
            raise TypeError(f"{said}{slip}; its arguments are {', '.join(takes)}") from None

    return answer
