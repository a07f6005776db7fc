"""Errors of data sets."""

from __future__ import annotations

from hcss_twin.providers import HcssError


class DatasetError(HcssError):
    """A data set cannot be made, written, read or scored."""
