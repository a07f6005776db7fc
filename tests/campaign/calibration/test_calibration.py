"""A small simulation-based calibration, and the committed results of the large one."""

import json
from pathlib import Path

import calibration
import numpy as np
import pytest

RESULTS = Path(__file__).parent
IMAGES = 4


@pytest.mark.parametrize("name", ["results", "results-seed-1"])
def test_ranks_of_the_committed_images_are_uniform_and_their_intervals_hold(name):
    found = json.loads((RESULTS / f"{name}.json").read_text())
    assert [row["index"] for row in found["rows"]] == list(range(200))
    summary = calibration.summarise(found["rows"])
    assert summary["images"] >= 190
    for name in calibration.KINDS:
        for key, value in found["summary"][name].items():
            assert summary[name][key] == pytest.approx(value, rel=1e-12)
    for parameter in calibration.KINDS:
        own = summary[parameter]
        assert min(own["chi_squared_p"], own["kolmogorov_p"]) > 0.01
        assert 0.85 <= own["inside_90"] <= 0.95


@pytest.mark.long
def test_intervals_hold_the_parameters_that_images_were_made_with():
    # Fewer independent draws than those of the committed rows, and enough for quantiles of 5 and 95 %.
    rows = [calibration.calibrate_one(index, 64, 11, most_steps=10_000, samples=200.0) for index in range(IMAGES)]
    refused = [row["refused"] for row in rows if "refused" in row]
    # One has two modes between which chains hardly change, which is seen.
    assert len(refused) <= 1
    assert all("not converged" in reason for reason in refused)
    rows = [row for row in rows if "refused" not in row]
    inside = [held for row in rows for held in row["inside_90"].values()]
    # Nine of ten on average; parameters of an image are correlated.
    assert np.mean(inside) >= 0.7
    assert all(row["p_value"] > 0.001 for row in rows)


def test_ranks_of_true_values_among_draws_of_the_same_distribution_are_uniform():
    """The summary itself: right posteriors pass, posteriors that are too narrow or shifted do not."""
    rng = np.random.default_rng(0)

    def rows(width, shift=0.0):
        made = []
        for _ in range(200):
            centre = rng.standard_normal()
            truth = centre + rng.standard_normal()
            drawn = centre + shift + width * rng.standard_normal(calibration.DRAWS)
            low, high = np.quantile(drawn, [0.05, 0.95])
            row = {"ranks": int(np.sum(drawn < truth)), "inside_90": bool(low <= truth <= high)}
            made.append({name: dict.fromkeys(calibration.KINDS, value) for name, value in row.items()})
        return calibration.summarise(made)["H"]

    right = rows(1.0)
    assert right["chi_squared_p"] > 0.01
    assert 0.85 <= right["inside_90"] <= 0.95
    assert rows(0.6)["chi_squared_p"] < 0.01
    assert rows(1.0, 0.5)["kolmogorov_p"] < 0.01
