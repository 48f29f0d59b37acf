"""Free-rocking tests: displacement or rotation of a specimen that was pulled and released, without ground motion."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from rockdamp.arguments import instance
from rockdamp.arguments import path as file_path
from rockdamp.arrays import Array
from rockdamp.errors import InputError
from rockdamp.motions import record_files
from rockdamp.motions.record_files import ROCKING_COLUMNS
from rockdamp.motions.records import Sampled, read_lines, write_columns

TIME = "elapsed_s"


@dataclass(frozen=True, eq=False)
class FreeRocking(Sampled):
    """A free-rocking test, sampled uniformly in time: one or more releases, without a motion of the ground.

    Parameters
    ----------
    elapsed : ndarray, shape (samples,)
        Time, uniform to 1e-4 of a step. [s]
    displacement : ndarray, shape (samples,), optional
        Horizontal displacement at the hinge, or at the top of a parapet; the sensor's zero need not be the wall's. [m]
    rotation : ndarray, shape (samples,), optional
        Rotation of the lower body, or of a parapet, in place of the displacement. [rad]
    header : mapping of str
        What the file says of itself: specimen, source, licence, units, synthetic (yes or no), and more.
    digest : str, optional
        SHA-256 of the file that it was read from.

    Raises
    ------
    InputError
        Unless there is either a displacement or a rotation, of finite numbers at uniform times.

    Examples
    --------
    >>> import rockdamp as rd
    >>> test = rd.FreeRocking([0.0, 0.002, 0.004], [0.05, 0.05, 0.0499], header={"synthetic": "yes"})
    >>> test.step, test.synthetic
    (0.002, True)
    """

    elapsed: Array
    displacement: Array | None = None
    rotation: Array | None = None
    header: Mapping[str, str] = field(default_factory=dict)
    digest: str = field(default="", compare=False)

    def __post_init__(self) -> None:
        if (self.displacement is None) == (self.rotation is None):
            raise InputError(f"a free-rocking test must have one of {' and '.join(ROCKING_COLUMNS)}")
        names = ("elapsed", "displacement", "rotation")
        self._keep(dict(zip(names, (TIME, *ROCKING_COLUMNS), strict=True)), optional=names[1:])

    @property
    def column(self) -> str:
        """Name of the column that was measured."""
        return ROCKING_COLUMNS[0] if self.rotation is None else ROCKING_COLUMNS[1]

    @property
    def measured(self) -> Array:
        """What was measured: the displacement [m] or the rotation [rad]."""
        return self.displacement if self.displacement is not None else self.rotation  # type: ignore[return-value]


def read_free_rocking(path: str | os.PathLike[str]) -> FreeRocking:
    """Read a free-rocking test: lines ``# key: value``, then ``elapsed_s`` and ``displacement_m`` or ``rotation_rad``.

    Parameters
    ----------
    path : path-like
        A regular file, or a stream such as ``/dev/stdin``; it is read once.

    Raises
    ------
    InputError
        For whatever cannot be read or used, with the line and the file.

    Examples
    --------
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> import rockdamp as rd
    >>> with TemporaryDirectory() as folder:
    ...     path = Path(folder, "release.csv")
    ...     _ = path.write_text("# synthetic: yes\\nelapsed_s,rotation_rad\\n0,0.05\\n0.01,0.05\\n")
    ...     rd.read_free_rocking(path).rotation
    array([0.05, 0.05])
    """

    def test(lines: Sequence[str], digest: str) -> FreeRocking:
        elapsed, values, header = record_files.rocking_csv(lines)
        return FreeRocking(elapsed, *values, header, digest)

    return read_lines(file_path("path", path), "a free-rocking test as CSV", test)


def write_free_rocking(path: str | os.PathLike[str], test: FreeRocking) -> None:
    """Write a free-rocking test as CSV; reading it back gives the same numbers. The file appears whole or not at all.

    Parameters
    ----------
    path : str or path
        File to write.
    test : FreeRocking

    Raises
    ------
    InputError
        If the header cannot be written as lines ``# key: value``, or the file cannot be written.

    Examples
    --------
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> import rockdamp as rd
    >>> test = rd.FreeRocking([0.0, 0.002], displacement=[0.05, 0.05], header={"synthetic": "yes"})
    >>> with TemporaryDirectory() as folder:
    ...     rd.write_free_rocking(Path(folder, "release.csv"), test)
    ...     print(Path(folder, "release.csv").read_text(encoding="utf-8"), end="")
    # synthetic: yes
    elapsed_s,displacement_m
    0.0,0.05
    0.002,0.05
    """
    path, test = file_path("path", path), instance("test", test, FreeRocking)
    write_columns(path, test.header, {TIME: test.elapsed, test.column: test.measured})
