"""Calls of every public function with wrong values for each of its arguments, and what comes of each call."""

import inspect
import json
import sys
import traceback
import warnings
from collections import Counter
from datetime import UTC, datetime
from decimal import Decimal
from pathlib import Path

import numpy as np
import xarray as xr

sys.path.insert(0, str(Path(__file__).parents[2] / "tests" / "stability"))

from hang import Hang, limited
from hcss_evaluate import EvaluationChoice, evaluate, fit, fit_dimension, read_posterior
from hcss_export import export_cube
from hcss_sweep import open_sweep, sweep
from hcss_uncertainty import open_propagation, propagate
from input_files import FIT, noise, small_stratus
from posterior_example import example_posterior

import hcss_twin
from hcss_twin import HcssError, Scenario, Twin
from hcss_twin.core.catalog import Catalog
from hcss_twin.engine.simulate import run
from hcss_twin.engine.verification import verify_cube
from hcss_twin.reports.preview import draw_preview


class Odd:
    """Neither shown nor compared."""

    def __repr__(self):
        raise ValueError("no text")

    def __eq__(self, other):
        raise ValueError("no equality")

    __hash__ = None


WRONG = {
    "None": None, "True": True, "False": False, "0": 0, "-1": -1, "1.5": 1.5, "nan": np.nan, "inf": np.inf,
    "1e400": 10**400, "complex": 1j, "decimal": Decimal(1), "empty text": "", "text": "x", "null": "a\0b",
    "bytes": b"x", "list": [], "list of numbers": [1.5], "list of None": [None], "table": {}, "table of 1": {1: 1},
    "tuple": (1, 2, 3), "set": {1}, "object": object(), "odd": Odd(), "class": dict, "function": len,
    "0-d": np.array(1.5), "2-d": np.ones((2, 2)), "dataset": xr.Dataset(), "path": Path("no") / "where",
}  # fmt: skip
"""30 values that are wrong for most arguments."""


def calls(folder):
    """Return the public functions with arguments that are right, by name."""
    cube, image, swept = str(folder / "c.nc"), folder / "i.npy", {"over": {"sea.temperature": [290.0]}}
    scenario = small_stratus(**{"frames.count": 1, "output.certificate": 0})
    run(hcss_twin.make_plan(scenario), cube)
    np.save(image, noise())
    example_posterior(folder / "p.nc")
    shipped = (Catalog().root / "scenarios" / "stratus.toml").read_text("utf-8")
    uncertain = {"sea.temperature": "normal:291:1"}
    cheap = {
        "open_cube": (hcss_twin.open_cube, {"path": cube}),
        "open_sweep": (open_sweep, {"path": cube}),
        "open_propagation": (open_propagation, {"path": cube}),
        "read_posterior": (read_posterior, {"path": folder / "p.nc"}),
        "brightness_temperature": (hcss_twin.brightness_temperature, {"cube": cube}),
        "export_cube": (export_cube, {"cube": cube, "to": "png", "output": folder, "replace": True}),
        "Scenario.load": (Scenario.load, {"source": "stratus"}),
        "Scenario.from_toml": (Scenario.from_toml, {"text": shipped}),
        "Scenario.from_dict": (Scenario.from_dict, {"raw": json.loads(scenario.to_json())}),
        "Scenario.from_cube": (Scenario.from_cube, {"path": cube}),
        "EvaluationChoice": (EvaluationChoice, {}),
    }
    of_files = {
        "sense": (hcss_twin.sense, {"cube": cube, "sensor": {"parameters": {"noise": "nedt", "nedt": 0.05}}}),
        "report": (hcss_twin.report, {"source": folder / "p.nc", "replace": True}),
        "make_plan": (hcss_twin.make_plan, {"scenario": scenario}),
        "simulate": (hcss_twin.simulate, {"scenario": scenario}),
        "column_spectra": (hcss_twin.column_spectra, {"scene": cube}),
        "Twin": (Twin, {"scenario": scenario}),
        "Twin.frames": (lambda numbers=None: list(Twin(scenario).frames(numbers)), {}),
        "sweep": (sweep, {"source": scenario, "folder": folder / "sweep", **swept, "force": True}),
        "propagate": (propagate, {"source": scenario, "draws": 2, "uncertain": uncertain}),
        "verify_cube": (verify_cube, {"path": cube}),
        "draw_preview": (draw_preview, {"cube": cube, "folder": folder, "animation": False}),
        "evaluate": (evaluate, {"real": image, "sim": image, "real_choice": EvaluationChoice(pixel_size_m=100.0)}),
        "fit": (fit, {"images": image, "output": folder / "f.nc", **FIT}),
        "fit_dimension": (fit_dimension, {"dimension": 2.3, "error": 0.1, "output": folder / "f.nc", "most_steps": 2}),
    }
    return cheap, of_files | _payload(folder)


def _payload(folder):
    try:
        import hcss_payload
    except ImportError:
        return {}
    start, orbit = datetime(2024, 4, 20, tzinfo=UTC), hcss_payload.Circular
    made = orbit(**{name: 500e3 if "altitude" in name else 0.0 for name in _required(orbit)})
    times = [0.0, 1.0, 2.0, 3.0, 4.0]
    still, written = hcss_payload.Nadir(made), {"start": start, "times_s": times, "name": "x"}
    return {
        "pose_at": (hcss_payload.pose_at, {"time_s": 0.0, "trajectory": made, "attitude": still}),
        "read_oem": (hcss_payload.read_oem, {"path": folder / "o.oem", "start": start}),
        "read_aem": (hcss_payload.read_aem, {"path": folder / "o.aem", "start": start}),
        "write_oem": (hcss_payload.write_oem, {"path": folder / "o.oem", "trajectory": made, **written}),
        "write_aem": (hcss_payload.write_aem, {"path": folder / "o.aem", "attitude": still, **written}),
    }


def _required(function):
    return [name for name, each in inspect.signature(function).parameters.items() if each.default is each.empty]


def outcomes(functions, values=WRONG):
    """Call each function with each wrong value for each argument.

    Returns
    -------
    Counter of (function, outcome), list of str
        Outcomes: ``refused``, ``accepted``, ``escaped``; the exceptions that escaped.
    """
    counts, escaped = Counter(), []
    for function, (call, right) in functions.items():
        for argument, parameter in inspect.signature(call).parameters.items():
            if parameter.kind is parameter.VAR_KEYWORD:
                continue
            for name, value in values.items():
                try:
                    with warnings.catch_warnings(), limited(30):
                        warnings.simplefilter("ignore")
                        result = call(**right | {argument: value})
                        getattr(result, "close", int)()
                    counts[function, "accepted"] += 1
                except HcssError:
                    counts[function, "refused"] += 1
                except (Exception, Hang) as error:
                    counts[function, "escaped"] += 1
                    last = traceback.extract_tb(error.__traceback__)[-1]
                    what = f"{type(error).__name__} at {Path(last.filename).name}:{last.lineno}: {str(error)[:100]}"
                    escaped.append(f"{function}({argument}={name}): {what}")
    return counts, escaped
