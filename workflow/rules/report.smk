"""The page that shows everything, and that of the paper alone; `snakemake --report` is apart from them."""


report: "../report/workflow.rst"


PAPER_FIGURES = [name for name, figure in FIGURES.items() if figure.number]
PAPER_DATASETS = [name for name in REPORTED if name in each_input(STAGES["claims"])]
MEASURED = [f"{RESULTS}/measured_claims.json"] if "measured_claims" in STAGES else []

# The page of the paper shows no config: another key, as of the earthquakes, does not make it run again.
for page, figures, datasets, measured, stated in (
    ("report", list(FIGURES), REPORTED, MEASURED, CONFIG.model_dump()),
    ("paper", PAPER_FIGURES, PAPER_DATASETS, [], {}),
):

    rule:
        name:
            f"{page}_page" if page == "paper" else page
        input:
            verdicts=f"{RESULTS}/claims.json",
            measured=measured,
            errata=f"{RESULTS}/errata.csv",
            figures=[f"{RESULTS}/figures/{name}.png" for name in figures],
            datasets=dataset_files(datasets),
            assumptions="docs/assumptions.md",
            citation="CITATION.cff",
        output:
            f"{RESULTS}/{page}.html",
        log:
            f"{LOGS}/{page}.log",
        params:
            figures=figures,
            datasets=datasets,
            attributes=expected_attributes,
            config=stated,
            sources=REPORT,
            version=REPORT.version(),
        message:
            "The report: claims, figures and versions on one page"
            if page == "report"
            else "The page of the paper alone: its claims and figures"
        script:
            "../scripts/report.py"


localrules:
    paper,


rule paper:
    input:
        f"{RESULTS}/paper.html",
        [f"{RESULTS}/{file}" for file in (STAGES["claims"].file, *STAGES["claims"].also)],
        [f"{RESULTS}/figures/{name}.{suffix}" for name in PAPER_FIGURES for suffix in CONFIG.figures.formats],
    message:
        "Figs 1 to 8, their datasets, the paper's claims and the page of these alone"
