"""The reader of rocking trials takes what is whole, and names what is not."""

import numpy as np
import pytest
from repository import ROOT

from rockdamp.errors import InputError
from rockdamp.laboratory.trials import read_rocking_trials

FILE = ROOT / "data/measured/limestone-free-rocking.csv"
HEADER = "".join(f"# {key}: a text\n" for key in ("specimen", "source", "licence", "meaning")) + "# synthetic: no\n"
COLUMNS = "group,trial,duplicate_of_trial,thickness_m,height_m,depth_m,mass_kg,impact,ratio\n"
ROWS = ["1,1,,0.05,0.2,0.1,3.0,1,0.95", "1,1,,0.05,0.2,0.1,3.0,2,0.90", "2,1,,0.05,0.3,0.1,4.0,1,0.97"]
COPY = ["1,2,1,0.05,0.2,0.1,3.0,1,0.95", "1,2,1,0.05,0.2,0.1,3.0,2,0.90"]


def written(folder, rows, header=HEADER, columns=COLUMNS):
    (folder / "trials.csv").write_text(header + columns + "\n".join(rows) + "\n", encoding="utf-8")
    return folder / "trials.csv"


def test_the_measured_trials_are_those_that_their_header_describes():
    trials = read_rocking_trials(FILE)
    assert (trials.impacts, trials.trials, trials.duplicates) == (7545, 135, 1)
    assert trials.ratio.shape[0] == trials.geometry.size == 134
    np.testing.assert_allclose(trials.slenderness, np.arange(4, 16))
    counts = np.isfinite(trials.ratio).sum(axis=1)
    assert (np.diff(counts) <= 0).all() and counts.sum() == 7545 - 26  # those of the duplicate
    assert "10.60756/uminho-jh25" in trials.source


def test_a_trial_s_duplicate_is_left_out(tmp_path):
    trials = read_rocking_trials(written(tmp_path, [*ROWS, *COPY]))
    np.testing.assert_array_equal(trials.ratio, [[0.95, 0.90], [0.97, np.nan]])
    assert trials.geometry.tolist() == [0, 1] and trials.duplicates == 1


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"header": HEADER.replace("# licence: a text\n", "")}, "the header lacks 'licence'"),
        ({"header": HEADER.replace("synthetic: no", "synthetic: yes")}, "synthetic is 'yes'; it must be no"),
        ({"columns": COLUMNS.replace(",ratio", "")}, "the columns are"),
        ({"rows": [ROWS[0], ROWS[2], ROWS[1].replace(",2,0.90", ",3,0.90")]}, "trial 1 of group 1 are not 1, 2"),
        ({"rows": [ROWS[0].replace("0.95", "nan")]}, "ratio in row 1 is 'nan'; it must be a number"),
        ({"rows": [ROWS[0], ROWS[1].replace("0.05", "0.06")]}, "state two blocks"),
        ({"rows": [*ROWS, COPY[0], COPY[1].replace("0.90", "0.91")]}, "no duplicate of trial 1"),
        ({"rows": [*ROWS, ROWS[2].replace("2,1,,0.05", "2,2,,0.06")]}, "group 2 has blocks of two sizes"),
    ],
)
def test_what_is_not_whole_is_refused(tmp_path, change, said):
    path = written(tmp_path, **{"rows": ROWS, **change})
    with pytest.raises(InputError, match=said) as error:
        read_rocking_trials(path)
    assert "trials.csv" in str(error.value)
