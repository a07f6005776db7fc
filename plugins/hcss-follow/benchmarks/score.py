"""Score forecasts of image sequences: mean, ensemble and texture, beside pysteps' S-PROG and STEPS with the same flow.

``python benchmarks/score.py FILE --variables A B C --minutes 0 15 30 [--peers] [--auc] [--pictures DIR]`` forecasts
every later image from the first two. CRPS is the fair one of the members. Spread over error is that of the
ensemble: sqrt((N + 1) / N) times the root of the mean variance, over the RMSE of their mean. The rank distance is the
mean absolute deviation of the rank histogram's cumulative shares from even ones, times 2. Spectra are ratios of
octaves, member over measured. --auc needs hcss-evaluate[realism] and ten blocks or more.
"""

from itertools import pairwise
from pathlib import Path

import numpy as np
from hcss_follow.sky import FollowedSky
from sequences import EDGES_K, MARGIN, blocks, inside, parser, state_of

CLASSES = "clear", "thin", "cold"
"""By the mean forecast, see ``sequences.py``."""


def crps(members, truth):
    """Return the fair CRPS of members (N, ...) for each pixel."""
    count, ordered = len(members), np.sort(members, axis=0)
    weight = (2.0 * np.arange(1, count + 1) - count - 1.0)[:, None]
    spread = np.sum(weight * ordered.reshape(count, -1), axis=0).reshape(truth.shape) * 2.0 / (count * (count - 1))
    return np.mean(np.abs(members - truth), axis=0) - 0.5 * spread


def rank_distance(members, truth):
    """Return the distance of the rank histogram from an even one."""
    ranks = np.sum(members < truth, axis=0)
    share = np.cumsum(np.bincount(ranks.ravel(), minlength=len(members) + 1)) / ranks.size
    even = np.arange(1, len(members) + 2) / (len(members) + 1)
    return 2.0 * float(np.mean(np.abs(share - even)))


def octaves(image):
    """Return the power in octaves of 2, 4, ... 64 pixels and more, of an image with a window against its edges."""
    window = np.outer(*(np.hanning(side) for side in image.shape))
    power = np.abs(np.fft.fft2((image - image.mean()) * window)) ** 2
    k = np.hypot(*np.meshgrid(*(np.fft.fftfreq(side) for side in image.shape), indexing="ij"))
    edges = 0.5 / 2.0 ** np.arange(7)
    return np.array([power[(k > low) & (k <= high)].sum() for high, low in pairwise(edges)])


def ours(state, lead_s, count):
    """Return the mean forecast and the members (N, rows, columns)."""
    at = [np.arange(MARGIN, side - MARGIN) - 0.5 * (side - 1) for side in state.shape]
    members = [FollowedSky(state, 1, member).at(lead_s, *at)[..., 0] for member in range(count)]
    return FollowedSky(state, 1).at(lead_s, *at)[..., 0], np.stack(members)


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
    arguments.add_argument("--pictures", type=Path)
    given = arguments.parse_args()
    first, second, *later = sorted(given.minutes)
    sums, kept = {}, {minute: [] for minute in later}
    for number, images in blocks(given):
        state = state_of(images, (first, second), given.pixel_size)
        for minute in later:
            truth, lead = inside(images[minute]), minute - second
            if not np.all(np.isfinite(truth)):
                continue
            mean, members = ours(state, 60.0 * lead, given.members)
            found = {"ours": (mean, members)}
            if given.peers:
                found |= peers(images, state, (first, second), round(lead / (second - first)), given.members)
            measured = octaves(truth)
            line = [f"block {number:2} {lead:g} min"]
            for name, (forecast, ensemble) in found.items():
                entry = sums.setdefault((lead, name), [])
                centre = forecast if forecast is not None else ensemble.mean(axis=0)
                values = {"rmse2": np.mean((centre - truth) ** 2)}
                if ensemble is not None:
                    bias = ensemble.mean(axis=0) - truth
                    values |= {
                        "crps": crps(ensemble, truth).mean(), "variance": ensemble.var(axis=0, ddof=1).mean(),
                        "error2": np.mean(bias**2), "rank": rank_distance(ensemble, truth),
                    }  # fmt: skip
                    classes = np.digitize(inside(state.clear_K) - mean, EDGES_K)
                    for one, word in enumerate(CLASSES):
                        these = classes == one
                        values[f"{word} variance"] = np.sum(ensemble.var(axis=0, ddof=1)[these]) / truth.size
                        values[f"{word} error2"] = np.sum(bias[these] ** 2) / truth.size
                    values |= {
                        f"octave {2 * 2**n} px": ratio for n, ratio in enumerate(octaves(ensemble[0]) / measured)
                    }
                    line.append(f"{name} rmse {values['rmse2'] ** 0.5:.2f} crps {values['crps']:.2f}")
                else:
                    line.append(f"{name} rmse {values['rmse2'] ** 0.5:.2f}")
                entry.append(values)
            print(", ".join(line), flush=True)
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
            for word in CLASSES:
                part = np.sqrt((given.members + 1) / given.members * mean[f"{word} variance"] / mean[f"{word} error2"])
                text.append(f"{word} {part:.2f}")
            medians = [np.median([entry[key] for entry in entries]) for key in mean if key.startswith("octave")]
            text.append("octaves from 2 px (median) " + " ".join(f"{value:.2f}" for value in medians))
        print(", ".join(text))
    if given.auc:
        for minute, pairs in kept.items():
            print(f"{minute - second:g} min, one member of each block against measured:\n{classifier(pairs)}")


if __name__ == "__main__":
    main()
