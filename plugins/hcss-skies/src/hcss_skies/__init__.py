"""Skies that imitate images, for hcss_twin; this module holds the hook and imports nothing else."""

from hcss_twin.providers import ProviderSpec, hookimpl


@hookimpl
def hcss_register_cloud_generators() -> list[ProviderSpec]:
    """Register the generators `example`, `simulation`, `volume`, `surrogate` and `fall-streaks`."""
    return [
        ProviderSpec(
            "example",
            "hcss_skies.generator:ExampleClouds",
            "hcss_skies.parameters:ExampleParameters",
            3,
            "skies that look like an example: blended patches that move, turn and change as measured",
        ),
        ProviderSpec(
            "simulation",
            "hcss_skies.simulation:SimulatedClouds",
            "hcss_skies.parameters:SimulationParameters",
            3,
            "clouds of films from large-eddy simulation, patched together without end, at their own pace",
        ),
        ProviderSpec(
            "volume",
            "hcss_skies.volume_clouds:VolumeClouds",
            "hcss_skies.parameters:VolumeParameters",
            3,
            "clouds of one instant of a large-eddy simulation in cells, for light that sees their sides",
        ),
        ProviderSpec(
            "surrogate",
            "hcss_skies.surrogate.generator:SurrogateClouds",
            "hcss_skies.surrogate.parameters:SurrogateParameters",
            3,
            "evolving cloud fields with the amplitudes and the spectrum of an image",
            (
                "T. Schreiber and A. Schmitz, Improved Surrogate Data for Nonlinearity Tests, Phys. Rev. Lett. 77, 635 "
                "(1996)",
            ),
        ),
        ProviderSpec(
            "fall-streaks",
            "hcss_skies.fall_streaks.generator:FallStreaks",
            "hcss_skies.fall_streaks.parameters:FallStreakParameters",
            3,
            "cirrus: ice that falls from generating cells through a sheared wind",
            (
                "R. J. Hogan and S. F. Kew, A 3D stochastic cloud model for investigating the radiative properties of "
                "inhomogeneous cirrus clouds, Q. J. R. Meteorol. Soc. 131, 2585 (2005)",
            ),
        ),
    ]
