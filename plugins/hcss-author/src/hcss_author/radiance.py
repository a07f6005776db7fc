"""Contract tests of radiance models."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
import pytest
from numpy.typing import NDArray

from hcss_author.contract import NoMaker, SpectralContract, holds
from hcss_author.samples import frozen, sample_high_layer, sample_layer, sample_profile
from hcss_twin.laws import questions_of
from hcss_twin.laws.samples import PlainGas, PlainSea, sample_radiance_inputs
from hcss_twin.providers import (
    Array,
    CloudLayer,
    ColumnSetting,
    ColumnStates,
    Kind,
    ProviderError,
    RadianceInputs,
    RadianceModel,
    Sun,
    View,
    clear_column,
    cloudy_columns,
)

NODES = 33
"""Thicknesses, evenly spaced in the logarithm, for the search of bends."""

BENDS = 2
"""Intervals that are bisected."""

HALVINGS = 24
"""Bisections; then an interval is about 1e-8 of its thickness wide, and a change within it is a jump."""

HAIR = 1e-9
"""Relative distance of the checks on either side of a suspected thickness."""


@dataclass(frozen=True)
class Jump:
    """A sudden change.

    Attributes
    ----------
    term : int
        Index of the term.
    thickness_m : float
        Thickness of the jump.
    share : float
        Size, as a fraction of the sum of all terms there.
    """

    term: int
    thickness_m: float
    share: float


def largest_jump(columns: Callable[[Array], Array], low_m: float, high_m: float, suspected_m: Array) -> Jump:
    """Return the largest change of a term over a minute change of thickness.

    At a jump second differences are large at both ends of one interval. The intervals with the largest are bisected
    toward the larger change: smooth changes vanish, a jump stays. A jump smaller than the bends of the curve is only
    detected at suspected thicknesses.

    Parameters
    ----------
    columns : callable
        Maps thicknesses (N,) to terms (N, K, V).
    low_m, high_m : float
        Range of thickness.
    suspected_m : ndarray (S,)
        Thicknesses within the range that are always checked on either side.
    """
    nodes = np.geomspace(low_m, high_m, NODES)
    nodes[0], nodes[-1] = low_m, high_m
    around = np.outer(suspected_m, (1.0 - HAIR, 1.0, 1.0 + HAIR)).ravel()
    terms = columns(np.concatenate((nodes, around)))
    values, beside = terms[:NODES], terms[NODES:].reshape(-1, 3, *terms.shape[1:])
    jumps = [
        _jump(at, one, other)
        for at, triple in zip(suspected_m.tolist(), beside, strict=True)
        for one, other in ((triple[0], triple[1]), (triple[1], triple[2]))
    ]
    bend = np.max(np.abs(np.diff(values, n=2, axis=0)) / _sum(values)[1:-1, None], axis=2)  # (NODES - 2, K)
    bend = np.concatenate((bend[:1], np.minimum(bend[:-1], bend[1:]), bend[-1:]))
    most = np.argsort(np.max(bend, axis=1))[-BENDS:]
    term = np.argmax(bend[most], axis=1)
    left, right, at_left, at_right = nodes[most], nodes[most + 1], values[most], values[most + 1]
    for _ in range(HALVINGS):
        middle = 0.5 * (left + right)
        at_middle = columns(middle)
        lower = _change(at_left, at_middle, term) >= _change(at_middle, at_right, term)
        left, right = np.where(lower, left, middle), np.where(lower, middle, right)
        at_left = np.where(lower[:, None, None], at_left, at_middle)
        at_right = np.where(lower[:, None, None], at_middle, at_right)
    jumps += [_jump(*bracket) for bracket in zip(right.tolist(), at_left, at_right, strict=True)]
    return max(jumps, key=lambda jump: jump.share)


def _jump(thickness_m: float, one: Array, other: Array) -> Jump:
    """Largest difference between the terms (K, V) of two columns."""
    changes = [float(_change(one[None], other[None], np.array([term]))[0]) for term in range(one.shape[0])]
    share = max(changes)
    return Jump(changes.index(share), thickness_m, share)


def _change(one: Array, other: Array, term: NDArray[np.intp]) -> Array:
    """Largest difference (I,) over wavenumbers of one term of each column (I, K, V), as a share of the sum."""
    at_term = np.arange(term.size), term
    change: Array = np.max(np.abs(one[at_term] - other[at_term]) / np.maximum(_sum(one), _sum(other)), axis=1)
    return change


def _sum(terms: Array) -> Array:
    """Sum over terms: (N, K, V) to (N, V); not 0, so that one can divide by it."""
    total: Array = np.maximum(np.sum(terms, axis=1), np.finfo(float).tiny)
    return total


_SUN = Sun(40.0, 200.0, 1.0)
_THICKNESS_M = frozen([[0.0], [50.0], [120.0], [400.0], [800.0]])
"""The first column is clear sky."""

_LAYERS = sample_layer(), sample_high_layer()
_TWO_LAYERS_M = frozen([[50.0, 0.0], [800.0, 0.0], [0.0, 100.0], [0.0, 2000.0], [50.0, 2000.0], [400.0, 150.0]])


@holds(Kind.RADIANCE)
class RadianceModelContract(SpectralContract):
    """Inherit in a class named ``Test...`` and define ``make_provider``.

    Attributes
    ----------
    spectral_tolerance : float
        Relative difference that the other wavenumbers of a call may make, for models that choose their accuracy from
        all of them.
    batch_tolerance : float
        Relative difference that the other columns of a call may make.
    jump_tolerance : float
        Change of any term over some 1e-8 of the thickness, as a share of the radiance.
    """

    _kind = Kind.RADIANCE
    spectral_tolerance: float = 1e-10
    batch_tolerance: float = 1e-10
    jump_tolerance: float = 1e-6

    def make_provider(self, inputs: RadianceInputs) -> RadianceModel:
        """Return the provider under test."""
        raise NoMaker("define make_provider(self, inputs)")

    @pytest.fixture
    def inputs(self) -> RadianceInputs:
        """Inputs from the kit's plain providers; override to choose others."""
        return sample_radiance_inputs()

    @pytest.fixture(params=[None, _SUN], ids=["no sun", "sun"])
    def setting(self, inputs: RadianceInputs, request: pytest.FixtureRequest) -> ColumnSetting:
        """The scene's setting without a sun, and with one at 40 degrees of zenith."""
        return inputs.setting.under(request.param)

    @pytest.fixture
    def questions(self, provider: RadianceModel, inputs: RadianceInputs, wavenumber_cm1: Array) -> tuple[Any, ...]:
        """Columns, and others."""
        return questions_of(Kind.RADIANCE, provider, inputs, wavenumber_cm1=wavenumber_cm1)

    def test_declaration_is_sound(self, provider: RadianceModel) -> None:
        """Names and ranges that the engine understands; solar terms are terms."""
        super().test_declaration_is_sound(provider)
        assert provider.terms
        assert provider.solar_terms <= set(provider.terms)

    def test_every_term_of_every_column(
        self, provider: RadianceModel, setting: ColumnSetting, wavenumber_cm1: Array
    ) -> None:
        """All terms, no others, finite, of shape (N, V), and a sum greater than 0."""
        terms = cloudy_columns(provider, setting, wavenumber_cm1, _THICKNESS_M)
        assert set(terms) == set(provider.terms)
        for name in provider.terms:
            assert terms[name].shape == (_THICKNESS_M.shape[0], wavenumber_cm1.size)
            assert np.all(np.isfinite(terms[name]))
        assert np.all(total(terms) > 0.0)

    @pytest.mark.parametrize("anchor", ["base", "top"])
    def test_radiance_is_continuous_in_thickness(
        self, inputs: RadianceInputs, wavenumber_cm1: Array, anchor: Literal["base", "top"]
    ) -> None:
        """No term jumps, also not where the face of the cloud that moves crosses a level of the profile."""
        layer = _layer_across_levels(inputs, anchor)
        provider = self.make_provider(_with_layers(inputs, layer))
        setting = replace(inputs.setting, layers=(layer,), sun=_SUN)
        names, some = list(provider.terms), wavenumber_cm1[::4]

        def columns(thickness_m: Array) -> Array:
            terms = cloudy_columns(provider, setting, some, thickness_m[:, None])
            return np.stack([terms[name] for name in names], axis=1)

        low, high, level = layer.thickness_min_m, layer.thickness_max_m, inputs.setting.profile.altitude_m
        crossing = level - layer.base_m if anchor == "base" else layer.top_m - level
        suspected = crossing[(crossing > 1.001 * low) & (crossing < 0.999 * high)]
        jump = largest_jump(columns, low, high, suspected)
        face = layer.base_m + jump.thickness_m if anchor == "base" else layer.top_m - jump.thickness_m
        assert jump.share <= self.jump_tolerance, (
            f"term '{names[jump.term]}' jumps by {jump.share:.2g} of the radiance where the cloud between "
            f"{layer.base_m:g} and {layer.top_m:g} m with a fixed {anchor} is {jump.thickness_m:.8g} m thick, its "
            f"{'top' if anchor == 'base' else 'base'} at {face:.8g} m"
        )

    def test_no_sun_no_solar_term(self, provider: RadianceModel, inputs: RadianceInputs, wavenumber_cm1: Array) -> None:
        """Exactly 0."""
        terms = cloudy_columns(provider, inputs.setting, wavenumber_cm1, _THICKNESS_M)
        for name in provider.solar_terms:
            assert not np.any(terms[name])

    def test_result_does_not_depend_on_batching(
        self, provider: RadianceModel, setting: ColumnSetting, wavenumber_cm1: Array
    ) -> None:
        """Each column alone gives the same value as together, also among columns of another view, sun, sea and air."""
        for other in _other_settings(setting):
            states = ColumnStates.product([setting, other], _THICKNESS_M)
            together = provider.columns(states, wavenumber_cm1)
            for rows, own, thickness_m in states.groups():
                for row, thickness in zip(rows.tolist(), thickness_m, strict=True):
                    alone = cloudy_columns(provider, own, wavenumber_cm1, thickness[None])
                    for name in provider.terms:
                        np.testing.assert_allclose(
                            alone[name][0], together[name][row], rtol=self.batch_tolerance, atol=1e-18
                        )

    def test_columns_are_those_of_their_settings(
        self, provider: RadianceModel, inputs: RadianceInputs, setting: ColumnSetting, wavenumber_cm1: Array
    ) -> None:
        """View, sun, sea, air and layers are those of the states, not of the inputs."""
        for other in _other_settings(setting):
            own = self.make_provider(replace(inputs, setting=other.under(None)))
            expected = cloudy_columns(own, other, wavenumber_cm1, _THICKNESS_M)
            found = cloudy_columns(provider, other, wavenumber_cm1, _THICKNESS_M)
            for name in provider.terms:
                np.testing.assert_allclose(found[name], expected[name], rtol=self.batch_tolerance, atol=1e-18)

    def test_result_does_not_depend_on_other_wavenumbers(
        self, provider: RadianceModel, setting: ColumnSetting, wavenumber_cm1: Array
    ) -> None:
        """A subset of the wavenumbers gives the same values as the full set."""
        together, apart = (
            cloudy_columns(provider, setting, nu, _THICKNESS_M) for nu in (wavenumber_cm1, wavenumber_cm1[1::3])
        )
        for name in provider.terms:
            np.testing.assert_allclose(apart[name], together[name][..., 1::3], rtol=self.spectral_tolerance, atol=1e-18)

    def test_undeclared_thickness_and_sun_have_no_influence(
        self, provider: RadianceModel, inputs: RadianceInputs, wavenumber_cm1: Array
    ) -> None:
        """Variables not in ``declares.depends_on`` do not change the result."""
        lit = inputs.setting.under(_SUN)
        usual = cloudy_columns(provider, lit, wavenumber_cm1, _THICKNESS_M)
        others = {
            "thickness": (lit, _THICKNESS_M[::-1]),
            "sun_zenith": (lit.under(Sun(50.0, 200.0, 1.0)), _THICKNESS_M),
            "relative_azimuth": (lit.under(Sun(40.0, 290.0, 1.0)), _THICKNESS_M),
        }
        if provider.declares.depends_on is None:
            pytest.skip("the model does not say on which variables it depends")
        for dependency in others.keys() - provider.declares.depends_on:
            setting, thickness_m = others[dependency]
            changed = cloudy_columns(provider, setting, wavenumber_cm1, thickness_m)
            for name in provider.terms:
                if dependency == "thickness":  # but for clear sky
                    np.testing.assert_array_equal(changed[name][:-1], usual[name][1:], err_msg=dependency)
                else:
                    np.testing.assert_array_equal(changed[name], usual[name], err_msg=dependency)

    def test_clear_columns_do_not_depend_on_the_layers(
        self, provider: RadianceModel, inputs: RadianceInputs, setting: ColumnSetting, wavenumber_cm1: Array
    ) -> None:
        """A scene without cloud layers equals the clear column of one with them."""
        cloudless = self.make_provider(_with_layers(inputs))
        without = clear_column(cloudless, replace(setting, layers=()), wavenumber_cm1)
        beside = clear_column(provider, setting, wavenumber_cm1)
        for name in provider.terms:
            np.testing.assert_allclose(without[name], beside[name], rtol=1e-10, atol=1e-18)

    @pytest.fixture
    def two_layers(self, inputs: RadianceInputs) -> RadianceModel:
        """Provider of a scene with a low and a high layer; a model of one layer raises an error in its constructor."""
        try:
            return self.make_provider(_with_layers(inputs, *_LAYERS))
        except ProviderError as error:
            pytest.skip(str(error))

    def test_columns_of_two_layers(
        self, two_layers: RadianceModel, setting: ColumnSetting, wavenumber_cm1: Array
    ) -> None:
        """All terms (N, V), finite, with a sum greater than 0 that does not depend on batching."""
        setting = replace(setting, layers=_LAYERS)
        together = cloudy_columns(two_layers, setting, wavenumber_cm1, _TWO_LAYERS_M)
        assert set(together) == set(two_layers.terms)
        assert np.all(total(together) > 0.0)
        for i in range(_TWO_LAYERS_M.shape[0]):
            alone = cloudy_columns(two_layers, setting, wavenumber_cm1, _TWO_LAYERS_M[i : i + 1])
            for name in two_layers.terms:
                assert np.all(np.isfinite(together[name]))
                np.testing.assert_allclose(alone[name][0], together[name][i], rtol=1e-10, atol=1e-18)

    def test_a_layer_without_cloud_has_no_influence(
        self, two_layers: RadianceModel, inputs: RadianceInputs, setting: ColumnSetting, wavenumber_cm1: Array
    ) -> None:
        """A column with cloud in one of two layers is that of a scene which has only this layer."""
        of_both = replace(setting, layers=_LAYERS)
        for index, layer in enumerate(_LAYERS):
            rows = (_TWO_LAYERS_M[:, index] > 0) & (_TWO_LAYERS_M[:, 1 - index] == 0)
            single = self.make_provider(_with_layers(inputs, layer))
            of_one = replace(setting, layers=(layer,))
            alone = cloudy_columns(single, of_one, wavenumber_cm1, _TWO_LAYERS_M[rows, index : index + 1])
            among = cloudy_columns(two_layers, of_both, wavenumber_cm1, _TWO_LAYERS_M[rows])
            for name in two_layers.terms:
                np.testing.assert_allclose(among[name], alone[name], rtol=1e-10, atol=1e-18)


def _with_layers(inputs: RadianceInputs, *layers: CloudLayer) -> RadianceInputs:
    return replace(inputs, setting=replace(inputs.setting, layers=layers))


def _other_settings(setting: ColumnSetting) -> list[ColumnSetting]:
    """Return settings that differ in view, sun, sea, its temperature, air and layers, one at a time."""
    view = View(setting.view.zenith_deg + 5.0, setting.view.azimuth_deg + 20.0)
    profile = sample_profile(270.0)
    raised = [replace(layer, base_m=layer.base_m + 100.0, top_m=layer.top_m + 100.0) for layer in setting.layers]
    return [
        replace(setting, view=view),
        setting.under(Sun(55.0, 160.0, 1.0)),
        replace(setting, sea=PlainSea(0.9)),
        replace(setting, sea_temperature_K=setting.sea_temperature_K + 3.0),
        replace(setting, profile=profile, transmittance=PlainGas(profile, 0.5)),
        replace(setting, layers=tuple(raised)),
    ]


def _layer_across_levels(inputs: RadianceInputs, anchor: Literal["base", "top"]) -> CloudLayer:
    """Return a layer like the lowest one of ``inputs`` and high enough to cross two levels above its base."""
    layer = inputs.setting.layers[0] if inputs.setting.layers else sample_layer()
    above = inputs.setting.profile.altitude_m[inputs.setting.profile.altitude_m > layer.base_m]
    top = float(0.5 * (above[1] + above[2])) if above.size > 2 else layer.top_m
    return replace(layer, top_m=max(top, layer.top_m), anchor=anchor)


def total(terms: Mapping[str, Array]) -> Array:
    """Return the sum of all terms."""
    result: Array = np.sum(list(terms.values()), axis=0)
    return result
