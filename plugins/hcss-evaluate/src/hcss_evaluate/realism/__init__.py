"""The realism test: can a classifier tell simulated from measured images, and by what."""

from hcss_evaluate.realism.score import Realism, compare

__all__ = ["Realism", "compare"]
