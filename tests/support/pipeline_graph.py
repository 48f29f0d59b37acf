"""Jobs of a run by the tables: from what is new, every dataset, figure and page after it."""

from collections import Counter

from rockdamp.pipeline.tables import FIGURES, STAGES, each_study, reported

PAGES = ("report", "paper_page")  # whose captions they show themselves
CHUNKS = {stage.rule: 2 for stage in STAGES.values() if stage.chunks_of}  # so many jobs of each in the minimal config


def _graph():
    """The rule and the inputs of each dataset, figure and page; studies apart."""
    graph = {}
    for stage in STAGES.values():
        for name in each_study(stage.dataset) if stage.dataset else [stage.name]:
            study = name.rpartition("/")[2]
            inputs = [one.replace("{study}", study) if "{study}" in stage.file else one for one in stage.datasets]
            graph[name] = (stage.rule, [each for one in inputs for each in each_study(one)])
    graph |= {name: (name, figure.inputs) for name, figure in FIGURES.items()}
    graph |= {"report": ("report", [*reported(STAGES.values()), *FIGURES, "claims", "measured_claims"])}
    of_paper = [name for name, figure in FIGURES.items() if figure.number]
    return graph | {"paper_page": ("paper_page", [*graph["claims"][1], *of_paper, "claims"])}


def jobs_after(*new):
    """Rules, with the number of their jobs, that run where these are new: datasets, or a stage for all of its own."""
    graph = _graph()
    waiting = [
        each for name in new for each in (each_study(STAGES[name].dataset or name) if name in STAGES else [name])
    ]
    after = set()
    while waiting:
        name = waiting.pop()
        if name not in after:
            after.add(name)
            waiting += [other for other, (_, inputs) in graph.items() if name in inputs]
    jobs = Counter(graph[name][0] for name in after)
    return dict(jobs | {rule: count for rule, count in CHUNKS.items() if rule in jobs})


def readers(changes):
    """Datasets and figures that read any key of some changes, nested as the config is."""
    keys = list(_leaves(changes))
    found = [name for name in FIGURES if _meet(keys, ["figures"])]
    for stage in STAGES.values():
        for name in each_study(stage.dataset):
            study = name.rpartition("/")[2]
            if _meet(keys, [key.replace("{study}", study) for key in stage.config]):
                found.append(name)
    return found


def _leaves(changes, path=""):
    for key, value in changes.items():
        yield from _leaves(value, f"{path}{key}.") if isinstance(value, dict) else [f"{path}{key}"]


def _meet(keys, others):
    """Return True if one of some dotted keys is one of the others, or within it."""
    return any(f"{key}.".startswith(f"{other}.") for key in keys for other in others)
