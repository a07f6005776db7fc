"""Examples of providers for hcss_twin; this module holds the hooks and imports nothing else."""

from hcss_twin.providers import ProviderSpec, hookimpl


def _spec(name: str, target: str, summary: str) -> ProviderSpec:
    module = f"hcss_examples.{target.partition(':')[0]}"
    return ProviderSpec(name, f"hcss_examples.{target}", f"{module}:Parameters", 3, summary)


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


@hookimpl
def hcss_register_optics() -> list[ProviderSpec]:
    """Register the optics of cloud particles."""
    return [_spec("ash", "ash:Ash", "volcanic ash, spheres of one refractive index")]


@hookimpl
def hcss_register_sensors() -> list[ProviderSpec]:
    """Register the sensors."""
    return [_spec("rolling-shutter", "rolling_shutter:RollingShutter", "rows are read one after another")]


@hookimpl
def hcss_register_surfaces() -> list[ProviderSpec]:
    """Register the surfaces."""
    return [_spec("ice-map", "ice_map:IceMap", "sea ice with a map of its temperature")]


@hookimpl
def hcss_register_variables() -> list[ProviderSpec]:
    """Register the variables."""
    return [_spec("split-window", "split_window:SplitWindow", "difference of brightness temperatures of two bands")]
