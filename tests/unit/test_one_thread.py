"""Products of matrices of the model `physical` in one thread, whatever the process has."""

import numpy  # noqa: F401  brings the library whose threads are counted
import pytest
from threadpoolctl import threadpool_info, threadpool_limits

from hcss_twin.radiance.physical.model import Physical
from hcss_twin.radiance.physical.one_thread import in_one_thread


def threads():
    return {library["num_threads"] for library in threadpool_info() if library["user_api"] == "blas"}


@in_one_thread
def counted(error=None):
    found = threads()
    if error is not None:
        raise error
    return found


def test_one_thread_inside_and_as_many_as_before_behind():
    with threadpool_limits(2, user_api="blas"):
        before = threads()
        assert counted() == {1}
        assert threads() == before
        with pytest.raises(KeyError):
            counted(KeyError("x"))
        assert threads() == before


def test_the_model_asks_for_it():
    assert Physical.clear.__wrapped__ is not Physical.clear
    assert Physical.cloudy.__wrapped__ is not Physical.cloudy
