"""Numerical levels: their order, the choice among them by error, and the refinement of the spectral grid."""

from dataclasses import astuple, dataclass, field, replace
from itertools import pairwise

import numpy as np
import pytest

from hcss_twin import Scenario, make_plan
from hcss_twin.laws.samples import sample_radiance_inputs
from hcss_twin.models.parameters import PhysicalParameters
from hcss_twin.models.radiance.physical.numerics import LEVELS, levels
from hcss_twin.models.radiance.spectral_grid import SpectralBand, SpectralGrid
from hcss_twin.plan.numerics import (
    FIRST_LEVELS,
    NumericalLevel,
    choose_level,
    finest,
    for_spectra,
    reference_level,
    refine_toward,
)
from hcss_twin.providers import Sun, View

BAND = SpectralBand("flat", np.array([3.0, 5.0]), np.array([1.0, 1.0]))
NATIVE = np.arange(1000.0, 4000.0, 50.0)


def test_levels_become_finer_in_every_size():
    for coarse, fine in pairwise(LEVELS):
        *sizes, faint, sublayers, scattered, between, per_octave = astuple(coarse)
        *finer, fainter, more, more_scattered, closer, more_per_octave = astuple(fine)
        assert all(b > a for a, b in zip(sizes, finer, strict=True))
        assert fainter < faint
        assert more >= sublayers
        assert more_scattered >= scattered
        assert closer <= between
        assert more_per_octave >= per_octave


def test_a_tolerance_that_few_sublayers_may_miss_is_compared_with_more():
    first = next(level for limit, level in FIRST_LEVELS if limit < 1e-4)
    assert LEVELS[first].sublayers > LEVELS[first - 1].sublayers


@pytest.mark.parametrize(
    "stated", [{"streams": 8}, {"streams": 32, "sun_streams": 64}, {"azimuth_modes": 4}, {"sun_moments": 16}]
)
def test_stated_sizes_are_used_and_verified_by_finer_ones(stated):
    own, reference = levels(PhysicalParameters(**stated))
    assert own.streams == stated.get("streams", 8)
    assert own.sun_streams == stated.get("sun_streams", 8)
    assert own.azimuth_modes == min(stated.get("azimuth_modes", 16), own.sun_moments)
    assert own.sun_moments == stated.get("sun_moments", own.sun_streams)
    assert reference.streams >= own.streams
    assert reference.sun_streams > own.sun_streams


def test_stated_streams_converge_above_ice():
    """Twice as many moments as streams left 3 % with 8 and 6 % with 32 streams."""
    sizes = {"image.rows": 1, "image.columns": 1, "frames.count": 1, "bands": ["swir-2.7-3.0"]}
    sizes |= {"output.variables": ["cloud_mask"]}  # whose plan chooses no level
    plan = make_plan(Scenario.load("cirrus", sizes))

    def sunlight(assembly):
        found = assembly.cloudy(np.array([3450.0]), np.array([[300.0], [2000.0]]), plan.sun_at(0.0))
        return sum(found.values())

    finest = sunlight(plan.assembly.at_level(len(LEVELS) - 1))
    for streams, most in ((8, 5e-3), (24, 2.5e-3)):
        stated = {f"radiance.parameters.{name}": streams for name in ("streams", "sun_streams", "azimuth_modes")}
        own = make_plan(Scenario.load("cirrus", sizes | stated))
        assert np.abs(sunlight(own.assembly.at_level(0)) / finest - 1.0).max() < most


@dataclass(frozen=True)
class Declared:
    numerical_levels: int


class ModelWithError:
    """Radiance 1 plus errors of diffuse light and, by day, of sunlight: each falls by a factor from level to level.

    The errors of sunlight may be given one by one instead, or for each view by its zenith angle.
    """

    def __init__(self, level, count, steps=0, falls=(0.25, 0.25)):
        self.level, self.declares, self.steps, self.falls = level, Declared(count), steps, falls
        self.terms = {"emission": "of the sea"}

    def columns(self, states, wavenumber_cm1):
        sunlit = min(self.level + self.steps, self.declares.numerical_levels - 1)
        result = states.empty(self.terms, wavenumber_cm1)
        for rows, setting, _ in states.groups():
            diffuse, of_sun = self.falls
            of_sun = of_sun[setting.view.zenith_deg] if isinstance(of_sun, dict) else of_sun
            sunlight = of_sun[sunlit] if isinstance(of_sun, tuple) else 0.04 * of_sun**sunlit
            result["emission"][rows] = 1.0 + 0.04 * diffuse**self.level + (setting.sun is not None) * sunlight
        return result


@dataclass(frozen=True)
class Scene:
    """What the choice needs of an assembly."""

    model: ModelWithError
    numerical_level: int = 0
    sunlight_steps: int = 0
    layers: tuple = ()
    cloudy_layers: tuple = ()
    has_clear_sky: bool = True
    has_cloud: bool = True
    spectral_grid: object = field(default_factory=lambda: SpectralGrid.dense([BAND], NATIVE))
    extreme_thicknesses_m: object = field(default_factory=lambda: np.empty((0, 0)))

    @property
    def air_over_field(self):
        return self

    def together(self, views):
        return [views]

    def suns_of(self, view, suns):
        return suns

    def setting(self, sun, view=None):
        setting = sample_radiance_inputs(layers=()).setting.under(sun)
        return setting if view is None else replace(setting, view=view)

    def at_level(self, level):
        own = self.model
        model = ModelWithError(level, own.declares.numerical_levels, own.steps, own.falls)
        return replace(self, model=model, numerical_level=level)

    def with_finer_sunlight(self, steps):
        own = self.model
        return replace(self, model=ModelWithError(own.level, own.declares.numerical_levels, steps, own.falls))


@pytest.mark.parametrize(("tolerance", "level"), [(0.1, 0), (0.02, 1), (3e-3, 2), (2e-4, 4), (3e-5, 6)])
def test_the_coarsest_level_within_the_tolerance_is_chosen(tolerance, level):
    # differences to the next level, times 1.5: 0.045, 0.011, 0.0028, 7e-4, 1.8e-4, 4.4e-5, 1.1e-5
    chosen = choose_level(Scene(ModelWithError(0, 8)), [None], tolerance)
    assert chosen.level == level
    assert chosen.enough
    assert 0.04 * 0.25**level <= 1.1 * chosen.error <= 1.1 * tolerance


@pytest.mark.parametrize(("sun", "steps"), [(Sun(40.0, 90.0, 1.0), True), (None, False)])
def test_where_sunlight_alone_needs_a_fine_level_all_else_has_fewer_streams(sun, steps):
    scene = Scene(ModelWithError(0, 8, falls=(0.001, 0.3) if steps else (0.3, 0.001)))
    chosen = choose_level(scene, [sun], 5e-4)
    assert chosen.enough
    assert (chosen.sunlight_steps > 0) == steps
    # 1.5 x 0.04 x 0.7 x 0.3^level is within the tolerance from level 4 on; with 0.001, from level 1 on, which a
    # sixteenth of the error of level 0 forbids.
    assert chosen.level + chosen.sunlight_steps == 4
    assert chosen.level == (2 if steps else 4)


SUN = Sun(40.0, 90.0, 1.0)
CHANCE = (1e-2, 0.0, 1.6e-3, 1.65e-3, 2e-4, 0.0, 0.0, 0.0)
"""Errors of levels, of which the third and the fourth agree although they are wrong."""


def test_levels_of_sunlight_that_agree_by_chance_are_compared_with_a_finer_one():
    tolerance = 3e-4
    chosen = choose_level(Scene(ModelWithError(0, 8, falls=(0.001, CHANCE))), [SUN], tolerance)
    assert chosen.enough
    assert CHANCE[chosen.level + chosen.sunlight_steps] < tolerance


def test_agreement_by_chance_toward_another_view_is_compared_with_a_finer_level():
    scene, sun, tolerance = Scene(ModelWithError(0, 8, falls=(0.001, {0.0: 0.01, 30.0: CHANCE}))), [SUN], 3e-4
    toward_middle = NumericalLevel(2, 1e-5, True)
    chosen = refine_toward(scene, toward_middle, [View(0.0, 0.0), View(30.0, 0.0)], sun, tolerance)
    assert chosen.enough
    assert CHANCE[chosen.level + chosen.sunlight_steps] < tolerance
    assert refine_toward(scene, toward_middle, [View(0.0, 0.0)], sun, tolerance).sunlight_steps == 0


def test_several_levels_have_one_that_is_as_fine_as_each():
    one, other = NumericalLevel(2, 1e-4, True, 4), NumericalLevel(3, 2e-4, False, 0)
    assert finest([one, other]) == finest([other, one]) == NumericalLevel(3, 2e-4, False, 3)


def test_a_tolerance_beyond_the_finest_level_is_said():
    chosen = choose_level(Scene(ModelWithError(0, 4)), [None], 1e-6)
    assert chosen.level == 2
    assert not chosen.enough
    assert chosen.error > 1e-6


def test_a_model_without_levels_has_one():
    scene = Scene(ModelWithError(0, 1))
    assert choose_level(scene, [None], 1e-6).level == reference_level(scene) == for_spectra(scene).numerical_level == 0


@pytest.mark.parametrize("refinement", [1, 2])
def test_refined_grids_integrate_cubic_polynomials_exactly(refinement):
    grid = SpectralGrid.dense([BAND], NATIVE, refinement)
    low, high = grid.wavenumber_cm1[[0, -1]]
    values = (grid.wavenumber_cm1 - 2500.0) ** 3
    exact = ((high - 2500.0) ** 4 - (low - 2500.0) ** 4) / 4.0
    assert values @ grid.weights_cm1[0] == pytest.approx(exact, rel=1e-12)


def test_refined_grids_contain_the_coarser_ones():
    coarse, native, fine, finest = (SpectralGrid.dense([BAND], NATIVE, n).wavenumber_cm1 for n in (-1, 0, 1, 2))
    for few, many in ((coarse, native), (native, fine), (native, finest)):
        assert np.all(np.isin(few, many))
    assert fine.size == 2 * native.size - 1
    assert finest.size == 4 * native.size - 3
