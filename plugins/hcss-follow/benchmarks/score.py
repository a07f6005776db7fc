"""Score forecasts of image sequences: mean, ensemble and texture, beside pysteps' S-PROG and STEPS with the same flow.

``python benchmarks/score.py FILE --variables A B C --minutes 0 15 30 [--peers] [--auc] [--spoilt] [--pictures DIR]``
forecasts every later image from the first two. CRPS is the fair one of the members. Spread over error is that of the
ensemble: sqrt((N + 1) / N) times the root of the mean variance, over the RMSE of their mean. The rank distance is the
mean absolute deviation of the rank histogram's cumulative shares from even ones, times 2; the mean of the blocks, and
that of all blocks together. Spectra are ratios of octaves, member over measured, of images without missing pixels.
--auc needs hcss-evaluate[realism] and ten blocks or more. --spoilt scores the same with a first image of another block,
and with one that is six hours old by its time.
"""

from datetime import timedelta
from itertools import pairwise
from pathlib import Path

import numpy as np
from hcss_follow.analysis import Image, analyse, doubts
from hcss_follow.coefficients import SHIPPED, read_coefficients
from hcss_follow.sky import FollowedSky
from sequences import EDGES_K, MARGIN, START, blocks, inside, parser, state_of

CLASSES = "clear", "thin", "cold"
"""By the mean forecast, see ``sequences.py``."""


LEAST_KNOWN = 0.1
"""Share of the pixels of a later image that are not missing, for its block to count."""


def crps(members, truth):
    """Return the fair CRPS of members (N, ...) for each pixel."""
    count, ordered = len(members), np.sort(members, axis=0)
    weight = (2.0 * np.arange(1, count + 1) - count - 1.0)[:, None]
    spread = np.sum(weight * ordered.reshape(count, -1), axis=0).reshape(truth.shape) * 2.0 / (count * (count - 1))
    return np.mean(np.abs(members - truth), axis=0) - 0.5 * spread


def ranks_of(members, truth):
    """Return the rank histogram, shares of the pixels."""
    return np.bincount(np.sum(members < truth, axis=0), minlength=len(members) + 1) / truth.size


def rank_distance(ranks):
    """Return the distance of a rank histogram from an even one."""
    return 2.0 * float(np.mean(np.abs(np.cumsum(ranks) - np.arange(1, ranks.size + 1) / ranks.size)))


def octaves(image):
    """Return the power in octaves of 2, 4, ... 64 pixels and more, of an image with a window against its edges."""
    window = np.outer(*(np.hanning(side) for side in image.shape))
    power = np.abs(np.fft.fft2((image - image.mean()) * window)) ** 2
    k = np.hypot(*np.meshgrid(*(np.fft.fftfreq(side) for side in image.shape), indexing="ij"))
    edges = 0.5 / 2.0 ** np.arange(7)
    return np.array([power[(k > low) & (k <= high)].sum() for high, low in pairwise(edges)])


def ours(state, lead_s, count, coefficients):
    """Return the mean forecast and the members (N, rows, columns)."""
    at = [np.arange(MARGIN, side - MARGIN) - 0.5 * (side - 1) for side in state.shape]
    mean, *members = (
        FollowedSky(state, 1, seed, coefficients).at(lead_s, *at)[..., 0] for seed in (None, *range(count))
    )
    return mean, np.stack(members)


def peers(images, state, minutes, step, count):
    """Return mean and members of S-PROG and STEPS of pysteps with our flow, in steps of the images."""
    from pysteps import nowcasts

    before, now = (np.where(np.isfinite(images[m]), images[m], np.nanmean(images[m])) for m in minutes)
    level = float(now.max())
    given = level - np.stack([before, now]).astype(float)  # cloud is large, as rain is
    v, u = (state.flow_m_s * state.interval_s / state.pixel_size_m).astype(float)
    velocity = np.stack([u, v])
    shared = {"n_cascade_levels": 7, "ar_order": 1}
    # S-PROG: no mask of rain; STEPS: noise with the spectrum of the image, its histogram kept
    sprog = nowcasts.get_method("sprog")(given, velocity, step, precip_thr=1e-3, probmatching_method="cdf", **shared)
    steps = nowcasts.get_method("steps")(
        given, velocity, step, n_ens_members=count, precip_thr=1e-3, kmperpixel=state.pixel_size_m / 1e3,
        timestep=state.interval_s / 60.0, seed=1, mask_method=None, vel_pert_method=None, probmatching_method="cdf",
        **shared,
    )  # fmt: skip
    return {"S-PROG": (inside(level - sprog[-1]), None), "STEPS": (None, inside(level - steps[:, -1]))}


def picture(path, truth, mean, members):
    """Draw the measured image, the mean and two members on one scale."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    low, high = np.nanpercentile(truth, [0.5, 99.5])
    figure, axes = pyplot.subplots(1, 4, figsize=(16, 4.4), layout="constrained")
    for axis, (title, image) in zip(
        axes, (("measured", truth), ("mean", mean), ("member", members[0]), ("member", members[1])), strict=True
    ):
        axis.imshow(image, origin="lower", cmap="gray_r", vmin=low, vmax=high)
        axis.set(title=title, xticks=[], yticks=[])
    figure.savefig(path, dpi=70)
    pyplot.close(figure)


def spoilt(given):
    """Print RMSE and doubts: as the images are, with a first one of another block, and with one that is old."""
    first, second, *later = sorted(given.minutes)
    collected = list(blocks(given))
    last, old = START + timedelta(minutes=second), START + timedelta(minutes=second, hours=-6)
    for name in ("as they are", "first image of another block", "first image six hours old"):
        flagged, errors = [], {minute: [] for minute in later}
        for position, (_, images) in enumerate(collected):
            other = collected[(position + len(collected) // 4 + 1) % len(collected)][1]
            before = (other if "another" in name else images)[first]
            time = old if "old" in name else START + timedelta(minutes=first)
            pair = [Image(before, time), Image(images[second], last)]
            state = analyse(pair, pixel_size_m=given.pixel_size, latitude=0.0, longitude=0.0)
            flagged.append(bool(doubts(state)))
            at = [np.arange(MARGIN, side - MARGIN) - 0.5 * (side - 1) for side in state.shape]
            for minute in later:
                truth = inside(images[minute])
                if np.isfinite(truth).mean() >= LEAST_KNOWN:
                    forecast = FollowedSky(state, 1).at(60.0 * (minute - second), *at)[..., 0]
                    errors[minute].append(np.nanmean((forecast - truth) ** 2))
        rmse = " / ".join(f"{np.sqrt(np.mean(errors[minute])):.3f}" for minute in later)
        print(f"{name}: RMSE {rmse} K, {sum(flagged)} of {len(flagged)} states flagged", flush=True)


def classifier(kept):
    """Return AUC of members against measured images."""
    from hcss_evaluate.realism import compare
    from hcss_evaluate.realism.text import realism_text

    real, simulated = (
        [image.astype(float) for image in side] for side in zip(*((t, m) for _, t, m in kept), strict=True)
    )
    scenes = [number for number, _, _ in kept]
    options = {"blur_pixels": 0.0, "scales": ("z-scored",), "copies": 0, "resamples": 100}
    return realism_text(compare(real, simulated, scenes, scenes, **options))


def main():
    """Score and print."""
    arguments = parser(__doc__)
    arguments.add_argument("--members", type=int, default=20)
    arguments.add_argument("--peers", action="store_true")
    arguments.add_argument("--auc", action="store_true")
    arguments.add_argument("--spoilt", action="store_true")
    arguments.add_argument("--pictures", type=Path)
    arguments.add_argument("--coefficients", type=Path, default=SHIPPED, help="of fit.py, from other blocks")
    given = arguments.parse_args()
    coefficients = read_coefficients(given.coefficients)
    first, second, *later = sorted(given.minutes)
    sums, of_ranks, kept = {}, {}, {minute: [] for minute in later}
    for number, images in blocks(given):
        state = state_of(images, (first, second), given.pixel_size)
        for minute in later:
            truth, lead = inside(images[minute]), minute - second
            known = np.isfinite(truth)
            if known.mean() < LEAST_KNOWN:
                continue
            mean, members = ours(state, 60.0 * lead, given.members, coefficients)
            found = {"ours": (mean, members)}
            if given.peers:
                found |= peers(images, state, (first, second), round(lead / (second - first)), given.members)
            line = [f"block {number:2} {lead:g} min"]
            for name, (forecast, ensemble) in found.items():
                entry = sums.setdefault((lead, name), [])
                centre = forecast if forecast is not None else ensemble.mean(axis=0)
                values = {"rmse2": np.mean((centre - truth)[known] ** 2)}
                if ensemble is not None:
                    of_pixels, measured = ensemble[:, known], truth[known]
                    bias, variance = of_pixels.mean(axis=0) - measured, of_pixels.var(axis=0, ddof=1)
                    ranks = ranks_of(of_pixels, measured)
                    values |= {
                        "crps": crps(of_pixels, measured).mean(), "variance": variance.mean(),
                        "error2": np.mean(bias**2), "rank": rank_distance(ranks),
                    }  # fmt: skip
                    of_ranks.setdefault((lead, name), []).append(ranks)
                    classes = np.digitize((inside(state.clear_K) - mean)[known], EDGES_K)
                    for one, word in enumerate(CLASSES):
                        these = classes == one
                        values[f"{word} variance"] = np.sum(variance[these]) / measured.size
                        values[f"{word} error2"] = np.sum(bias[these] ** 2) / measured.size
                    values |= {
                        f"octave {2 * 2**n} px": ratio for n, ratio in enumerate(octaves(ensemble[0]) / octaves(truth))
                    }
                    line.append(f"{name} rmse {values['rmse2'] ** 0.5:.2f} crps {values['crps']:.2f}")
                else:
                    line.append(f"{name} rmse {values['rmse2'] ** 0.5:.2f}")
                entry.append(values)
            print(", ".join(line), flush=True)
            if known.all():
                kept[minute].append((number, truth, members[0]))
            if given.pictures:
                given.pictures.mkdir(exist_ok=True)
                picture(given.pictures / f"block-{number}-{lead:g}.png", truth, mean, members)
    for (lead, name), entries in sums.items():
        mean = {key: float(np.mean([entry[key] for entry in entries])) for key in entries[0]}
        text = [f"{lead:g} min {name} ({len(entries)} blocks): RMSE {mean['rmse2'] ** 0.5:.3f} K"]
        if "crps" in mean:
            ratio = np.sqrt((given.members + 1) / given.members * mean["variance"] / mean["error2"])
            text.append(f"CRPS {mean['crps']:.3f} K, spread/error {ratio:.2f}, rank distance {mean['rank']:.3f}")
            text.append(f"of all blocks together {rank_distance(np.mean(of_ranks[lead, name], axis=0)):.3f}")
            for word in CLASSES:
                part = np.sqrt((given.members + 1) / given.members * mean[f"{word} variance"] / mean[f"{word} error2"])
                text.append(f"{word} {part:.2f}")
            medians = [np.nanmedian([entry[key] for entry in entries]) for key in mean if key.startswith("octave")]
            text.append("octaves from 2 px (median) " + " ".join(f"{value:.2f}" for value in medians))
        print(", ".join(text))
    if given.auc:
        for minute, pairs in kept.items():
            print(f"{minute - second:g} min, one member of each block against measured:\n{classifier(pairs)}")
    if given.spoilt:
        spoilt(given)


if __name__ == "__main__":
    main()
