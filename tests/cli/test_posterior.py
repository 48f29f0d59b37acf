"""`calibrate --posterior` at the command line: what it asks for, prints and writes."""

import json

import numpy as np
import pytest
from click.testing import CliRunner
from made_up_posterior import PARAMETERS, made_up_posterior

import rockdamp as rd
from rockdamp.cli import main
from rockdamp.laboratory import posterior as identify
from rockdamp.statistics.distribution import Distribution
from rockdamp.storage import dataset
from rockdamp.vocabulary import CANDIDATES

WALL = ["--thickness", "0.102", "--height", "2.754"]


@pytest.fixture(scope="module")
def record(tmp_path_factory):
    path = tmp_path_factory.mktemp("posterior") / "test.csv"
    elapsed = 0.01 * np.arange(50)
    rd.write_record(path, rd.Record(elapsed, np.sin(elapsed), 0 * elapsed))
    return str(path)


@pytest.fixture
def given(monkeypatch):
    """Arguments of the posterior that the command asks for; its values are tested elsewhere."""
    asked = {}

    def posterior(record, wall, damping_model, **options):
        asked.update(records=record, wall=wall, damping_model=damping_model, **options)
        return made_up_posterior(compared=bool(options["compared"]))

    monkeypatch.setattr(identify, "posterior", posterior)
    return asked


def run(record, *options):
    return CliRunner().invoke(main, ["calibrate", "--record", record, *WALL, *map(str, options)])


def test_a_posterior_is_printed_and_written(given, record, tmp_path):
    output, plot = tmp_path / "found.nc", tmp_path / "found.png"
    result = run(record, "--posterior", "--evidence", "--json", "--output", output, "--plot", plot)
    assert result.exit_code == 0, result.output
    told, made = json.loads(result.stdout), made_up_posterior()
    assert [row["parameter"] for row in told["parameters"]] == PARAMETERS
    for row in told["parameters"]:
        of_name = made.sel(parameter=row["parameter"])
        assert row["mean"] == float(of_name["mean"])
        assert row["standard_deviation"] == float(of_name["standard_deviation"])
        assert row["interval_90"] == of_name["interval"].sel(level=0.9).values.tolist()
    assert list(told["evidence"]) == list(CANDIDATES)
    assert told["undetermined"] == {"CR": "too near to collapse"} and told["residual_rms"] == 1.5e-4
    assert told["evidence"]["CR"] is None and told["evidence"]["CDC"] == 100.0
    assert given["damping_model"] == "CR" and given["compared"] == CANDIDATES
    dataset.check(dataset.open(output), "posterior")
    assert plot.read_bytes().startswith(b"\x89PNG")


def test_a_posterior_is_told_in_a_table_with_its_effective_size(given, record):
    result = run(record, "--posterior", "--damping-model", "CDR", "--seed", 3)
    assert result.exit_code == 0, result.output
    lines = result.stdout.splitlines()
    assert lines[0] == "CDR; 90.0% of the record in its band of 90 %; 4100 effective draws"
    assert lines[2].startswith("the best fit leaves 0.15 mm, 0.75 % of the peak, 1 times the sensor's noise")
    assert lines[4].split()[:4] == ["parameter", "mean", "standard_deviation", "interval_90"]
    assert given["compared"] == () and given["seed"] == 3


def test_priors_come_from_a_file_and_what_is_wrong_there_is_named(given, record, tmp_path):
    priors = tmp_path / "priors.yaml"
    priors.write_text("restitution: {distribution: uniform, low: 0.8, high: 0.9}\n", encoding="utf-8")
    assert run(record, "--posterior", "--priors", priors).exit_code == 0
    assert given["prior"].restitution == Distribution("uniform", 0.8, 0.9)
    priors.write_text("restitutions: 0.8\n", encoding="utf-8")
    result = run(record, "--posterior", "--priors", priors)
    assert result.exit_code == 2
    assert f"{priors}: prior.restitutions is not a key" in result.stderr


def test_options_of_a_posterior_are_refused_without_it(record):
    for option in (["--evidence"], ["--damping-model", "CR"], ["--seed", "1"]):
        result = run(record, *option)
        assert result.exit_code == 2
        assert f"{option[0]} must be given with --posterior, or not at all" in result.stderr


def test_no_model_is_certain_while_the_evidence_of_another_is_missing(given, record):
    result = run(record, "--posterior", "--evidence")
    assert result.exit_code == 0, result.output
    rows = {line.split()[0]: line for line in result.stdout.splitlines()[-len(CANDIDATES) :]}
    assert rows["CR"].endswith("not determined: too near to collapse")
    assert all(line.endswith(", among those determined") for name, line in rows.items() if name != "CR")


def test_an_uncertain_size_is_a_parameter_of_the_posterior_with_a_normal_prior(given, record):
    assert run(record, "--posterior", "--hinge-ratio", "0.6±0.01").exit_code == 0
    prior = given["prior"].hinge_ratio
    assert (prior.distribution, prior.mean, prior.standard_deviation) == ("normal", 0.6, 0.01)
    assert given["prior"].sizes == ("hinge_ratio",) and float(given["wall"].hinge_ratio) == 0.6


def test_several_records_go_into_one_posterior(given, record, tmp_path):
    result = run(record, "--record", record, "--posterior", "--loss-by-run")
    assert result.exit_code == 0, result.output
    assert given["loss_by_run"] and len(given["records"]) == 2
