"""The plan: what a scene needs, what it does not, and why; made without computing the scene."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.core.catalog import Catalog
from hcss_twin.cube.variables import LAYER, VariableSpec
from hcss_twin.cube.writer import largest_error
from hcss_twin.models.radiance.spectral_grid import SpectralBand, SpectralGrid
from hcss_twin.physics.profile import Profile
from hcss_twin.plan.accuracy import Budget, RequestedAccuracy, share_out
from hcss_twin.plan.assembly import Assembly
from hcss_twin.plan.clouds import told
from hcss_twin.plan.few_columns import Omission
from hcss_twin.plan.lines_of_sight import SunTrack, detector_notes, platform_facts
from hcss_twin.plan.output import wants_radiance
from hcss_twin.plan.sensor import MadeSensor
from hcss_twin.plan.slant_paths import SlantPaths
from hcss_twin.plan.surroundings import FilledIn
from hcss_twin.plan.views import ViewAxis
from hcss_twin.plan.waves import DRAWN_NOTE, DrawnWaves
from hcss_twin.plan.windows import Window, length
from hcss_twin.providers import CloudGenerator, CloudLayer, Grid, Optics, RadianceModel, Sun, View
from hcss_twin.providers.registry.specs import Kind
from hcss_twin.scenario.scenario import Scenario


@dataclass(frozen=True)
class Plan:
    """Everything a run needs, resolved and checked.

    Attributes
    ----------
    frame_times_s : ndarray (F,)
        Seconds after the scenario's start.
    sun_zenith_deg, sun_azimuth_deg : ndarray (F,)
        At each frame.
    variables : tuple of VariableSpec
        What the cube will hold.
    accuracy : RequestedAccuracy
        As a share of the radiance of every band.
    waves : DrawnWaves or None
        None where the sea is averaged over its waves.
    faint_sunlight : float or None
        Largest share of sunlight in any band, where radiance is computed without it by day; else None.
    sensor : MadeSensor or None
        Of the measured cube beside the clean one; the clean one does not depend on it.
    views : ViewAxis or None
        None where the view of the image centre stands for all pixels.
    """

    scenario: Scenario
    catalog: Catalog
    assembly: Assembly
    frame_times_s: Array
    sun_track: SunTrack
    sun_zenith_deg: Array
    sun_azimuth_deg: Array
    variables: tuple[VariableSpec, ...]
    skipped: tuple[Omission, ...]
    filled_in: tuple[FilledIn, ...]
    waves: DrawnWaves | None
    accuracy: RequestedAccuracy
    faint_sunlight: float | None = None
    sensor: MadeSensor | None = None
    views: ViewAxis | None = None

    @property
    def budget(self) -> Budget:
        """What each of the engine's approximations may err by."""
        return share_out(self.accuracy.relative)

    @property
    def notes(self) -> tuple[str, ...]:
        """What users should know about what this scene makes use of."""
        names = {spec.name for spec in self.variables}
        notes = self.assembly.notes_where(
            air="cloud_top_temperature" in names,
            particles=self.needs_radiance or "cloud_optical_thickness" in names,
            radiance=self.needs_radiance,
            sunlight=self.sun_matters,
        )
        resolution = self.assembly.transmittance.declares.resolution_cm1
        atmosphere = self.assembly.entries[str(Kind.ATMOSPHERE)].name
        narrow = (
            f"band '{band.name}' is {band.width_cm1:.3g} cm-1 wide, but the atmosphere '{atmosphere}' knows means over "
            f"{resolution:g} cm-1: lines within it are not resolved, whatever the accuracy"
            for band in self.bands
            if self.needs_radiance and band.width_cm1 < resolution
        )
        drawn = () if self.waves is None else (DRAWN_NOTE,)
        return (*narrow, *notes, *drawn, *detector_notes(self.scenario))

    @property
    def bands(self) -> tuple[SpectralBand, ...]:
        """Resolved bands."""
        return self.assembly.bands

    @property
    def spectral_grid(self) -> SpectralGrid:
        """Wavenumbers and band weights."""
        return self.assembly.spectral_grid

    @property
    def model(self) -> RadianceModel:
        """Radiance model."""
        return self.assembly.model

    @property
    def optics(self) -> Optics:
        """Optics provider."""
        return self.assembly.optics

    @property
    def profile(self) -> Profile:
        """Atmospheric profile."""
        return self.assembly.profile

    @property
    def layers(self) -> tuple[CloudLayer, ...]:
        """Cloud layers, from the lowest to the highest."""
        return self.assembly.layers

    @property
    def generators(self) -> tuple[CloudGenerator, ...]:
        """The cloud generator of each layer."""
        return self.assembly.generators

    @property
    def cloudy_layers(self) -> tuple[bool, ...]:
        """Of each layer whether any pixel can have its cloud."""
        return self.assembly.cloudy_layers

    @property
    def extreme_thicknesses_m(self) -> Array:
        """Columns (N, L) with the thinnest and the thickest cloud, or none, of each layer; not all without."""
        return self.assembly.extreme_thicknesses_m

    @property
    def view(self) -> View:
        """Viewing direction."""
        return self.assembly.view

    @property
    def slant(self) -> SlantPaths:
        """Where slant paths meet the clouds."""
        return self.assembly.slant

    @property
    def grid(self) -> Grid:
        """Image plane, in pixels."""
        return self.assembly.grid

    @property
    def samples_per_pixel(self) -> int:
        """Points along each side of a pixel."""
        return self.scenario.image.samples_per_pixel

    @property
    def extent(self) -> Window:
        """Rows and columns of the image that are computed."""
        return extent_of(self.scenario)

    @property
    def pixels(self) -> tuple[int, int]:
        """Rows and columns of the cube."""
        rows, columns = self.extent
        return length(rows), length(columns)

    @property
    def is_window(self) -> bool:
        """Whether the cube is a part of the image."""
        return self.pixels != (self.grid.rows, self.grid.columns)

    @property
    def needs_radiance(self) -> bool:
        """Whether any requested variable needs radiance."""
        return wants_radiance(self.variables)

    @property
    def sun_matters(self) -> bool:
        """Whether the sun is up in at least one frame, and its light enough to be computed."""
        return self.faint_sunlight is None and bool(np.any(self.sun_zenith_deg < 90.0))

    def sun_at(self, time_s: float) -> Sun | None:
        """Sun that radiance is computed with at a time, None below the horizon or where its light is left out."""
        return self.sun_up_at(time_s) if self.sun_matters else None

    def sun_up_at(self, time_s: float) -> Sun | None:
        """Sun at a time, None below the horizon."""
        sun = self.sun_track.at(time_s)
        return sun if sun.is_up else None

    @property
    def uncompressed_bytes(self) -> int:
        """Size of the data variables without compression."""
        sizes = {
            "time": self.frame_times_s.size,
            "band": len(self.bands),
            "y": self.pixels[0],
            "x": self.pixels[1],
            LAYER: len(self.layers),
        }
        return sum(
            math.prod(sizes[dim] for dim in spec.dims) * np.dtype(spec.dtype).itemsize for spec in self.variables
        )

    def as_dict(self) -> Mapping[str, Any]:
        """Plain values for ``hcss plan --json``."""
        return {
            "frames": int(self.frame_times_s.size),
            "rows": self.pixels[0],
            "columns": self.pixels[1],
            "window_of": [self.grid.rows, self.grid.columns] if self.is_window else None,
            "samples_per_pixel": self.samples_per_pixel,
            "view": {"zenith_deg": self.view.zenith_deg, "azimuth_deg": self.view.azimuth_deg},
            "platform": platform_facts(self.scenario, self.assembly.lines_of_sight),
            "views": None if self.views is None else vars(self.views),
            "layers": [
                {
                    "name": layer.name,
                    "base_m": layer.base_m,
                    "top_m": layer.top_m,
                    "coverage": layer.coverage,
                    "coverage_mode": layer.coverage_mode,
                    "particles": told(layer),
                }
                for layer in self.layers
            ],
            "bands": [{"name": band.name, "lower_um": band.lower_um, "upper_um": band.upper_um} for band in self.bands],
            "providers": {
                kind: {"name": entry.name, "distribution": entry.distribution, "version": entry.version}
                for kind, entry in self.assembly.entries.items()
            },
            "sun": {
                "zenith_deg": [float(self.sun_zenith_deg[0]), float(self.sun_zenith_deg[-1])],
                "azimuth_deg": [float(self.sun_azimuth_deg[0]), float(self.sun_azimuth_deg[-1])],
            },
            "wavenumbers": int(self.spectral_grid.wavenumber_cm1.size),
            "accuracy": {**vars(self.accuracy), "budget": self.budget.as_dict()},
            "variables": [spec.name for spec in self.variables],
            "uncompressed_bytes": self.uncompressed_bytes,
            "quantization": {
                spec.name: {"bits": spec.significant_bits, "relative_error": largest_error(spec.significant_bits)}
                for spec in self.variables
                if spec.significant_bits is not None
            },
            "filled_in": [vars(item) for item in self.filled_in],
            "notes": list(self.notes),
            "skipped": [vars(item) for item in self.skipped],
            **({} if self.sensor is None else {"sensor": self.sensor.as_dict()}),
        }


def extent_of(scenario: Scenario) -> Window:
    """Return the rows and columns of a scenario's image that are computed."""
    image = scenario.image
    size, window = (image.rows, image.columns), image.window
    return (slice(0, size[0]), slice(0, size[1])) if window is None else window.slices(*size)
