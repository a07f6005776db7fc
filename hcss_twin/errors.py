"""Exceptions, at the import path that the provider API promises; defined in :mod:`hcss_twin.core.errors`."""

from hcss_twin.core.errors import *  # noqa: F403
