"""A rocking block of discrete elements, in Yade: what its local damping and ECD of order 16 lose in each half cycle.

`make test-peers` runs this where Yade is installed (Debian: yade). examples/yade/block.py is the model.
"""

import math
import re
import shutil
import subprocess

import numpy as np
import pytest
from repository import ROOT

pytestmark = pytest.mark.peers
PAGE = (ROOT / "docs/howto/order-m-damper-elsewhere.md").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def kept(tmp_path_factory):
    """Return sqrt(V) of each peak over the one before, by damping."""
    program = shutil.which("yade")
    if not program:
        pytest.skip("Yade is not installed (Debian: yade)")
    command = [program, "-n", "-x", ROOT / "examples/yade/block.py"]
    run = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path_factory.mktemp("yade"), timeout=300)
    rows = re.findall(r"^(none|local damping, \S+|order 16)(?:ln e\))?.*?:((?: [\d.]+)+)$", run.stdout, re.MULTILINE)
    assert len(rows) == 4, run.stdout + run.stderr
    return [np.array(numbers.split(), dtype=float) for _, numbers in rows]


def mean(ratios):
    return math.exp(np.log(ratios).mean())


def test_the_joint_s_damper_loses_e_and_local_damping_more(kept):
    none, local, fifth, order_16 = kept
    np.testing.assert_allclose(none, 1, atol=0.01)  # the contacts lose nothing
    np.testing.assert_allclose(order_16, 0.85, atol=0.03)
    assert mean(order_16) == pytest.approx(0.85, abs=0.01)
    # It acts on each component of the body's force, not on the joint's: more than tanh(-ln e) is meant to take.
    assert 0.80 < mean(local) < 0.84
    assert mean(fifth) < math.sqrt((1 - 0.2) / (1 + 0.2)) < mean(local)
    for ratios in (local, fifth, order_16):
        assert f"{mean(ratios):.2f}" in PAGE[PAGE.index("*A rocking block in Yade.*") :].split("\n\n")[0]
