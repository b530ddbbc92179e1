"""NumPy arrays as arguments of C functions."""

from __future__ import annotations

from typing import Any

import numpy
from numpy.typing import ArrayLike, NDArray

from ._library import ffi

Array = NDArray[Any]
_C_TYPES = {  # by dtype: looking up its name costs more than a short call
    numpy.dtype(name): ffi.typeof(c_type)
    for name, c_type in {
        "float64": "double[]",
        "float32": "float[]",
        "int8": "int8_t[]",
        "uint8": "uint8_t[]",
        "bool": "uint8_t[]",
        "int16": "int16_t[]",
        "uint16": "uint16_t[]",
        "int32": "int32_t[]",
        "uint32": "uint32_t[]",
        "int64": "int64_t[]",
        "uint64": "uint64_t[]",
    }.items()
}


def pointer(array: Array | None) -> Any:
    """The memory of `array` as a C pointer of its element type; None gives NULL.

    Nothing is copied: what the library writes stands in the array. The array must
    be C-contiguous and of a type that C knows, or TypeError is raised; use
    numpy.ascontiguousarray(x, dtype=float) for what comes from elsewhere.

    >>> angles, moments = numpy.array([0.0, 0.5]), numpy.empty(2)
    >>> talus.pointer(angles)[1]
    0.5
    """
    if array is None:
        return ffi.NULL
    if not isinstance(array, numpy.ndarray) or not array.flags.c_contiguous:
        raise TypeError("a C-contiguous numpy array is wanted")
    c_type = _C_TYPES.get(array.dtype)  # another byte order is another dtype
    if c_type is None:
        raise TypeError(f"no C type for elements of {array.dtype}")
    return ffi.from_buffer(c_type, array)


def joint_arrays(joints: int, **arrays: ArrayLike | None) -> list[Any]:
    """The arrays as C-contiguous doubles of one shape, (joints, n); (n,) will do where there is one joint. None stays
    None. ValueError names the array whose shape or values are wrong."""
    out: list[Any] = []
    shape: tuple[int, ...] | None = None
    for name, values in arrays.items():
        if values is None:
            out.append(None)
            continue
        array = numpy.ascontiguousarray(values, dtype=float)
        if array.ndim != 2 and (array.ndim != 1 or joints != 1) or array.ndim == 2 and array.shape[0] != joints:
            raise ValueError(f"{name}: expected shape ({joints}, n), found {array.shape}")
        shape = shape or array.shape
        if array.shape != shape:
            raise ValueError(f"{name}: expected shape {shape} as {next(iter(arrays))}, found {array.shape}")
        if not numpy.isfinite(array).all():
            raise ValueError(f"{name}: expected finite numbers, found NaN or infinity")
        out.append(array)
    return out


def vector(name: str, values: ArrayLike, length: int) -> Array:
    """`values` as C-contiguous finite doubles of shape (length,); ValueError names what is wrong."""
    array = numpy.ascontiguousarray(values, dtype=float)
    if array.shape != (length,):
        raise ValueError(f"{name}: expected shape ({length},), found {array.shape}")
    if not numpy.isfinite(array).all():
        raise ValueError(f"{name}: expected finite numbers, found NaN or infinity")
    return array


def same(one: Any, other: Any) -> bool:
    """Are two results of one type equal field by field? Arrays by their values, where NaN is like NaN."""
    if type(one) is not type(other):
        return False
    if isinstance(one, numpy.ndarray):
        return bool(one.dtype == other.dtype and numpy.array_equal(one, other, equal_nan=one.dtype.kind == "f"))
    if isinstance(one, dict):
        return list(one) == list(other) and all(same(value, other[key]) for key, value in one.items())
    return bool(one == other)
