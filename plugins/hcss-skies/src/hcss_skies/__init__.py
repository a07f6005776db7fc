"""Skies blended from examples, for hcss_twin; this module holds the hook and imports nothing else."""

from hcss_twin.providers import ProviderSpec, hookimpl


@hookimpl
def hcss_register_cloud_generators() -> list[ProviderSpec]:
    """Register the generator `example`."""
    return [
        ProviderSpec(
            "example",
            "hcss_skies.generator:ExampleClouds",
            "hcss_skies.parameters:ExampleParameters",
            3,
            "skies that look like an example: blended patches that move, turn and change as measured",
        )
    ]
