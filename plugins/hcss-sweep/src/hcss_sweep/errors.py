"""Errors of a sweep."""

from hcss_twin.providers import HcssError


class SweepError(HcssError):
    """A sweep cannot be written or computed."""
