"""Hook that registers the cloud generator with a shape in height; imports nothing else."""

from hcss_twin.providers import ProviderSpec, hookimpl


@hookimpl
def hcss_register_cloud_generators() -> list[ProviderSpec]:
    """Register the cloud generator ``fractal-relief``."""
    module, summary = "hcss_light.relief", "fractal clouds with tops, bases and edges of three-dimensional octaves"
    return [ProviderSpec("fractal-relief", f"{module}:ReliefClouds", f"{module}:ReliefParameters", 3, summary)]
