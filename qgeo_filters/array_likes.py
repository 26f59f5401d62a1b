"""NumPy arrays of what other libraries call arrays: tensors of PyTorch and Open3D, vertices that were picked."""

from __future__ import annotations

from typing import Any

import numpy as np


def as_array(values: Any) -> np.ndarray:
    """NumPy array of anything array-like, on any device.

    Tensors of PyTorch may require a gradient and lie on a GPU, which `numpy.asarray` refuses; those of Open3D are no
    array-likes at all. They are known by their methods, so that neither library is imported. A list of such tensors,
    of single numbers say, is taken as one of arrays. Picked points of Open3D's windows are the vertices that they are.

    Raises
    ------
    TypeError, ValueError
        As `numpy.asarray`.
    """
    if isinstance(values, np.ndarray):
        return values
    if isinstance(values, (list, tuple)) and values and not isinstance(values[0], (int, float)):
        return np.asarray([_element(value) for value in values])
    return np.asarray(_on_this_side(values))


def vertex_number(value: Any) -> Any:
    """What a single vertex is called: the number of a picked point or of a tensor of one number, else as it is."""
    value = _element(value)
    return value.item() if isinstance(value, np.ndarray) and value.shape in ((), (1,)) else value


def is_tensor(value: Any) -> bool:
    """Whether it is a tensor of PyTorch or Open3D, or is as good as one."""
    return callable(getattr(value, "cpu", None)) and callable(getattr(value, "numpy", None))


def is_array_like(value: Any) -> bool:
    """Whether it is an array, a tensor, a list or a tuple, or becomes an array by itself, as a data frame does."""
    return isinstance(value, (list, tuple)) or is_array(value)


def is_array(value: Any) -> bool:
    """Whether it is an array of some library, or becomes one by itself; vectors of points of Open3D too."""
    if isinstance(value, np.ndarray) or is_tensor(value) or hasattr(value, "__array__"):
        return True
    try:
        return memoryview(value).ndim > 1
    except (TypeError, ValueError):  # meshes of VTK seem to have a buffer, and then have none
        return False


def _element(value: Any) -> Any:
    if type(value).__name__ == "PickedPoint":  # of open3d.visualization
        return value.index
    return as_array(value) if isinstance(value, (list, tuple)) else _on_this_side(value)


def _on_this_side(values: Any) -> Any:
    """The tensor as an array of NumPy, without its gradient and in this machine's memory; anything else as it is."""
    if not is_tensor(values):
        return values
    for name in ("detach", "resolve_conj", "resolve_neg"):  # of PyTorch: views that NumPy does not know, made real
        if callable(method := getattr(values, name, None)):
            values = method()
    try:
        here = values.cpu()
    except NotImplementedError as error:  # PyTorch's of the device "meta", whose tensors have a shape alone
        raise TypeError(str(error)) from error
    try:
        return here.numpy()
    except TypeError:
        if not callable(getattr(here, "float", None)):
            raise
        return here.float().numpy()  # of a kind that NumPy has not, bfloat16: float32 has each of its numbers
