"""Examples of providers for hcss_twin; this module holds the hooks and imports nothing else."""

from hcss_twin.registry import ProviderSpec, hookimpl


def _spec(name: str, target: str, summary: str) -> ProviderSpec:
    module = f"hcss_examples.{target.partition(':')[0]}"
    return ProviderSpec(name, f"hcss_examples.{target}", f"{module}:Parameters", 2, summary)


@hookimpl
def hcss_register_cloud_generators() -> list[ProviderSpec]:
    """Register the cloud generators."""
    return [_spec("les", "les_clouds:LesClouds", "clouds of a large-eddy simulation in a NetCDF file")]


@hookimpl
def hcss_register_elements() -> list[ProviderSpec]:
    """Register the elements."""
    return [
        _spec("aircraft", "aircraft:Aircraft", "an aircraft smaller than a pixel, with a plume of hot gas"),
        _spec("ship", "ship:Ship", "a ship of several pixels, with exact coverage at its sides"),
    ]
