"""Open benchmark of thermal radiance above clouds in three dimensions: cases as files, models, scores."""

from hcss_light.cases.case import FOLDER, Case, case_names, load_case, read_case
from hcss_light.cases.models import MODELS
from hcss_light.cases.scores import Score, entry, read_results, score, scores, scores_of_results, table

__all__ = [
    "FOLDER",
    "MODELS",
    "Case",
    "Score",
    "case_names",
    "entry",
    "load_case",
    "read_case",
    "read_results",
    "score",
    "scores",
    "scores_of_results",
    "table",
]
