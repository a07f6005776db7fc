"""Verdicts on how ``hcss import`` takes an image.

Each image is imported by Otsu's method without cleaning, so that its coverage is that of the file. A good one is
*refused* if there is an error, *questioned* if a note has a question mark or names missing pixels that the file does
not declare, and *wrong* if its coverage, its sense or its missing pixels differ from what is known independently. A bad
one is *named* if the error or the notes have the words of its case, *wrong* if it is accepted with another coverage
than that of its visible pixels without a question, and *traceback* if the exception is none of this package.
"""

import math
import re
import tempfile
import warnings
from pathlib import Path

import numpy as np
from hcss_evaluate.database.cloud_import import ImportOptions, import_image
from hcss_evaluate.database.segmentation import Cleaning
from image_scenes import independent

from hcss_twin.core.errors import HcssError
from hcss_twin.models.clouds.imagery.reader import read_image

QUESTION = re.compile(r"\?|far from")


def taken(case):
    """Return the entry and the text that the user sees; the entry is None for an error."""
    options = ImportOptions(cleaning=Cleaning(1, 1, 0, 1), pixel_size_m=1000.0, variable=case.variable, **case.options)
    try:
        entry = import_image(case.path, options)
    except HcssError as error:
        return None, str(error).replace(str(case.path.parent), "")
    return entry, " ".join(entry.notes)


def judge_good(case):
    """Return the verdict on a good image and the text."""
    entry, text = taken(case)
    if entry is None:
        return "refused", text
    if entry.facts.cloud_is != case.cloud_is:
        return "wrong sense", text
    expected = independent(case.path, case.variable)
    values = read_image(case.path, case.variable).values
    if not np.array_equal(np.isnan(values), np.isnan(expected)):
        return "wrong pixels missing", text
    if not np.allclose(values, expected, rtol=1e-6, atol=1e-3 if values.max() > 2 else 1e-6, equal_nan=True):
        return "wrong values", text
    if case.coverage is not None and not math.isclose(entry.facts.coverage, case.coverage, abs_tol=2e-4):
        return f"wrong coverage {entry.facts.coverage:.4f}, known {case.coverage:.4f}", text
    return ("questioned" if QUESTION.search(text) else "right"), text


def judge_bad(case):
    """Return the verdict on a bad image and the text."""
    entry, text = taken(case)
    named = all(re.search(each, text, re.IGNORECASE) for each in case.words)
    silent = entry is not None and case.coverage is not None and "?" not in text
    if silent and not math.isclose(entry.facts.coverage, case.coverage, abs_tol=2e-3):
        return f"wrong coverage {entry.facts.coverage:.4f}, known {case.coverage:.4f}", text
    if named:
        return "named", text
    return ("refused without the reason" if entry is None else "accepted"), text


def verdict(name, build, judge):
    """Return the verdict on one case and the text that the user sees."""
    with tempfile.TemporaryDirectory() as folder, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        case = build(Path(folder))
        try:
            return judge(case)
        except Exception as error:  # a traceback is what the campaign looks for
            return "traceback", f"{type(error).__name__}: {error}"
