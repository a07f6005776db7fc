"""Train a small detector on the frames of a data set, and write what it finds in those for tests.

    python train_detector.py small-targets found.csv
    hcss score found.csv small-targets --split test

It looks at the highest peaks of a matched filter, and learns from the pixels around them, and from filters of several
sizes, which of them are targets.
"""

import csv
import sys

import numpy as np
from hcss_dataset import Frames
from hcss_dataset.baselines import matched_filter
from scipy import ndimage
from sklearn.ensemble import HistGradientBoostingClassifier

SIGMAS, PATCH, PEAKS, NEAR = (0.7, 1.0, 1.5, 2.5), 4, 100, 1.5
"""Of filters; pixels beside a peak that are seen, peaks in a frame, and distance of a peak from its target."""


def peaks(image):
    """Return the maps of all filters (F, y, x), and rows and columns of the peaks."""
    scaled = (image - np.median(image)) / (np.std(image) or 1.0)
    maps = [-ndimage.gaussian_laplace(scaled, sigma, mode="reflect") * sigma**2 for sigma in SIGMAS]
    maps += [ndimage.white_tophat(scaled, size=5), ndimage.black_tophat(scaled, size=5)]
    for size in (5, 11, 21):
        mean = ndimage.uniform_filter(scaled, size)
        maps.append(np.sqrt(np.maximum(ndimage.uniform_filter(scaled**2, size) - mean**2, 0.0)))
    strength = matched_filter(image)
    rows, columns = np.nonzero(strength == ndimage.maximum_filter(strength, size=3, mode="nearest"))
    order = np.argsort(-strength[rows, columns], kind="stable")[:PEAKS]
    return scaled, np.array([*maps, strength]), rows[order], columns[order]


def features(image):
    """Return the features (N, F) of the peaks of an image (y, x), and their rows and columns."""
    scaled, maps, rows, columns = peaks(image.astype(float))
    padded = np.pad(scaled, PATCH, mode="reflect")
    size = 2 * PATCH + 1
    around = np.lib.stride_tricks.sliding_window_view(padded, (size, size))[rows, columns].reshape(len(rows), -1)
    around = around - np.median(around, axis=1, keepdims=True)
    spread = np.std(around, axis=1, keepdims=True)
    # bright and dark targets look alike once the sign of the peak is taken out
    sign = np.sign(maps[0][rows, columns])[:, None]
    return np.hstack((sign * around / (spread + 1e-6), spread, maps[:, rows, columns].T)), rows + 0.5, columns + 0.5


def wanted(labels, rows, columns):
    """Return which peaks belong to a target that can be seen, and which to one that cannot."""
    seen, hidden = np.zeros((2, len(rows)), dtype=bool)
    for target in labels["targets"]:
        near = np.hypot(rows - target["centroid"][0], columns - target["centroid"][1]) <= NEAR
        (seen if (target["snr"][0] or 0.0) >= 1.0 else hidden)[near] = True
    return seen, hidden & ~seen


def main(folder, output):
    """Train on one split of a data set, and write the detections in another one."""
    samples, truths = [], []
    for frame in Frames(folder, split="train"):
        found, *places = features(frame.image[0])
        seen, hidden = wanted(frame.labels, *places)
        samples.append(found[~hidden])
        truths.append(seen[~hidden])
    classifier = HistGradientBoostingClassifier(max_iter=300, learning_rate=0.05, l2_regularization=1.0, random_state=0)
    classifier.fit(np.vstack(samples), np.concatenate(truths))
    with open(output, "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(("key", "row", "column", "score"))
        for frame in Frames(folder, split="test"):
            found, *places = features(frame.image[0])
            key = [frame.labels["key"]] * len(found)
            writer.writerows(zip(key, *places, classifier.decision_function(found), strict=True))


if __name__ == "__main__":
    main(*sys.argv[1:])
