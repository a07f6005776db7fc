"""The state of a simulation and its time step.

du/dt = -div(rho U u) / rho - grad phi + b z + f (v - v_g) + drag, and so for v, w, theta_l, q_t and q_r, with three
stages of Runge and Kutta (L. J. Wicker and W. C. Skamarock, Mon. Weather Rev. 130, 2088 (2002), eq. 3): q1 = q + dt/3
R(q), q2 = q + dt/2 R(q1), q(t + dt) = q + dt R(q2). Each stage ends with the pressure's projection.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from hcss_skies.les import advection, forcings, surface
from hcss_skies.les.case import Case, Pairs, at_heights
from hcss_skies.les.grid import Mesh, stretched_faces
from hcss_skies.les.pressure import PressureSolver
from hcss_skies.les.radiation import radiative_heating
from hcss_skies.les.rain import fall_and_change, settle, settling_coefficient
from hcss_skies.les.thermodynamics import (
    EPSILON,
    GRAVITY,
    P_0,
    R_DRY,
    G,
    ReferenceState,
    add_buoyancy,
    saturation_adjustment,
)
from hcss_twin.providers import Array, HcssError

DAY_S = 86400.0

Field = np.ndarray[Any, Any]
"""A field in the precision of the case."""


@dataclass
class Budget:
    """What a step changed, and what its sources explain; both per area of the box.

    Attributes
    ----------
    water_kg_m2, expected_water_kg_m2 : float
        Change of vapour, cloud and rain.
    heat_K_kg_m2, expected_heat_K_kg_m2 : float
        Change of the integral of rho theta_l.
    column_water_kg_m2 : float
        All water.
    """

    water_kg_m2: float
    expected_water_kg_m2: float
    heat_K_kg_m2: float
    expected_heat_K_kg_m2: float
    column_water_kg_m2: float

    @property
    def water_error(self) -> float:
        """Water that no source explains, as a part of all water."""
        return (self.water_kg_m2 - self.expected_water_kg_m2) / max(self.column_water_kg_m2, 1e-12)


class Model:
    """A box of moist air over the sea.

    Parameters
    ----------
    case : Case
        Air, sea and forcings.

    Attributes
    ----------
    mesh : Mesh
        Cells.
    reference : ReferenceState
        Air at rest.
    u, v, w : ndarray
        Velocities in the moving frame, m/s.
    theta_l : ndarray
        Liquid-water potential temperature less ``reference.theta_0_K``.
    water, rain : ndarray
        q_t and q_r, g/kg; ``rain`` has no columns in cases without.
    liquid, theta_v : ndarray
        Cloud water (g/kg), and virtual potential temperature less ``reference.theta_0_K``, of the present state.
    time_s : float
        Since the start.
    step_s : float
        The last step.
    steps : int
        Number of steps.
    rain_on_sea_kg_m2 : float
        Since the start.
    budget : Budget
        Of the last step.
    """

    def __init__(self, case: Case) -> None:
        self.case = case
        faces = stretched_faces(case.grid.top_m, case.grid.spacing_m)
        self.mesh = mesh = Mesh(case.grid.columns, case.grid.side_m, faces, case.grid.floor_m)
        air, z = case.air, mesh.centres_m
        theta = at_heights(air.theta_l_K, z)
        if air.cube_root_above_m is not None:
            theta = theta + np.cbrt(np.maximum(z - air.cube_root_above_m, 0.0))
        water = at_heights(air.water_g_kg, z)
        self.reference = ReferenceState.of_profiles(
            mesh, theta, water, air.surface_pressure_Pa, air.heat_capacity_J_kg_K, air.latent_heat_J_kg
        )
        self.dtype = np.dtype(np.float64 if case.precision == "double" else np.float32)
        self._prepare()
        self._start(theta, water)
        self.time_s, self.step_s, self.steps, self.rain_on_sea_kg_m2 = 0.0, 0.0, 0, 0.0
        self.budget = Budget(0.0, 0.0, 0.0, 0.0, 0.0)
        self.diagnose()

    def _prepare(self) -> None:
        """Compute all that stays the same."""
        mesh, reference, case, kind = self.mesh, self.reference, self.case, self.dtype
        z, dz, faces = mesh.centres_m, mesh.depth_m, mesh.faces_m
        rho, rho_faces = reference.density, reference.density_at_faces
        self.pressure = PressureSolver(mesh, rho_faces, rho)
        self.mass = rho * dz
        self._weno = advection.constants(kind)
        self._density = rho_faces.astype(kind)
        self._per_mass = (1.0 / self.mass).astype(kind)
        self._per_side = kind.type(1.0 / mesh.side_m)
        around = np.concatenate([[0.5 * dz[0]], 0.5 * (dz[1:] + dz[:-1]), [0.5 * dz[-1]]]) * rho_faces
        self._per_mass_w = (1.0 / around).astype(kind)
        below, above = np.zeros(mesh.levels + 1), np.zeros(mesh.levels + 1)
        below[1:], above[:-1] = 0.5 * self.mass, 0.5 * self.mass
        self._below, self._above = (below / around).astype(kind), (above / around).astype(kind)
        # linear interpolation of buoyancy from two levels to the face between
        weight_below, weight_above = np.zeros(mesh.levels), np.zeros(mesh.levels)
        weight_below[:-1], weight_above[1:] = dz[1:] / (dz[1:] + dz[:-1]), dz[:-1] / (dz[1:] + dz[:-1])
        self._per_theta = (GRAVITY / reference.theta_v_K * np.stack([weight_below, weight_above])).astype(kind)
        sponge = (case.grid.sponge_bottom_m, case.grid.top_m, case.grid.sponge_rate_s)
        self._sponge = forcings.sponge_rate(z, *sponge)
        self._sponge_w = forcings.sponge_rate(faces, *sponge).astype(kind)
        forcing, frame = case.forcing, case.air.frame_m_s
        self._set_air_around(z, acts=True)
        self._away = tuple(
            (at_heights(pairs, z) - speed).astype(kind)
            for pairs, speed in zip((forcing.geostrophic_u_m_s, forcing.geostrophic_v_m_s), frame, strict=True)
        )
        self._into_air = float(rho_faces[0] / self.mass[0])
        self._per_depth = 1.0 / dz
        self._sea()

    def _set_air_around(self, z: Array, acts: bool) -> None:
        """Take subsidence and tendencies at heights of the case (nz,), or none."""
        forcing, nothing = self.case.forcing, np.zeros(self.mesh.levels)

        def at(pairs: Pairs) -> Array:
            return at_heights(pairs, z) if acts else nothing

        self._subsidence = forcings.subsidence_weights(self.mesh, at(forcing.subsidence_m_s))
        self._air_around = self._subsidence.astype(self.dtype.type), self._sponge.astype(self.dtype.type)
        self._sources = {
            "theta_l": at(forcing.theta_l_K_day) / DAY_S, "water": at(forcing.water_g_kg_day) / DAY_S,
            "u": nothing, "v": nothing, "rain": nothing,
        }  # fmt: skip

    def _follow(self, water: Array) -> None:
        """Move subsidence and tendencies with the inversion of the mean water (nz,): stretched below, shifted above."""
        z, forcing = self.mesh.centres_m, self.case.forcing
        if forcing.inversion_water_g_kg is not None:
            first, now = (forcings.falls_through(z, q, forcing.inversion_water_g_kg)
                          for q in (at_heights(self.case.air.water_g_kg, z), water))  # fmt: skip
            z = np.where(z < now, z * (first / now), z + (first - now))
        self._set_air_around(z, self.time_s >= 3600.0 * forcing.begin_hours)

    def _sea(self) -> None:
        """Kinematic fluxes, and values at the sea for bulk fluxes."""
        sea, rho = self.case.surface, float(self.reference.density_at_faces[0])
        exner = (self.case.air.surface_pressure_Pa / P_0) ** (R_DRY / self.reference.cp_J_kg_K)
        self._fluxes: dict[str, float] = {}
        self._bulk: dict[str, tuple[float, float]] = {}
        if sea.sensible_W_m2 is not None:
            self._fluxes["theta_l"] = sea.sensible_W_m2 / (rho * self.reference.cp_J_kg_K * exner)
        elif sea.heat_K_m_s is not None:
            self._fluxes["theta_l"] = sea.heat_K_m_s
        elif sea.heat_coefficient is not None and sea.sea_K is not None:
            self._bulk["theta_l"] = sea.heat_coefficient, sea.sea_K / exner - self.reference.theta_0_K
        if sea.latent_W_m2 is not None:
            self._fluxes["water"] = sea.latent_W_m2 / (rho * self.reference.latent_J_kg) / G
        elif sea.water_g_kg_m_s is not None:
            self._fluxes["water"] = sea.water_g_kg_m_s
        elif sea.water_coefficient is not None and sea.sea_K is not None:
            vapour = 611.2 * math.exp(17.67 * (sea.sea_K - 273.15) / (sea.sea_K - 29.65))  # Bolton 1980, eq. 10
            wet = 1e3 * EPSILON * vapour / (self.case.air.surface_pressure_Pa - (1.0 - EPSILON) * vapour)
            self._bulk["water"] = sea.water_coefficient, wet

    def _start(self, theta: Array, water: Array) -> None:
        """Fill the fields: profiles, and noise below a height."""
        mesh, air, reference = self.mesh, self.case.air, self.reference
        z, frame = mesh.centres_m, air.frame_m_s
        rng = np.random.default_rng(self.case.seed)
        noisy = z < air.noise_below_m
        fields: dict[str, Array] = {
            "u": np.broadcast_to(at_heights(air.u_m_s, z) - frame[0], mesh.shape),
            "v": np.broadcast_to(at_heights(air.v_m_s, z) - frame[1], mesh.shape),
            "w": np.zeros((*mesh.columns, mesh.levels + 1)),
            "theta_l": theta - reference.theta_0_K + air.noise_K * noisy * rng.uniform(-1.0, 1.0, mesh.shape),
            "water": water + np.minimum(air.noise_g_kg, water) * noisy * rng.uniform(-1.0, 1.0, mesh.shape),
        }
        rains = mesh.shape if self.case.rain else (0, 0, mesh.levels)
        fields["rain"] = np.zeros(rains)
        self._fields = {name: np.ascontiguousarray(field, self.dtype) for name, field in fields.items()}
        self._old = {name: field.copy() for name, field in self._fields.items()}
        self._rates = {name: np.zeros_like(field) for name, field in self._fields.items()}
        self.liquid, self.theta_v = (np.zeros(mesh.shape, self.dtype) for _ in range(2))
        self._mean_theta_v = np.zeros(mesh.levels)
        self._heating = np.zeros(mesh.shape if self.case.radiation else (0, 0, mesh.levels), self.dtype)
        self._mean_heating = np.zeros(mesh.levels)

    @property
    def fields(self) -> Mapping[str, Field]:
        """Prognostic fields by name: u, v, w, theta_l, water, rain."""
        return self._fields

    @property
    def u(self) -> Field:
        """Velocity along x in the moving frame."""
        return self._fields["u"]

    @property
    def v(self) -> Field:
        """Velocity along y in the moving frame."""
        return self._fields["v"]

    @property
    def w(self) -> Field:
        """Vertical velocity."""
        return self._fields["w"]

    @property
    def theta_l(self) -> Field:
        """Liquid-water potential temperature less the reference."""
        return self._fields["theta_l"]

    @property
    def water(self) -> Field:
        """Vapour and cloud water, g/kg."""
        return self._fields["water"]

    @property
    def rain(self) -> Field:
        """Rain water, g/kg."""
        return self._fields["rain"]

    def set_state(self, fields: Mapping[str, Field], time_s: float, step_s: float, steps: int, rain: float) -> None:
        """Go on from a state of an earlier run of the same case."""
        for name, field in fields.items():
            self._fields[name][...] = field
        self.time_s, self.step_s, self.steps, self.rain_on_sea_kg_m2 = time_s, step_s, steps, rain
        self.diagnose()

    def diagnose(self) -> None:
        """Set cloud water and buoyancy of the present state."""
        reference = self.reference
        saturation_adjustment(
            self.theta_l, self.water, self.rain, reference.theta_0_K, reference.warming, reference.pressure_Pa,
            reference.exner, self.liquid, self.theta_v, self._mean_theta_v,
        )  # fmt: skip

    def longest_step(self) -> float:
        """Return the step (s) that the winds allow.

        Raises
        ------
        HcssError
            If a velocity is not finite; with its name and place.
        """
        rate = advection.courant(self.u, self.v, self.w, 1.0 / self.mesh.side_m, self._per_depth)
        if not math.isfinite(rate):
            self._not_finite()
        longest = min(self.case.longest_step_s, self.case.courant / max(rate, 1e-9))
        longest = float(min(longest, 1.2 * self.step_s if self.step_s else 1.0))
        if longest < 1e-3:
            raise HcssError(
                f"{self.case.title}: the winds at {self.time_s:.0f} s allow steps of {longest:.2g} s; allowed: 0.001 s "
                f"and more; the fastest is {max(float(np.abs(f).max()) for f in (self.u, self.v, self.w)):.3g} m/s"
            )
        return longest

    def _not_finite(self) -> None:
        for name, field in self._fields.items():
            wrong = np.argwhere(~np.isfinite(field))
            if len(wrong):
                i, j, k = map(int, wrong[0])
                raise HcssError(
                    f"{self.case.title}: {name} is {field[i, j, k]} at {self.time_s:.0f} s in cell ({i}, {j}, {k}), "
                    f"{self.mesh.faces_m[k]:.0f} m; allowed: finite. A smaller courant or longest_step_s may help"
                )

    def run_until(self, time_s: float) -> None:
        """Take steps until a time."""
        while self.time_s < time_s - 1e-6:
            remaining = time_s - self.time_s
            self.advance(remaining / math.ceil(remaining / self.longest_step() - 1e-9))
        self.time_s = time_s

    def advance(self, seconds: float) -> None:
        """Take one step."""
        before = self._content()
        means = {name: self._mean(name) for name in self._scalars_and_winds()}
        if self.case.forcing.varies:
            self._follow(means["water"])
        for name, field in self._fields.items():
            self._old[name], self._fields[name] = field, self._old[name]
            self._fields[name][...] = field
        self._radiate()
        expected = (0.0, 0.0)
        for part in (3, 2, 1):
            expected = self._add_rates(means, last=part == 1)
            for name, field in self._fields.items():
                advection.step(field, self._old[name], self._rates[name], self.dtype.type(seconds / part))
            self.pressure.project(self.u, self.v, self.w)
            self.diagnose()
        fallen, warmed = self._rain(seconds) if self.case.rain else (0.0, 0.0)
        if self.case.settling:
            settled, by_settling = self._settle(seconds)
            fallen, warmed = fallen + settled, warmed + by_settling
        self.rain_on_sea_kg_m2 += fallen
        self._require_water()
        after = self._content()
        self.budget = Budget(
            after[0] - before[0],
            seconds * expected[0] - fallen,
            after[1] - before[1],
            seconds * expected[1] + warmed,
            after[0],
        )
        self.time_s += seconds
        self.step_s = seconds
        self.steps += 1

    def _scalars_and_winds(self) -> list[str]:
        return ["u", "v", "theta_l", "water", *(["rain"] if self.case.rain else [])]

    def _mean(self, name: str) -> Array:
        mean: Array = self._fields[name].mean(axis=(0, 1), dtype=np.float64)
        return mean

    def _content(self) -> tuple[float, float]:
        """Return the integrals of water (kg m-2) and of theta_l (K kg m-2) over a column of the mean."""
        water = self._mean("water") + (self._mean("rain") if self.case.rain else 0.0)
        return float(G * (self.mass @ water)), float(self.mass @ self._mean("theta_l"))

    def _radiate(self) -> None:
        law = self.case.radiation
        if law is not None:
            reference = self.reference
            radiative_heating(
                self.liquid, self.water, self.mesh.faces_m, reference.density, reference.exner, reference.cp_J_kg_K,
                (law.f_0_W_m2, law.f_1_W_m2, law.kappa_m2_kg, law.a_z, law.divergence_s, law.density_kg_m3,
                 law.inversion_water_g_kg), self._heating, self._mean_heating,
            )  # fmt: skip

    def _rain(self, seconds: float) -> tuple[float, float]:
        assert self.case.rain is not None
        reference, heating = self.reference, np.empty(self.mesh.levels)
        fallen = fall_and_change(
            self.theta_l, self.water, self.rain, self.liquid, reference.theta_0_K, reference.warming,
            reference.pressure_Pa, reference.exner, reference.density, self.mesh.depth_m,
            self.case.rain.droplets_cm3, seconds, heating,
        )  # fmt: skip
        self.diagnose()
        return fallen, float(self.mass @ heating)

    def _settle(self, seconds: float) -> tuple[float, float]:
        assert self.case.settling is not None
        reference, heating = self.reference, np.empty(self.mesh.levels)
        coefficient = settling_coefficient(self.case.settling.droplets_cm3, self.case.settling.sigma)
        fallen = settle(
            self.theta_l, self.water, self.liquid, reference.warming, reference.exner, reference.density,
            self.mesh.depth_m, coefficient, seconds, heating,
        )  # fmt: skip
        self.diagnose()
        return fallen, float(self.mass @ heating)

    def _require_water(self) -> None:
        """Fill what the advection left below 0 from the rest of the column."""
        if self.water.min() < 0.0:
            columns = np.where((self.water < 0.0).any(axis=2))
            full = self.water[columns].astype(np.float64)
            positive = np.maximum(full, 0.0)
            self.water[columns] = positive * ((full @ self.mass) / (positive @ self.mass))[:, None]
            self.diagnose()

    def _add_rates(self, means: dict[str, Array], last: bool) -> tuple[float, float]:
        """Add all tendencies; of the last stage return those of water (kg m-2 s-1) and heat that sources explain."""
        kind, rates, fields = self.dtype.type, self._rates, self._fields
        winds = self.u, self.v, self.w
        flow = self._density, self._per_mass, self._per_side
        for name in self._scalars_and_winds():
            shift = int(name == "u"), int(name == "v")
            advection.advect(fields[name], *winds, *shift, *flow, rates[name], self._weno)
            forcings.add_large_scale(
                fields[name], means[name].astype(kind), self._sources[name].astype(kind), *self._air_around, rates[name]
            )
        around = self._below, self._above, self._density, self._per_mass_w, self._per_side
        advection.advect_w(self.w, self.u, self.v, *around, rates["w"], self._weno)
        forcings.damp(self.w, self._sponge_w, rates["w"])
        add_buoyancy(self.theta_v, self._mean_theta_v.astype(kind), self._per_theta, rates["w"])
        forcing = self.case.forcing
        if forcing.coriolis_s:
            rotation = kind(forcing.coriolis_s)
            forcings.add_rotation(self.u, self.v, rotation, *self._away, kind(0.25), rates["u"], rates["v"])
        sea, frame = self.case.surface, self.case.air.frame_m_s
        surface.add_stress(
            self.u, self.v, frame, (sea.friction_velocity_m_s or 0.0) ** 2, sea.drag or 0.0, self._into_air,
            rates["u"], rates["v"],
        )  # fmt: skip
        fluxes = dict(self._fluxes)
        for name, flux in self._fluxes.items():
            rates[name][:, :, 0] += kind(flux * self._into_air)
        for name, (coefficient, at_sea) in self._bulk.items():
            fluxes[name] = surface.add_bulk_flux(
                fields[name], self.u, self.v, frame, coefficient, at_sea, self._into_air, rates[name]
            )
        if self.case.radiation:
            rates["theta_l"] += self._heating
        if not last:
            return 0.0, 0.0
        expected = {}
        for name in self._scalars_and_winds():
            mean = self._mean(name)
            expected[name] = self.mass @ (
                self._sources[name]
                + forcings.subsidence_of_profile(mean, self._subsidence)
                - self._sponge * (mean - means[name])
            ) + self.mass[0] * self._into_air * fluxes.get(name, 0.0)
        heat = expected["theta_l"] + self.mass @ self._mean_heating
        return float(G * (expected["water"] + expected.get("rain", 0.0))), float(heat)
