"""Identical twins: how often the intervals of sea and vapour hold values that are known.

``python benchmarks/twins.py [--twins 200] [--exact 6]``. Seas and vapours are drawn from the prior, their brightness
temperatures at 10.8 and 12.0 um get the error of a channel, and each pair is fitted. 68 % intervals should hold about
68 % of the values. Some clear skies are computed anew, without the table between whose knots the fit interpolates.
"""

import argparse

import numpy as np
from hcss_follow.clear_sky import CHANNEL_K, PRIOR_SEA_K, PRIOR_VAPOUR, _clear, _clear_K, clear_sky_table, posterior

SCENE = {
    "time": "2020-09-06T00:15:00Z",
    "place": {"latitude": 5.0, "longitude": -20.0},
    "view": {"zenith": 25.0},
    "accuracy": 0.002,
    "bands": ["lwir-10.8", "lwir-12.0"],
}


def drawn(rng, table):
    """Return a sea and a vapour of the prior, within the limits of the fit."""
    while True:
        sea, scale = rng.normal(table.climatology_K, PRIOR_SEA_K), np.exp(rng.normal(0.0, PRIOR_VAPOUR))
        if table.sea_K[0] < sea < table.sea_K[-1] and table.scales[0] < scale < table.scales[-1]:
            return sea, scale


def main():
    """Fit and print."""
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("--twins", type=int, default=200)
    arguments.add_argument("--exact", type=int, default=6)
    given = arguments.parse_args()
    rng, table = np.random.default_rng(1), clear_sky_table(SCENE)
    held, spread = {68.0: [], 95.0: []}, []
    for _ in range(given.twins):
        truth = np.array(drawn(rng, table))
        measured = table.kelvin(truth[None])[0] + rng.normal(0.0, CHANNEL_K, 2)
        draws = posterior(table, measured.tolist())
        spread.append(draws.std(axis=0))
        for share, entries in held.items():
            low, high = np.percentile(draws, [50.0 - 0.5 * share, 50.0 + 0.5 * share], axis=0)
            entries.append((low < truth) & (truth < high))
    for share, entries in held.items():
        sea, vapour = 100.0 * np.mean(entries, axis=0)
        print(f"{given.twins} twins: {share:g} % intervals hold {sea:.0f} % of the seas, {vapour:.0f} % of the vapours")
    print(f"standard deviations: {np.mean(spread, axis=0).round(2)}", flush=True)
    errors = []
    for _ in range(given.exact):
        sea, scale = drawn(rng, table)
        exact = _clear_K(_clear(SCENE, sea, scale))[1]
        errors.append(table.kelvin(np.array([[sea, scale]]))[0] - exact)
    print(f"table less clear sky: at most {np.abs(errors).max():.3f} K of {given.exact}")


if __name__ == "__main__":
    main()
