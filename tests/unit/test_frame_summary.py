"""Windows of a frame whose coverage is its own, made without the rest of the frame."""

from dataclasses import replace

import numpy as np
import pytest
from hcss_author import sample_cloud_inputs, sample_layer
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from hcss_twin.models.clouds.coverage import summarise
from hcss_twin.models.clouds.thickness import frame_thickness, thickness_in_frame

ROWS, COLUMNS = 7, 9
WINDOWS = [(slice(0, 7), slice(0, 9)), (slice(2, 6), slice(3, 8)), (slice(6, 7), slice(8, 9))]


def strips_of(field, rows=3):
    return lambda: (field[row : row + rows].copy() for row in range(0, field.shape[0], rows))


def agree(field, coverage):
    layer = replace(sample_layer(), coverage=coverage)
    whole = frame_thickness(field, layer, 1.3)
    summary = summarise(strips_of(field), field.size, coverage)
    for rows, columns in WINDOWS:
        first = rows.start * COLUMNS + columns.start
        found = thickness_in_frame(field[rows, columns].copy(), first, COLUMNS, summary, layer, 1.3)
        assert found.tobytes() == whole[rows, columns].tobytes()


@given(
    arrays(np.float32, (ROWS, COLUMNS), elements=st.floats(-8, 8, width=32)),
    st.floats(0.0, 1.0) | st.sampled_from([0.0, 1.0, 0.5]),
)
def test_a_window_equals_the_same_part_of_the_whole(field, coverage):
    agree(field, coverage)


@given(
    arrays(np.float32, (ROWS, COLUMNS), elements=st.sampled_from([-1.0, -0.0, 0.0, 1e-40, 0.5])), st.floats(0.0, 1.0)
)
def test_ties_go_to_the_same_pixels(field, coverage):
    agree(field, coverage)


def test_the_fractal_generator_gives_windows_of_its_frames(monkeypatch):
    from hcss_twin.models.clouds.fractal import generator

    monkeypatch.setattr(generator, "STRIP_PIXELS", 1000)
    inputs = sample_cloud_inputs(coverage=0.37)
    assert inputs.layer.coverage_mode == "frame"
    parameters = generator.FractalParameters(gamma=2.0, H=0.6, L=(4.0, 4.0), k=(0, 6))
    clouds = generator.FractalClouds(inputs, parameters)
    size = slice(0, inputs.grid.rows), slice(0, inputs.grid.columns)
    window = slice(5, 20), slice(7, inputs.grid.columns)
    for time_s in (0.0, 100.0):
        whole = clouds.thickness_m(time_s, *size)
        found = clouds.thickness_in_frame_m(time_s, *window, clouds.frame_summary(time_s))
        assert found.tobytes() == whole[window].tobytes()
    with pytest.raises(ValueError, match="inside 0 to"):
        clouds.thickness_in_frame_m(0.0, slice(0, 10**6), window[1], clouds.frame_summary(0.0))
