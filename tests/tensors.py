"""A stand-in for tensors of PyTorch, which is too large to be installed for tests: it refuses what they refuse."""

from __future__ import annotations

from typing import Any

import numpy as np


class Tensor:
    """Numbers that NumPy takes only from the CPU and without a gradient, in the words of PyTorch."""

    def __init__(self, values: Any, *, requires_grad: bool = False, device: str = "cpu") -> None:
        self._values, self.requires_grad, self.device = np.asarray(values), requires_grad, device

    def detach(self) -> Tensor:
        return Tensor(self._values, device=self.device)

    def cpu(self) -> Tensor:
        return Tensor(self._values, requires_grad=self.requires_grad)

    def numpy(self) -> np.ndarray:
        if self.device != "cpu":
            raise TypeError(f"can't convert {self.device} device type tensor to numpy. Use Tensor.cpu() first")
        if self.requires_grad:
            raise RuntimeError("Can't call numpy() on Tensor that requires grad. Use tensor.detach().numpy() instead.")
        return self._values

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> np.ndarray:
        return self.numpy() if dtype is None else self.numpy().astype(dtype)

    def __len__(self) -> int:
        return len(self._values)

    def __getitem__(self, key: Any) -> Tensor:
        return Tensor(self._values[key], requires_grad=self.requires_grad, device=self.device)

    @property
    def shape(self) -> tuple[int, ...]:
        return self._values.shape
