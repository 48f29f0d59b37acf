"""The public names for type checkers and editors; a test keeps them those of `__init__.py`."""

from rockdamp.assessment.one_wall import assess as assess
from rockdamp.equivalence.closed_form import damping_ratio_energy as damping_ratio_energy
from rockdamp.equivalence.closed_form import equivalence_factor as equivalence_factor
from rockdamp.equivalence.closed_form import giannini_masiani as giannini_masiani
from rockdamp.equivalence.one_curve import Equivalent as Equivalent
from rockdamp.equivalence.one_curve import equivalent as equivalent
from rockdamp.equivalence.one_curve import equivalent_dampings as equivalent_dampings
from rockdamp.equivalence.tabulated import damping_ratio_table as damping_ratio_table
from rockdamp.equivalence.tabulated import table_refusal as table_refusal
from rockdamp.errors import InputError as InputError
from rockdamp.errors import InputWarning as InputWarning
from rockdamp.histories.labelled import free_decay as free_decay
from rockdamp.histories.labelled import respond as respond
from rockdamp.identification.calibration import calibrate as calibrate
from rockdamp.mechanics.curve import TrilinearCurve as TrilinearCurve
from rockdamp.mechanics.damping import Damping as Damping
from rockdamp.mechanics.wall import Parapet as Parapet
from rockdamp.mechanics.wall import Wall as Wall
from rockdamp.motions.catalogue import GroundMotion as GroundMotion
from rockdamp.motions.catalogue import load_records as load_records
from rockdamp.motions.intensity import IntensityMeasures as IntensityMeasures
from rockdamp.motions.intensity import intensity_measures as intensity_measures
from rockdamp.motions.intensity import spectral_acceleration as spectral_acceleration
from rockdamp.motions.records import Record as Record
from rockdamp.motions.records import read_record as read_record
from rockdamp.motions.records import write_record as write_record
from rockdamp.solvers.newmark import solve as solve
from rockdamp.solvers.newmark import stable_step as stable_step
from rockdamp.solvers.response import ComparedHistories as ComparedHistories
from rockdamp.solvers.response import Comparison as Comparison
from rockdamp.solvers.response import Histories as Histories
from rockdamp.solvers.response import Reference as Reference
from rockdamp.solvers.response import Response as Response
from rockdamp.statistics.fragility import Fragility as Fragility
from rockdamp.statistics.fragility import fit_fragility as fit_fragility

__version__: str
