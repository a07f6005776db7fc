"""Errors of this package, besides those of hcss_twin."""

from hcss_twin.core.errors import OptionError
from hcss_twin.providers import HcssError, ImageError


class ImageOptionError(OptionError, ImageError):
    """An option of image evaluation is not allowed."""


class PosteriorError(HcssError):
    """A posterior cannot be sampled, written or read."""


class PosteriorOptionError(OptionError, PosteriorError):
    """An option of a fit is not allowed."""
