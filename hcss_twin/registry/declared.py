"""What declarations may name, at the import path that the provider API promises."""

from hcss_twin.providers.common import DEPENDENCIES, LEGS, MEASURED, RANGES

__all__ = ["DEPENDENCIES", "LEGS", "MEASURED", "RANGES"]
