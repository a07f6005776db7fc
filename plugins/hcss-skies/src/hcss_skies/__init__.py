"""Skies that imitate images, for hcss_twin; this module holds the hook and imports nothing else."""

from hcss_twin.providers import ProviderSpec, hookimpl


@hookimpl
def hcss_register_cloud_generators() -> list[ProviderSpec]:
    """Register the generators `example` and `surrogate`."""
    return [
        ProviderSpec(
            "example",
            "hcss_skies.generator:ExampleClouds",
            "hcss_skies.parameters:ExampleParameters",
            3,
            "skies that look like an example: blended patches that move, turn and change as measured",
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
    ]
