"""The data dictionary: complete, and in step with the tables."""

from repository import ROOT

from rockdamp.pipeline import dictionary


def test_the_data_dictionary_is_in_step_with_the_tables():
    """After a change of them: `python -m rockdamp.pipeline.dictionary > results/README.md`."""
    committed = (ROOT / "results/README.md").read_text(encoding="utf-8")
    assert committed == "\n".join(dictionary.lines()) + "\n"


def test_what_uses_a_dataset_is_computed():
    assert {"accuracy", "claims", "fig3", "fig4", "report"} <= set(dictionary.used_by("damping_force"))
    assert {"match", "response_lengths", "accuracy"} <= set(dictionary.used_by("decay"))
    assert not {"fig6", "damping_force", "report"} & set(dictionary.used_by("decay"))
    assert dictionary.used_by("earthquake_records") == ["earthquakes"]
