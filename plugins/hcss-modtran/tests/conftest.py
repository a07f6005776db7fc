"""Computed results are kept apart from the user's cache."""

from hcss_twin.testing.own_cache import own_cache  # noqa: F401
