"""Reading the answer to a request for a frame."""

import json

import numpy as np


def read_frame(content):
    """The steps, what is said of the frame (or what hinders it), and radiance (B, y, x) and brightness temperature."""
    stages = []
    while True:
        line, _, content = content.partition(b"\n")
        found = json.loads(line)
        if "stage" not in found:
            break
        stages.append(found["stage"])
    if "about" not in found:
        return stages, found, None, None
    about = found["about"]
    shape = len(about["bands"]), about["rows"], about["columns"]
    values = np.frombuffer(content, "<f4")
    assert values.nbytes == found["bytes"]
    size = int(np.prod(shape))
    return stages, about, values[:size].reshape(shape), values[size : 2 * size].reshape(shape)
