"""Slope statistics."""

import numpy as np
import pytest

from hcss_twin.models.sea.slope_statistics import mean_square_slope, slope_density


def test_the_linear_law_has_cox_and_munks_coefficients() -> None:
    assert mean_square_slope(0.0) == 0.003
    assert mean_square_slope(10.0) == pytest.approx(0.0542, rel=1e-14)


@pytest.mark.parametrize("total", [0.003, 0.0542, 0.3])
def test_density_integrates_to_one_with_the_total_as_second_moment(total: float) -> None:
    edge = 8.0 * np.sqrt(0.5 * total)
    axis = np.linspace(-edge, edge, 401)
    squared = axis[:, None] ** 2 + axis[None, :] ** 2
    density = slope_density(squared, total) * (axis[1] - axis[0]) ** 2
    assert density.sum() == pytest.approx(1.0, rel=1e-12)
    assert (density * squared).sum() == pytest.approx(total, rel=1e-12)
