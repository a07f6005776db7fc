"""Exceptions, at the import path of the provider API; defined in :mod:`hcss_twin.core.errors`."""

from hcss_twin.core.errors import *  # noqa: F403
