"""Arrays in memory: computed once, the least recently used dropped first, too large ones not kept."""

import numpy as np

from hcss_twin.core.result_cache import ArrayMemory


def test_arrays_are_computed_once_until_others_need_their_place():
    computed, memory = [], ArrayMemory(limit_bytes=100)

    def ask(key, numbers):
        def compute():
            computed.append(key)
            return (np.zeros(numbers),)

        memory.get_or_compute(key, compute)

    for key, numbers in ((b"a", 5), (b"b", 5), (b"a", 5), (b"large", 13), (b"a", 5), (b"b", 5), (b"c", 5), (b"b", 5)):
        ask(key, numbers)
    assert computed == [b"a", b"b", b"large", b"c"]
    ask(b"a", 5)  # 40 bytes each: two fit
    assert computed[-1] == b"a"
