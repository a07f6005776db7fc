"""Computed results are kept apart from the user's cache, and no test uses what another one kept in its place."""

from hcss_author.own_cache import fresh_results, own_cache  # noqa: F401
