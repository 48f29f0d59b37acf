"""Types of a quantity: an array of floats, or what NumPy makes one of."""

from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

Array: TypeAlias = NDArray[np.float64]
Quantity: TypeAlias = Any  # a number or an array of numbers; NumPy's ArrayLike has no arithmetic
