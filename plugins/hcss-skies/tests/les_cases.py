"""Small cases of the large-eddy model with known laws."""

from hcss_skies.les.case import case_of

DRY = {
    "title": "dry air", "source": "a test", "precision": "double",
    "grid": {"columns": [16, 16], "side_m": 100.0, "top_m": 2000.0, "spacing_m": 50.0, "sponge_bottom_m": 1600.0},
    "air": {"surface_pressure_Pa": 1e5, "theta_l_K": [[0, 300.0], [2000, 306.0]], "water_g_kg": [[0, 0.0]]},
    "surface": {"heat_K_m_s": 0.0, "water_g_kg_m_s": 0.0, "friction_velocity_m_s": 0.0},
    "output": {"hours": 0.1},
}  # fmt: skip


def case(base=DRY, **sections):
    """A case with changed fields of sections."""
    table = {name: dict(value) if isinstance(value, dict) else value for name, value in base.items()}
    for name, value in sections.items():
        table[name] = {**table.get(name, {}), **value} if isinstance(value, dict) else value
    return case_of(table, "test")


CLOUDY = {
    **DRY,
    "title": "moist air with cloud, wind, subsidence, sea, rain and droplets that settle",
    "grid": {**DRY["grid"], "spacing_m": [[0, 30.0], [700, 30.0], [2000, 90.0]]},
    "air": {
        "surface_pressure_Pa": 101500.0,
        "theta_l_K": [[0, 298.0], [900, 298.0], [2000, 304.0]],
        "water_g_kg": [[0, 16.5], [900, 16.0], [1300, 5.0], [2000, 0.02]],
        "u_m_s": [[0, -5.0], [2000, 3.0]],
        "v_m_s": [[0, 2.0]],
        "frame_m_s": [-2.0, 1.0],
        "noise_K": 0.5,
    },
    "forcing": {
        "coriolis_s": 1e-4, "geostrophic_u_m_s": [[0, -5.0], [2000, 3.0]], "subsidence_m_s": [[0, 0.0], [2000, -0.01]],
        "theta_l_K_day": [[0, -2.0], [2000, 0.0]], "water_g_kg_day": [[0, -1.0], [500, 0.0]],
    },
    "surface": {"sea_K": 300.0, "heat_coefficient": 0.0011, "water_coefficient": 0.0012, "drag": 0.0012},
    "radiation": {
        "f_0_W_m2": 70.0, "f_1_W_m2": 22.0, "kappa_m2_kg": 85.0, "divergence_s": 3.75e-6, "density_kg_m3": 1.1,
        "inversion_water_g_kg": 8.0,
    },
    "rain": {"droplets_cm3": 40.0},
    "settling": {"droplets_cm3": 40.0},
}  # fmt: skip
