"""What stands for a scene without an effect behaves as the effect does at strength 0, and costs nothing."""

import numpy as np
import pytest

from hcss_twin.engine.tables.radiance_tables import NO_TEXTURE, NO_WAVES
from hcss_twin.plan.clear_sky import EVEN_SKY
from hcss_twin.plan.sunlight import COMPUTED, Sunlight
from hcss_twin.plan.texture import Texture, expansion_states, nodes_between


def test_an_even_sky_is_texture_without_deviations():
    flat = Texture(0.0, 0.0)
    assert EVEN_SKY.steps == flat.steps == (0.0, 0.0)
    states = expansion_states(nodes_between((-0.4, 0.9), 4))
    assert {EVEN_SKY.without_flat(state) for state in states} == {(0.0, 0.0)}
    assert EVEN_SKY.expansion_states == ()
    fields = EVEN_SKY.fields(None, None).at(0.0, slice(2, 5), slice(0, 4))
    assert [(field.shape, field.dtype, np.any(field)) for field in fields] == [((3, 4), np.float32, False)] * 2
    same = np.broadcast_to(np.random.default_rng(0).random((5, 2, 3)), (len(flat.expansion_states), 5, 2, 3))
    assert np.all(flat.change(np.ones((5, 2)), lambda: same) == EVEN_SKY.change(np.ones((5, 2)), lambda: same))


def test_an_even_sky_solves_no_states():
    def solved():
        raise AssertionError("states were solved")

    assert EVEN_SKY.change(np.ones((5, 2)), solved) == 0.0
    assert EVEN_SKY.with_own_spectra(None) == []


def test_tables_without_texture_or_waves_add_no_error():
    assert NO_TEXTURE.estimated_error == NO_WAVES.estimated_error == 0.0
    assert NO_TEXTURE.states == NO_WAVES.change == ()


@pytest.mark.parametrize("light", [COMPUTED, Sunlight(False, 1e-5), Sunlight(False, 0.0)])
@pytest.mark.parametrize("zenith_deg", [[10.0, 95.0], [90.0, 95.0]])
def test_sunlight_matters_if_it_is_computed_and_the_sun_is_up(light, zenith_deg):
    assert light.matters(np.array(zenith_deg)) == (light is COMPUTED and min(zenith_deg) < 90.0)
