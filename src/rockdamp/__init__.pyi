"""Public names. `__init__.py` reads them here, and so do type checkers and editors."""

from .assessment.assess import assess as assess
from .equivalence.closed_form import damping_ratio_energy as damping_ratio_energy
from .equivalence.closed_form import equivalence_factor as equivalence_factor
from .equivalence.closed_form import giannini_masiani as giannini_masiani
from .equivalence.equivalent import equivalent as equivalent
from .errors import InputError as InputError
from .histories.respond import free_decay as free_decay
from .histories.respond import respond as respond
from .histories.supports import floor_motions as floor_motions
from .laboratory.calibration import calibrate as calibrate
from .laboratory.free_rocking import fit_free_rocking as fit_free_rocking
from .laboratory.free_rocking_file import FreeRocking as FreeRocking
from .laboratory.free_rocking_file import read_free_rocking as read_free_rocking
from .mechanics.curve import TrilinearCurve as TrilinearCurve
from .mechanics.damping import Damping as Damping
from .mechanics.floors import Building as Building
from .mechanics.floors import Diaphragm as Diaphragm
from .mechanics.wall import OneSidedWall as OneSidedWall
from .mechanics.wall import Parapet as Parapet
from .mechanics.wall import Wall as Wall
from .motions.catalogue import GroundMotion as GroundMotion
from .motions.catalogue import load_records as load_records
from .motions.intensity import intensity_measures as intensity_measures
from .motions.record import Record as Record
from .motions.record_file import read_record as read_record
from .motions.record_file import write_record as write_record
from .solvers.coefficient import damping_coefficient as damping_coefficient
from .solvers.exact import exact_history as exact_history
from .solvers.newmark import Histories as Histories
from .solvers.newmark import Load as Load
from .solvers.newmark import Peaks as Peaks
from .solvers.newmark import Reference as Reference
from .solvers.newmark import peaks as peaks
from .solvers.newmark import simulate as simulate
from .solvers.newmark import stable_step as stable_step
from .statistics.fragility import Fragility as Fragility
from .statistics.fragility import fit_fragility as fit_fragility

__version__: str
