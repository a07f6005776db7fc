"""Computed results are kept apart from the user's cache."""

from hcss_author.own_cache import own_cache  # noqa: F401
