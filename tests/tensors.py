"""A stand-in for tensors of PyTorch, which is too large to be installed for tests: it refuses what they refuse."""

from __future__ import annotations

from typing import Any

import numpy as np


class Tensor:
    """Numbers that NumPy takes only from the CPU and without a gradient, in the words of PyTorch."""

    def __init__(
        self,
        values: Any,
        *,
        requires_grad: bool = False,
        device: str = "cpu",
        negative: bool = False,
        half: bool = False,
    ) -> None:
        """A negative one is a view of the numbers' opposites; a half one has them as bfloat16, float32 cut short."""
        self._values, self.requires_grad, self.device = np.asarray(values), requires_grad, device
        self._negative, self._half = negative, half

    def _with(self, **changed: Any) -> Tensor:
        kept = {"requires_grad": self.requires_grad, "device": self.device}
        kept |= {"negative": self._negative, "half": self._half}
        return Tensor(changed.pop("values", self._values), **{**kept, **changed})

    def detach(self) -> Tensor:
        return self._with(requires_grad=False)

    def resolve_conj(self) -> Tensor:
        return self

    def resolve_neg(self) -> Tensor:
        return self._with(values=-self._values, negative=False) if self._negative else self

    def cpu(self) -> Tensor:
        return self._with(device="cpu")

    def float(self) -> Tensor:
        bits = np.asarray(self._values, dtype=np.float32).view(np.uint32)
        kept = (bits & 0xFFFF0000).view(np.float32) if self._half else self._values.astype(np.float32)
        return self._with(values=kept, half=False)

    def numpy(self) -> np.ndarray:
        if self.device != "cpu":
            raise TypeError(f"can't convert {self.device} device type tensor to numpy. Use Tensor.cpu() first")
        if self.requires_grad:
            raise RuntimeError("Can't call numpy() on Tensor that requires grad. Use tensor.detach().numpy() instead.")
        if self._negative:
            raise RuntimeError("Can't call numpy() on Tensor that has negative bit set.")
        if self._half:
            raise TypeError("Got unsupported ScalarType BFloat16")
        return self._values

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> np.ndarray:
        return self.numpy() if dtype is None else self.numpy().astype(dtype)

    def __len__(self) -> int:
        return len(self._values)

    def __getitem__(self, key: Any) -> Tensor:
        return self._with(values=self._values[key])

    @property
    def shape(self) -> tuple[int, ...]:
        return self._values.shape
