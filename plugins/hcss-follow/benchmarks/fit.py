"""Fit the coefficients of the forecast to sequences of images, cross-validated over blocks.

``python benchmarks/fit.py FILE --variables ... --minutes 0 15 30 45 -o coefficients.json``. Least squares over all
pixels gives the coefficients of the mean; the mean energy of the errors in bands, by regions of equal predicted energy,
those of the variance.
"""

import json
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
from hcss_follow.bands import COUNT, bands_of, local_energy
from hcss_follow.coefficients import DEPTHS_K, PREDICTORS, VARIANCES, Coefficients
from hcss_follow.forecast import LEAST_K2
from hcss_follow.motion import departures, interpolate
from hcss_follow.sky import FollowedSky
from scipy.optimize import nnls
from sequences import EDGES_K, MARGIN, blocks, inside, parser, state_of

USED = [n for n in range(4 * COUNT) if n not in (3 * COUNT - 1, 4 * COUNT - 1)]
"""Predictors of the fit: without those of the largest scale where uncertain, which are the mean of the image."""

MEMBERS, ROUNDS = 6, 3
"""For the factors of spread."""


def stacks(state, lead_s, pixel_size_m):
    """Return predictors (28, rows, columns) without the mean and local energies (14, rows, columns), moved along."""
    image, tendency = bands_of(state.kelvin - state.kelvin.mean()), bands_of(state.tendency_K)
    changes, energy = local_energy(tendency), local_energy(image)
    uncertain = changes / (changes + energy + np.float32(LEAST_K2))
    fields = np.concatenate([image, tendency, image * uncertain, tendency * uncertain, changes, energy])
    y, x = (np.arange(MARGIN, side - MARGIN, dtype=float) for side in state.shape)
    y, x = departures(state.flow_m_s / np.float32(pixel_size_m), lead_s, y, x)
    out = np.empty((len(fields), *y.shape), np.float32)
    for at, field in zip(out, fields, strict=True):
        interpolate(at, np.ascontiguousarray(field), y, x, 0, 0)
    return out


def solved(blocks_of):
    """Return coefficients (28,) of the normal equations of some blocks."""
    matrix, right = (sum(of[n] for of in blocks_of) for n in range(2))
    result = np.zeros(4 * COUNT)
    result[USED] = np.linalg.solve(matrix + 1e-5 * np.diag(np.diag(matrix)), right)
    return result


def fit_lead(collected):
    """Return coefficients of the mean (4, 7) and of the variance (2, 7), RMSE cross-validated and of the flow alone."""
    equations, sums = [], []
    for stack, truth in collected:
        known = np.isfinite(truth)
        a = stack[USED][:, known].astype(np.float64)
        t = truth[known].astype(np.float64)
        equations.append((a @ a.T, a @ t, t @ t, t.size))
    best = solved(equations)
    alone = np.zeros(4 * COUNT)
    alone[:COUNT] = 1.0
    for number, (matrix, right, square, count) in enumerate(equations):
        others = solved([of for n, of in enumerate(equations) if n != number]) if len(equations) > 1 else best
        left_out = [square - 2.0 * w[USED] @ right + w[USED] @ matrix @ w[USED] for w in (others, alone)]
        sums.append((*left_out, count))
    total = np.sum(sums, axis=0)
    variance = np.zeros((2, COUNT))
    for band in range(COUNT):
        rows, wanted = [], []
        for stack, truth in collected:
            if not np.all(np.isfinite(truth)):
                continue
            error = bands_of((truth - np.tensordot(best, stack[: 4 * COUNT], 1)).astype(np.float32))[band]
            pair = stack[[4 * COUNT + band, 5 * COUNT + band]].reshape(2, -1)
            order = np.argsort(pair[0])
            for part in np.array_split(order, 12):
                rows.append(pair[:, part].mean(axis=1))
                wanted.append(np.mean(error.ravel()[part] ** 2))
        a, b = np.array(rows), np.array(wanted)
        weight = 1.0 / np.sqrt(np.maximum(b, 1e-3))
        found = nnls(a * weight[:, None], b * weight)[0]
        variance[:, band] = found * b.sum() / max(float((a @ found).sum()), 1e-9)
    return best.reshape(4, COUNT), variance, np.sqrt(total[:2] / total[2]), sums


def spread_of(states, truths, coefficients, lead_s):
    """Return mean squares (block, class) of the errors of the mean and of the spread of members, and pixels."""
    errors, spreads, counts = (np.zeros((len(states), len(DEPTHS_K))) for _ in range(3))
    for number, (state, truth) in enumerate(zip(states, truths, strict=True)):
        at = [np.arange(MARGIN, side - MARGIN) - 0.5 * (side - 1) for side in state.shape]
        mean, *members = (
            FollowedSky(state, 1, seed, coefficients).at(lead_s, *at)[..., 0] for seed in (None, *range(MEMBERS))
        )
        variance, depth = np.var(members, axis=0, ddof=1), inside(state.clear_K) - mean
        known, classes = np.isfinite(truth), np.digitize(depth, EDGES_K)
        for one in range(len(DEPTHS_K)):
            these = known & (classes == one)
            counts[number, one] = these.sum()
            errors[number, one] = np.sum((mean - truth)[these] ** 2)
            spreads[number, one] = np.sum(variance[these])
    return errors, spreads, counts


def factors_of(states, truths, coefficients, lead_s):
    """Return factors (3,) of the variance with which members spread as much as the mean errs, and a line of text.

    The limits of clear sky take a part of the spread away, so that factors are found in a few rounds. The ratios of the
    last round leave out the block that they judge.
    """
    factors = np.ones(len(DEPTHS_K))
    for _ in range(ROUNDS):
        of = replace(coefficients, spread=np.stack([np.ones_like(factors), factors]))
        errors, spreads, counts = spread_of(states, truths, of, lead_s)
        left_out = (errors.sum(0) - errors) / np.maximum(spreads.sum(0) - spreads, 1e-9)
        ratios = np.sqrt((left_out * spreads).sum(0) / errors.sum(0))
        factors = factors * errors.sum(0) / spreads.sum(0)
    shares = counts.sum(0) / counts.sum()
    text = ", ".join(
        f"{name} ({share:.0%}) {ratio:.2f}"
        for name, share, ratio in zip(("clear", "thin", "cold"), shares, ratios, strict=True)
    )
    return factors, f"spread/error of blocks left out: {text}"


def main():
    """Fit, print and write."""
    arguments = parser(__doc__)
    arguments.add_argument("-o", "--output", type=Path, required=True)
    arguments.add_argument("--data", required=True, help="what the images are, named in every output")
    given = arguments.parse_args()
    first, second, *later = sorted(given.minutes)
    collected, states = {lead: [] for lead in later}, {lead: [] for lead in later}
    for number, images in blocks(given):
        state = state_of(images, (first, second), given.pixel_size)
        for minute in later:
            truth = inside(images[minute]) - state.kelvin.mean()
            if np.isfinite(truth).mean() > 0.1:
                collected[minute].append((stacks(state, 60.0 * (minute - second), given.pixel_size), truth))
                states[minute].append(state)
        print("block", number, flush=True)
    leads, means, variances, spreads = [], [], [], []
    for minute, pairs in collected.items():
        mean, variance, rmse, sums = fit_lead(pairs)
        worst = max(np.sqrt(one / two) for one, two, _ in sums)
        print(
            f"{minute - second:g} min: {rmse[0]:.3f} K cross-validated, flow alone {rmse[1]:.3f} K, "
            f"worst block {worst:.3f} of it"
        )
        lead_s = 60.0 * (minute - second)
        start = np.zeros_like(mean)
        start[0] = 1.0
        of = Coefficients(
            np.array([0.0, lead_s]),
            np.stack([start, mean]),
            np.stack([0.0 * variance, variance]),
            np.ones((2, len(DEPTHS_K))),
            "",
            "",
        )
        truths = [truth + state.kelvin.mean() for (_, truth), state in zip(pairs, states[minute], strict=True)]
        factors, text = factors_of(states[minute], truths, of, lead_s)
        print(text)
        leads.append(lead_s)
        means.append(dict(zip(PREDICTORS, np.round(mean, 4).tolist(), strict=True)))
        variances.append(dict(zip(VARIANCES, np.round(variance, 4).tolist(), strict=True)))
        spreads.append(np.round(factors, 4).tolist())
    command = " ".join(["python", *(Path(text).name if text == given.file else text for text in sys.argv)])
    written = {"data": given.data, "command": command, "leads_s": leads, "mean": means}
    written |= {"variance": variances, "spread": spreads}
    given.output.write_text(json.dumps(written, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
