"""Contract tests of surface providers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest

from hcss_author.contract import NoMaker, ProviderContract, holds
from hcss_author.samples import frozen, sample_surface_inputs, sample_wavenumbers
from hcss_author.sea import SeaModelContract
from hcss_twin.laws import laws_of, questions_of
from hcss_twin.providers import Array, Kind, SeaModel, SurfaceInputs, SurfaceMap, SurfaceProvider

PLAUSIBLE_K = (150.0, 400.0)
"""Temperatures of sea, land and ice in kelvin; another unit is outside."""

_WINDOW_CM1 = 900.0
"""Where natural surfaces emit best."""

_SEA_LAWS = laws_of(Kind.SEA)

_OF_ANY_SURFACE: tuple[Callable[[SeaModel, Array], None], ...] = (
    SeaModelContract().test_emissivity_shape_type_and_range,
    SeaModelContract().test_brdf_shape_type_and_range,
    SeaModelContract().test_result_does_not_depend_on_batching,
    _SEA_LAWS["albedo_and_emissivity_sum_to_one"],
    _SEA_LAWS["no_more_is_reflected_than_is_not_emitted"],
    _SEA_LAWS["brdf_is_reciprocal"],
)


@dataclass(frozen=True)
class KnownSurface:
    """What the author of a surface knows of one place.

    Attributes
    ----------
    latitude, longitude : float
        Degrees.
    name : str
        Class there.
    temperature_K : float, optional
        Temperature there, to 0.1 K, if the class has one.
    time_s : float
        Time after the start.
    """

    latitude: float
    longitude: float
    name: str
    temperature_K: float | None = None
    time_s: float = 0.0


@holds(Kind.SURFACES)
class SurfaceContract(ProviderContract):
    """Inherit in a class named ``Test...`` and define ``make_provider``.

    Attributes
    ----------
    times_s : tuple of float
        Times of the calls.
    is_still : bool
        Whether the surface is the same at all times.
    known : tuple of KnownSurface
        Places whose class and temperature are checked: no other law can know them.
    least_emissivity : float
        Lowest emissivity of a boundary at 900 cm-1; lower for bare metals.
    """

    _kind = Kind.SURFACES
    times_s: tuple[float, ...] = (0.0, 2.0, 7.5)
    is_still: bool = True
    known: tuple[KnownSurface, ...] = ()
    least_emissivity: float = 0.5

    def make_provider(self, inputs: SurfaceInputs) -> SurfaceProvider:
        """Return the provider under test."""
        raise NoMaker("define make_provider(self, inputs)")

    @pytest.fixture
    def inputs(self) -> SurfaceInputs:
        """Inputs; override to choose others."""
        return sample_surface_inputs()

    @pytest.fixture
    def questions(self, inputs: SurfaceInputs) -> tuple[Any, ...]:
        """The whole image and a window of it."""
        return questions_of(Kind.SURFACES, None, inputs)

    def test_classes_have_names_of_the_declaration(self, provider: SurfaceProvider, inputs: SurfaceInputs) -> None:
        """Numbers of declared classes, for every point of the window."""
        found = set()
        for time in self.times_s:
            found |= set(np.unique(_whole(self._guarded(provider), inputs, time).number).tolist())
        assert found, "the map is empty"

    def test_temperatures_are_kelvin_within_the_limits_of_their_class(
        self, provider: SurfaceProvider, inputs: SurfaceInputs
    ) -> None:
        """Finite where the class has a field of temperature, within its limits, and of a size that means kelvin."""
        for class_ in provider.classes:
            ends = class_.temperature_K if isinstance(class_.temperature_K, tuple) else (class_.temperature_K,)
            assert all(end is None or PLAUSIBLE_K[0] <= end <= PLAUSIBLE_K[1] for end in ends), class_.name
        for time in self.times_s:
            _whole(self._guarded(provider), inputs, time)

    def test_the_ground_is_that_of_the_window(self, inputs: SurfaceInputs) -> None:
        """Places that a call asks for, if any, reach around the window or just to its edges."""
        asked: list[tuple[slice, slice]] = []

        def ground(time_s: float, rows: slice, columns: slice) -> tuple[Array, Array]:
            asked.append((rows, columns))
            return inputs.ground(time_s, rows, columns)

        provider = self.make_provider(replace(inputs, ground=ground))
        window = slice(3, inputs.grid.rows - 7), slice(9, inputs.grid.columns - 4)
        asked.clear()
        provider.surface(self.times_s[0], *window)
        if not asked:
            pytest.skip("the surface does not ask for places")
        for name, given, seen in zip(("rows", "columns"), window, zip(*asked, strict=True), strict=True):
            first, last = min(cut.start for cut in seen), max(cut.stop for cut in seen)
            assert first <= given.start < given.stop <= last, (
                f"{name} {first} to {last} for {given.start} to {given.stop}"
            )

    def test_a_surface_that_is_not_still_changes(self, provider: SurfaceProvider, inputs: SurfaceInputs) -> None:
        """Where ``is_still`` is False, two of ``times_s`` differ."""
        if self.is_still:
            pytest.skip("the surface is still")
        first, *others = (_whole(self._guarded(provider), inputs, time) for time in self.times_s)
        changes = [
            not np.array_equal(one, same, equal_nan=one.dtype.kind == "f")
            for other in others
            for one, same in ((other.number, first.number), (other.temperature_K, first.temperature_K))
            if one is not None and same is not None
        ]
        assert any(changes), "time has no influence, but is_still is False"

    def test_places_are_those_that_are_known(self, inputs: SurfaceInputs) -> None:
        """Class and temperature at each place of ``known``."""
        if not self.known:
            pytest.skip("set known = (KnownSurface(...), ...) to have classes and temperatures of places checked")
        for known in self.known:

            def ground(time_s: float, rows: slice, columns: slice, at: KnownSurface = known) -> tuple[Array, Array]:
                shape = rows.stop - rows.start, columns.stop - columns.start
                return frozen(np.full(shape, at.latitude)), frozen(np.full(shape, at.longitude))

            provider = self.make_provider(replace(inputs, ground=ground))
            found = provider.surface(known.time_s, slice(0, 1), slice(0, 1))
            surface = provider.classes[int(found.number[0, 0])]
            assert surface.name == known.name, f"'{surface.name}' at {known}"
            if known.temperature_K is not None:
                kelvin = surface.temperature_K
                if isinstance(kelvin, tuple):
                    assert found.temperature_K is not None
                    kelvin = float(found.temperature_K[0, 0])
                assert kelvin == pytest.approx(known.temperature_K, abs=0.1), f"{kelvin} K at {known}"

    def test_the_map_moves_with_the_ground(self, provider: SurfaceProvider, inputs: SurfaceInputs) -> None:
        """As the platform moves by whole points, the map moves by as many, unless the surface changes with time."""
        if not self.is_still:
            pytest.skip("the surface changes with time")

        def moving(time_s: float, rows: slice, columns: slice) -> tuple[Array, Array]:
            way = round(3.0 * time_s)
            return inputs.ground(0.0, rows, slice(columns.start + way, columns.stop + way))

        window = slice(0, inputs.grid.rows), slice(0, inputs.grid.columns)
        beside = window[0], slice(3, inputs.grid.columns + 3)
        one, other = (self.make_provider(given) for given in (inputs, replace(inputs, ground=moving)))
        expected, seen = one.surface(0.0, *beside), other.surface(1.0, *window)
        np.testing.assert_array_equal(seen.number, expected.number)
        if expected.temperature_K is not None and seen.temperature_K is not None:
            np.testing.assert_allclose(seen.temperature_K, expected.temperature_K, atol=1e-3)

    def test_boundaries_obey_the_laws_of_a_sea_model(self, provider: SurfaceProvider) -> None:
        """Those of any surface, and an emissivity that is not a reflectance."""
        for class_ in provider.classes:
            boundary = class_.boundary
            if boundary is None:  # the scenario's sea, or a Lambertian surface of the engine
                continue
            wavenumber = sample_wavenumbers(boundary.declares, 4)
            try:
                for check in _OF_ANY_SURFACE:
                    check(boundary, wavenumber)
                low, high = boundary.declares.valid.get("wavenumber_cm1", (_WINDOW_CM1, _WINDOW_CM1))
                if low <= _WINDOW_CM1 <= high:
                    upward = boundary.emissivity(frozen([_WINDOW_CM1]), frozen([1.0]))[0, 0]
                    assert upward >= self.least_emissivity, f"emissivity at {_WINDOW_CM1:g} cm-1 is {upward:g}"
            except Exception as error:
                error.add_note(f"the boundary of class '{class_.name}'")
                raise


def _whole(provider: SurfaceProvider, inputs: SurfaceInputs, time_s: float) -> SurfaceMap:
    return provider.surface(time_s, slice(0, inputs.grid.rows), slice(0, inputs.grid.columns))
