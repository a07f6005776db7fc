"""Case files: the air, the sea and the forcings of a simulation, as TOML.

Profiles are lists of [height in m, value], linear between, constant beyond.
"""

from __future__ import annotations

import itertools
import tomllib
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator
from pydantic.functional_validators import AfterValidator

from hcss_skies.les.thermodynamics import CP, LATENT
from hcss_twin.providers import Array, CatalogError, choose_from

CASES = Path(__file__).parent / "cases"
"""Folder of the shipped cases."""


def _ascending(pairs: list[tuple[float, float]]) -> list[tuple[float, float]]:
    if not pairs or any(b[0] <= a[0] for a, b in itertools.pairwise(pairs)):
        raise ValueError("heights must ascend, and there must be at least one")
    return pairs


Pairs = Annotated[list[tuple[float, float]], AfterValidator(_ascending)]
"""A profile."""

Positive = Annotated[float, Field(gt=0.0)]


class _Section(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


class GridSection(_Section):
    """Box and cells."""

    columns: tuple[Annotated[int, Field(ge=4, le=4096)], Annotated[int, Field(ge=4, le=4096)]]
    side_m: Positive
    top_m: Positive = Field(description="Height of the lid above the floor; all heights of a case are above the floor.")
    floor_m: float = Field(0.0, ge=0.0, le=1e4, description="Altitude of the floor: 0 is the sea.")
    spacing_m: Positive | Pairs = Field(description="Depth of levels; or pairs of height and depth: a stretched grid.")
    sponge_bottom_m: Positive
    sponge_rate_s: float = Field(0.01, ge=0.0, le=0.05, description="At the lid, s-1.")

    @model_validator(mode="after")
    def _fits(self) -> GridSection:
        if self.sponge_bottom_m >= self.top_m:
            raise ValueError(f"sponge_bottom_m {self.sponge_bottom_m:g}: must be below top_m {self.top_m:g}")
        depths = [depth for _, depth in self.spacing_m] if isinstance(self.spacing_m, list) else [self.spacing_m]
        if min(depths) <= 0.0 or not self.top_m / max(depths) >= 6 or self.top_m / min(depths) > 2000:
            raise ValueError(f"spacing_m {self.spacing_m}: must give 6 to 2000 levels below top_m {self.top_m:g}")
        return self


class AirSection(_Section):
    """The air at the beginning."""

    surface_pressure_Pa: float = Field(ge=2.5e4, le=1.1e5, description="At the floor.")
    heat_capacity_J_kg_K: float = Field(CP, ge=1000.0, le=1030.0, description="Of air; cases differ.")
    latent_heat_J_kg: float = Field(LATENT, ge=2.4e6, le=2.6e6, description="Of vaporisation; cases differ.")
    theta_l_K: Pairs
    cube_root_above_m: float | None = Field(
        None, description="Adds (z - this)^(1/3) K to theta_l above this height (Stevens et al. 2005, eq. 1)."
    )
    water_g_kg: Pairs
    u_m_s: Pairs = [(0.0, 0.0)]
    v_m_s: Pairs = [(0.0, 0.0)]
    frame_m_s: tuple[float, float] = Field((0.0, 0.0), description="Velocity of the box, best that of the clouds.")
    noise_K: float = Field(0.1, ge=0.0, le=1.0, description="Amplitude of the uniform noise in theta_l at the start.")
    noise_g_kg: float = Field(0.025, ge=0.0, le=0.5)
    noise_below_m: Positive = 500.0

    @model_validator(mode="after")
    def _is_possible(self) -> AirSection:
        for name, pairs, low, high in (("theta_l_K", self.theta_l_K, 200.0, 500.0),
                                       ("water_g_kg", self.water_g_kg, 0.0, 40.0)):  # fmt: skip
            for height, value in pairs:
                if not low <= value <= high:
                    raise ValueError(f"{name} at {height:g} m: {value:g} given, allowed: {low:g} to {high:g}")
        return self


class ForcingSection(_Section):
    """What the air around the box does."""

    coriolis_s: float = Field(default=0.0, ge=-1.5e-4, le=1.5e-4)
    geostrophic_u_m_s: Pairs = [(0.0, 0.0)]
    geostrophic_v_m_s: Pairs = [(0.0, 0.0)]
    subsidence_m_s: Pairs = Field(
        default=[(0.0, 0.0)], description="Vertical speed of the air around, negative downward."
    )
    theta_l_K_day: Pairs = Field(default=[(0.0, 0.0)], description="Tendency of theta_l: radiation and advection.")
    water_g_kg_day: Pairs = Field(default=[(0.0, 0.0)], description="Tendency of total water: advection.")
    begin_hours: float = Field(default=0.0, ge=0.0, description="Subsidence and tendencies are 0 before.")
    inversion_water_g_kg: Positive | None = Field(
        default=None,
        description="Subsidence and tendencies follow the height where mean total water falls through this.",
    )

    @property
    def varies(self) -> bool:
        """Whether subsidence and tendencies change with time."""
        return self.begin_hours > 0.0 or self.inversion_water_g_kg is not None


class SurfaceSection(_Section):
    """The sea."""

    heat_K_m_s: float | None = Field(None, description="Kinematic flux of theta_l.")
    water_g_kg_m_s: float | None = Field(None, description="Kinematic flux of water.")
    sensible_W_m2: float | None = None
    latent_W_m2: float | None = None
    friction_velocity_m_s: float | None = Field(None, ge=0.0)
    sea_K: float | None = Field(None, ge=260.0, le=320.0)
    drag: float | None = Field(None, ge=0.0, le=0.02)
    heat_coefficient: float | None = Field(None, ge=0.0, le=0.02)
    water_coefficient: float | None = Field(None, ge=0.0, le=0.02)

    @model_validator(mode="after")
    def _are_given_once(self) -> SurfaceSection:
        for what, choices in (
            ("heat", ("heat_K_m_s", "sensible_W_m2", "heat_coefficient")),
            ("water", ("water_g_kg_m_s", "latent_W_m2", "water_coefficient")),
            ("stress", ("friction_velocity_m_s", "drag")),
        ):
            given = [name for name in choices if getattr(self, name) is not None]
            if len(given) != 1:
                raise ValueError(
                    f"flux of {what}: {', '.join(given) or 'nothing'} given, allowed: one of {', '.join(choices)}"
                )
        if self.sea_K is None and (self.heat_coefficient is not None or self.water_coefficient is not None):
            raise ValueError("sea_K: missing, needed by heat_coefficient and water_coefficient")
        return self


class RadiationSection(_Section):
    """The two-stream law of DYCOMS-II (Stevens et al. 2005, eq. 3)."""

    f_0_W_m2: float = Field(ge=0.0)
    f_1_W_m2: float = Field(ge=0.0)
    kappa_m2_kg: Positive
    a_z: float = Field(1.0, ge=0.0)
    divergence_s: float = Field(ge=0.0)
    density_kg_m3: Positive
    inversion_water_g_kg: Positive


class RainSection(_Section):
    """Warm rain."""

    droplets_cm3: float = Field(70.0, ge=5.0, le=2000.0)


class SettlingSection(_Section):
    """Droplets of clouds that settle."""

    droplets_cm3: float = Field(100.0, ge=5.0, le=2000.0)
    sigma: float = Field(1.5, ge=1.0, le=2.0, description="Geometric standard deviation of their radii.")


class OutputSection(_Section):
    """When to look."""

    hours: Positive
    spin_up_hours: float = Field(0.0, ge=0.0, description="Pictures before are spin-up and not kept.")
    picture_s: Positive = 60.0
    statistics_s: Positive = 300.0
    volume_s: Positive | None = Field(None, description="Between volumes of extinction; by default there are none.")
    droplets_cm3: Positive = Field(100.0, description="For the optical thickness.")

    @model_validator(mode="after")
    def _has_pictures(self) -> OutputSection:
        if self.spin_up_hours > self.hours:
            raise ValueError(f"spin_up_hours {self.spin_up_hours:g}: must not be above hours {self.hours:g}")
        return self


class Case(_Section):
    """One simulation."""

    title: str
    source: str = Field(description="Publication of forcings, with page.")
    grid: GridSection
    air: AirSection
    forcing: ForcingSection = ForcingSection()
    surface: SurfaceSection
    radiation: RadiationSection | None = None
    rain: RainSection | None = None
    settling: SettlingSection | None = None
    output: OutputSection
    seed: int = Field(1, ge=0, le=2**32 - 1)
    precision: Literal["single", "double"] = "single"
    longest_step_s: float = Field(10.0, gt=0.0, le=60.0)
    courant: float = Field(1.0, gt=0.0, le=1.2, description="Largest sum of Courant numbers of the axes.")


def shipped() -> dict[str, Path]:
    """Return the shipped cases by name."""
    return {path.stem: path for path in sorted(CASES.glob("*.toml"))}


def read_case(name: str, **changed: object) -> Case:
    """Read a shipped case, or a file.

    Parameters
    ----------
    name : str
        Name of a shipped case, or path of a TOML file.
    **changed
        Values that replace those of the file: of a section as a table of its fields.

    Raises
    ------
    CatalogError
        If there is no such case, or a value is not allowed; with field, value and what is allowed.
    """
    path = shipped().get(name, Path(name))
    if not path.is_file():
        raise CatalogError(f"case '{name}': {choose_from(name, shipped())}, or a TOML file")
    try:
        table = tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise CatalogError(f"{path}: not a readable TOML file: {error}") from error
    for key, value in changed.items():
        table[key] = {**table.get(key, {}), **value} if isinstance(value, dict) else value
    return case_of(table, str(path))


def case_of(table: dict[str, object], name: str) -> Case:
    """Return the case of a table, or raise CatalogError with the name of its origin and every wrong field."""
    try:
        return Case.model_validate(table)
    except ValidationError as error:
        problems = []
        for each in error.errors(include_url=False):
            field = ".".join(map(str, each["loc"])) or "case"
            given = "" if isinstance(each["input"], dict) else f"{each['input']!r} given; "
            problems.append(f"{field}: {given}{each['msg']}")
        raise CatalogError(f"{name}: " + "; ".join(problems)) from error


def at_heights(pairs: Pairs, heights_m: Array) -> Array:
    """Return a profile at heights."""
    x, y = np.array(pairs, float).T
    values: Array = np.interp(heights_m, x, y)
    return values
