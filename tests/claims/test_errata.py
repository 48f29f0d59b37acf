"""The errata: evidence for each, from formulas and datasets."""

import numpy as np
import pytest
from made_up_claims import ERRATA, put

from rockdamp.claims import errata
from rockdamp.errors import InputError


@pytest.fixture(scope="module")
def evidence(made_up):
    return errata.table(errata.read(ERRATA), made_up).set_index("id")["evidence"]


def test_the_errata_have_evidence_each_and_the_columns_of_the_table(made_up):
    table = errata.table(errata.read(ERRATA), made_up)
    assert list(table.columns) == ["id", "where", "printed", "used", "evidence"]
    assert list(table["id"]) == list(errata.EVIDENCE)
    assert not table["evidence"].str.contains(r"[{}]").any()


def test_evidence_of_the_formulas(evidence):
    # e of (7): 1 - 2 sin^2(atan(t/h1)) at mid-height; both impulses: (h^2 - 14 t^2)/(h^2 + 16 t^2).
    middle, both = 1 - 2 * np.sin(np.arctan(0.2)) ** 2, (16 - 14 * 0.16) / (16 + 16 * 0.16)
    for name in ("eq-7", "restitution-of-fig-4"):
        assert f"{middle:.3f} for h1/h = 0.5" in evidence[name]
    assert f"{both:.3f}" in evidence["eq-7"]
    assert "needs h1/h = 0.746" in evidence["restitution-of-fig-4"]
    assert "a2 = 0.15" in evidence["a1-of-section-7"] and "gives 0.2" in evidence["a1-of-section-7"]
    assert "counts the work of F0 2 times" in evidence["energy-of-eq-13-and-14"]
    assert "tends to -1" in evidence["hinge-ratio-of-fig-6"]
    assert "lambda of Eq. (4) is 1.5" in evidence["lambda-of-captions"]


def test_the_printed_bi_linear_law_misses_what_it_should_give_at_rest(evidence):
    """O = W, r = 0.7, no eccentricity, in W t/h: F0 = 4/r + 1/(1 - r); printed: 4/r + 1/(r (1 - r)) in the value."""
    r = 0.7
    f0, k0 = 4 / r + 1 / (1 - r), 4 / r + 2 / (1 - r)
    value, slope = (4 / r + 1 / (r * (1 - r))) / f0, (2 / r + 1 / (r * (1 - r))) / k0
    assert f"the printed law has {value:.3g} F0 at u = 0, the slope -{slope:.3g} K0" in evidence["eq-3"]
    assert "largest difference 0 F0" in evidence["eq-3"]


def test_evidence_of_the_datasets(evidence, data):
    assert "rises at 6 and falls at 0 of 6 values" in evidence["sdr-and-a1"]
    assert "from 0.5 u_ins would change by 0.333% to 2% (CDC)" in evidence["eq-17"]
    assert "-3% to -0.5% (SDR) over e from 0.7 to 0.95" in evidence["eq-17"]
    put("response_lengths", "error_rises_as_restitution_falls", [[1] * 4, [1, 1, 0, 1], [1, 0, 0, 1]])(data)
    changed = errata.table(errata.read(ERRATA), data).set_index("id")["evidence"]["err-range-and-err-e"]
    assert (
        "holds for tau 8, the second for tau 6 (CDC tau 6 to 10, CDR tau 6 to 8, SDR tau 6), both for none" in changed
    )


def test_an_erratum_without_evidence_or_with_other_gaps_is_an_error(data):
    entries = errata.read(ERRATA)
    with pytest.raises(InputError, match="erratum err-range-and-err-e is not in the data file"):
        errata.table(entries[:-1], data)
    with pytest.raises(InputError, match="erratum new has no evidence"):
        errata.table([*entries, {**entries[0], "id": "new"}], data)
    with pytest.raises(InputError, match=r"erratum eq-3: evidence has the gaps none; they must be apart"):
        errata.table([{**entries[0], "evidence": "none"}, *entries[1:]], data)
