"""Skies that follow measured images, for hcss_twin; this module holds the hook and imports nothing else."""

from hcss_twin.providers import ProviderSpec, hookimpl


@hookimpl
def hcss_register_cloud_generators() -> list[ProviderSpec]:
    """Register the generator `followed`."""
    return [
        ProviderSpec(
            "followed",
            "hcss_follow.generator:FollowedClouds",
            "hcss_follow.parameters:FollowedParameters",
            3,
            "the sky of the latest measured image, moved on and changed as forecast from it",
            (
                "T. Kroeger, R. Timofte, D. Dai and L. Van Gool, Fast Optical Flow using Dense Inverse Search, "
                "ECCV (2016)",
            ),
        )
    ]
