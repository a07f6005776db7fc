"""Cubes of strangers: a cube is written again with a change to a name, a type, a dimension, a value or an attribute.

Each change is determined by its seed. A bad one contradicts the format of cubes, or may do so; a good one leaves a cube
that every function must read.
"""

import random

import netCDF4
import numpy as np


def read_all(path):
    """Return dimensions, variables (type, dimensions, values, attributes) and global attributes."""
    with netCDF4.Dataset(path) as file:
        file.set_auto_maskandscale(False)
        variables = {
            name: [each.dtype, each.dimensions, each[...], {key: each.getncattr(key) for key in each.ncattrs()}]
            for name, each in file.variables.items()
        }
        return (
            {name: each.size for name, each in file.dimensions.items()},
            variables,
            {key: file.getncattr(key) for key in file.ncattrs()},
        )


def write_all(path, dimensions, variables, attributes, **options):
    """Write what :func:`read_all` returned."""
    path.unlink()
    with netCDF4.Dataset(path, "w", **options) as file:
        for name, size in dimensions.items():
            file.createDimension(name, size)
        for name, (kind, dims, values, given) in variables.items():
            given = dict(given)
            fill = given.pop("_FillValue", None if kind is str else False)
            variable = file.createVariable(name, kind, dims, fill_value=fill)
            variable.set_auto_maskandscale(False)
            variable.setncatts(given)
            if kind is str or np.dtype(kind) != np.dtype("S1"):
                variable[...] = values
        file.setncatts(attributes)


def _resized(path, dimensions, variables, draw, size):
    """Give a dimension another size in all variables that have it."""
    chosen = draw.choice(sorted(dimensions))
    dimensions[chosen] = size
    for each in variables.values():
        for axis, name in enumerate(each[1]):
            if name == chosen:
                each[2] = np.take(each[2], range(size), axis=axis, mode="wrap") if each[2].shape[axis] else each[2]


NUMBERS = [np.nan, np.inf, -np.inf, 0.0, -1.0, 1e30, -1e30]
WORDS = ["", "x", "{}", "[]", '{"a": 1}', "null", np.float64("nan"), np.int32(-1), np.arange(3.0), "\x00", "9" * 99]


def bad(path, seed):
    """Change a cube in place; return what was done."""
    draw = random.Random(f"bad {seed}")
    dimensions, variables, attributes = read_all(path)
    name = draw.choice(sorted(variables))
    chosen = variables[name]
    kind = draw.randrange(9)
    if kind == 0:
        del variables[name]
    elif kind == 1:
        variables[draw.choice(["other", name.upper(), "x2"])] = variables.pop(name)
    elif kind == 2 and np.size(chosen[2]):
        chosen[0], chosen[3] = str, {key: value for key, value in chosen[3].items() if key == "long_name"}
        chosen[2] = np.full(np.shape(chosen[2]), draw.choice(["", "a", "1.5", "nan"]), dtype=object)
    elif kind == 3 and chosen[0] is not str:
        chosen[0] = draw.choice(["i1", "u2", "i8", "f8"])
        chosen[3].pop("_FillValue", None)
        with np.errstate(invalid="ignore"):
            chosen[2] = np.nan_to_num(
                np.asarray(chosen[2]).view(np.float32) if chosen[2].dtype.kind == "S" else chosen[2]
            )
            chosen[2] = chosen[2].astype(chosen[0])
    elif kind == 4:
        _resized(path, dimensions, variables, draw, draw.choice([0, 1, 1, 3]))
    elif kind == 5 and chosen[1]:
        axis = draw.randrange(len(chosen[1]))
        chosen[2] = np.take(chosen[2], 0, axis=axis) if chosen[2].shape[axis] else chosen[2]
        chosen[1] = chosen[1][:axis] + chosen[1][axis + 1 :]
        chosen[2] = np.asarray(chosen[2], dtype=object if chosen[0] is str else None)
    elif kind == 6 and chosen[0] is not str and np.dtype(chosen[0]).kind in "fiu" and np.size(chosen[2]):
        values = np.array(chosen[2])
        at = slice(None) if draw.random() < 0.5 else draw.randrange(values.size)
        number = draw.choice(NUMBERS)
        with np.errstate(invalid="ignore", over="ignore"):
            values.reshape(-1)[at] = number if values.dtype.kind == "f" else np.sign(np.nan_to_num(number)) * 100
        chosen[2] = values
    else:
        owner = draw.choice([attributes, chosen[3]])
        key = draw.choice(sorted(owner) or ["units"])
        if key == "_FillValue":
            owner.pop(key)
        elif draw.random() < 0.3:
            owner.pop(key, None)
        else:
            owner[key] = draw.choice(WORDS)
    write_all(path, dimensions, variables, attributes)
    return kind, name


UNNEEDED = ("cloud_mask", "cloud_optical_thickness", "cloud_thickness", "brightness_temperature")


def good(path, seed):
    """Change a cube in place so that it stays one; return what was done."""
    draw = random.Random(f"good {seed}")
    dimensions, variables, attributes = read_all(path)
    options = {}
    for kind in draw.sample(range(8), draw.randrange(1, 4)):
        if kind == 0:
            attributes[draw.choice(["note", "my_number", "history_of_mine"])] = draw.choice(["text", np.int32(4), 1.5])
        elif kind == 1:
            variables["extra"] = ["f4", (), np.float32(3.0), {"long_name": "of a stranger"}]
        elif kind == 2:
            dimensions["station"] = 4
            variables["station"] = ["i4", ("station",), np.arange(4), {}]
        elif kind == 3:
            variables.pop(draw.choice(UNNEEDED), None)
        elif kind == 4:
            dimensions = dict(reversed(dimensions.items()))
        elif kind == 5:
            variables = dict(draw.sample(sorted(variables.items()), len(variables)))
        elif kind == 6:
            variables["radiance"][0] = "f8"
        else:
            attributes["title"] = draw.choice(["", "Wolken über See", "a" * 2000])
    write_all(path, dimensions, variables, attributes, **options)
    return "good", None
