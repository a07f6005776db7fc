"""Errors of a sweep."""

from hcss_twin.core.errors import HcssError


class SweepError(HcssError):
    """A sweep cannot be written or computed."""
