"""What the readers say to an input: accepted, noted or refused, and the error of the positions."""

import re
import tempfile
from pathlib import Path

import numpy as np
from geometry_inputs import SCENE, Geometry, merged
from orbit_inputs import FRAMES_S

CAMERA = {
    "image": {"rows": 64, "columns": 64, "pixel_size": 100.0},
    "frames": {"count": len(FRAMES_S), "interval": FRAMES_S[1]},
    "camera": {"rows": 8, "columns": 8, "focal_length": 0.5, "detector_pitch": 2e-5, "points": 1},
    "attitude": {"provider": "nadir"},
}

USUAL = (
    r"^camera: (lines of sight|clouds are met|each pixel has its own view|\d+ x \d+ points|\d+ instants)",
    r"^(as-printed radiance: |band model: |sea: first reflection|blur at the edges |pixels are squares )",
    r"^sensor model 'integration' of .* asks for the scene",
)
"""Notes of every plan of these scenes, which question nothing."""


def judged(given):
    """Return a row of results of an input."""
    import hcss_twin

    error_m, notes, refused = None, [], None
    try:
        if isinstance(given, Geometry):
            plan = hcss_twin.make_plan(hcss_twin.Scenario.from_dict(given.scenario))
            notes = [*plan.notes, *(plan.sensor.notes if plan.sensor else ())]
        else:
            notes, error_m = _orbit(given)
    except hcss_twin.HcssError as error:
        refused = re.sub(rf"{re.escape(tempfile.gettempdir())}/[^/]+/", "", str(error))
    except Exception as error:  # a traceback for the user
        refused = f"TRACEBACK {type(error).__name__}: {error}"
    told = "\n".join([refused or "", *_questions(notes)])
    names = given.names if isinstance(given.names, tuple) else (given.names,)
    row = {"name": given.name, "refused": refused, "questions": _questions(notes)}
    row["error_m"] = None if error_m is None else float(f"{error_m:.3g}")
    found = [bool(re.search(_pattern(each), told)) for each in names]
    row["named"] = "TRACEBACK" not in told and (all(found) or (any(found) and "is out of range" in told))
    if not isinstance(given, Geometry) and given.expected_m is not None:
        row["within_m"] = given.within_m
    return row


def _pattern(name):
    return name.replace("[", r"\[").replace("]", r"\]")


def _questions(notes):
    return [each for each in notes if not any(re.match(usual, each) for usual in USUAL)]


def _orbit(given):
    from hcss_payload.build import payload_of
    from hcss_payload.imager import make_imager

    import hcss_twin
    from hcss_twin.core.catalog import Catalog

    place = given.place or (0.0, 0.0)
    with tempfile.TemporaryDirectory() as folder:
        if given.content is not None:
            Path(folder, given.orbit["file"]).write_bytes(given.content)
        raw = merged(SCENE, CAMERA, given.more) | {
            "orbit": given.orbit,
            "time": given.start.isoformat(),
            "place": {"latitude": place[0], "longitude": place[1]},
        }
        scenario = hcss_twin.Scenario.from_dict(raw, base=Path(folder))
        catalog = Catalog(base=Path(folder))
        trajectory = payload_of(scenario, catalog).trajectory
        error = None
        if given.expected_m is not None:
            made = np.array([trajectory.at(each) for each in FRAMES_S])
            error = float(np.max(np.linalg.norm(made - np.array(given.expected_m), axis=1)))
        return list(make_imager(scenario, catalog).notes), error
