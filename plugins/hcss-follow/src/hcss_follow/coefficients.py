"""Coefficients of the forecast by scale: what stays of an image, and what its latest change says, at each lead."""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from hcss_follow.bands import COUNT
from hcss_twin.providers import Array

SHIPPED = Path(__file__).parent / "coefficients.json"

PREDICTORS = "image", "tendency", "image_where_uncertain", "tendency_where_uncertain"
"""What is multiplied; uncertain is q, see ``forecast.py``."""

VARIANCES = "of_tendency", "of_image"
"""Local energies that give the variance of what is not known."""

DEPTHS_K = 0.5, 8.0, 40.0
"""How far below the clear sky the factors of spread hold, linear between: clear, thin and cold."""

PER_S = 900.0
"""Interval of the images to which the tendency refers."""


@dataclass(frozen=True)
class Coefficients:
    """Coefficients at leads.

    Attributes
    ----------
    leads_s : ndarray (L,)
        Ascending, from 0.
    mean : ndarray (L, 4, 7)
        Of each predictor and band, finest first.
    variance : ndarray (L, 2, 7)
        Of each local energy and band.
    spread : ndarray (L, 3)
        Factor of the variance by depth, see ``DEPTHS_K``.
    data : str
        Images to which they were fitted.
    command : str
        What fitted them.
    """

    leads_s: Array
    mean: Array
    variance: Array
    spread: Array
    data: str
    command: str

    def at(self, lead_s: float) -> tuple[Array, Array, Array]:
        """Return the coefficients of the mean (4, 7) and of the variance (2, 7), and its factors (3,), at a lead.

        Linear between leads. Beyond the last one, what is left of the image falls as between the last two leads, and
        what falls away becomes variance.
        """
        lead = min(lead_s, float(self.leads_s[-1]))
        mean, variance = (
            np.array([[np.interp(lead, self.leads_s, column) for column in row.T] for row in np.moveaxis(of, 0, 1)])
            for of in (self.mean, self.variance)
        )
        if lead_s > lead:
            last, before = self.mean[-1, 0], self.mean[-2, 0]
            steps = (lead_s - lead) / (self.leads_s[-1] - self.leads_s[-2])
            part = np.clip(last / before, 0.0, 1.0) ** steps
            mean[0] *= part
            mean[2] *= part
            variance[1] += last**2 * (1.0 - part**2)
        factors = np.array([np.interp(lead, self.leads_s, of) for of in self.spread.T])
        return mean, variance, factors


@cache
def read_coefficients(path: Path = SHIPPED) -> Coefficients:
    """Return the coefficients of a file."""
    stored = json.loads(path.read_text())
    leads = np.array([0.0, *stored["leads_s"]])
    start = np.zeros((4, COUNT))
    start[0] = 1.0
    mean = np.stack([start, *(np.array([of[name] for name in PREDICTORS]) for of in stored["mean"])])
    variance = np.stack(
        [np.zeros((2, COUNT)), *(np.array([of[name] for name in VARIANCES]) for of in stored["variance"])]
    )
    spread = np.concatenate((np.ones((1, len(DEPTHS_K))), stored["spread"]))
    return Coefficients(leads, mean, variance, spread, stored["data"], stored["command"])
