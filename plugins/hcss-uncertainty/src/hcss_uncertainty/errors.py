"""Errors of a propagation."""

from hcss_twin.core.errors import OptionError
from hcss_twin.providers import HcssError


class PropagationError(HcssError):
    """Uncertainty cannot be propagated as requested, or its file cannot be written or read."""


class PropagationOptionError(OptionError, PropagationError):
    """An option of propagation is not allowed."""
