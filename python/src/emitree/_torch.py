"""The images of a plan as functions of PyTorch tensors, with derivatives; needs PyTorch."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from emitree._factors import Table

if TYPE_CHECKING:
    from emitree._plan import Plan


def apply(plan: Plan, rates: Any) -> Any:
    """`Plan.apply` for a tensor (n,) or (n, k), on its device.

    It consists of operations that PyTorch differentiates. The precision is that of the rates, at
    least 32 bits.
    """
    import torch

    if rates.is_complex():
        raise TypeError(f"the rates are of type {rates.dtype}: expected real numbers")
    plan.check_count(tuple(rates.shape))
    if rates.is_floating_point():
        dtype = torch.promote_types(rates.dtype, torch.float32)
    else:
        dtype = torch.get_default_dtype()
    gathered, responses, seen = _constants(plan, rates.device, dtype)
    values = rates.to(dtype)
    sums = _times(gathered, values.T if values.ndim == 2 else values)
    if isinstance(responses, tuple):
        image = _times(responses, sums)
    else:
        image = sums @ responses.T
    missing = torch.full((), float("nan"), dtype=dtype, device=rates.device)
    return torch.where(seen, image.reshape(*image.shape[:-1], *plan.shape), missing)


def _times(table: Any, values: Any) -> Any:
    """The product of a table with the last axis of a tensor."""
    columns, weights = table
    return (values[..., columns] * weights).sum(dim=-1)


def _constants(plan: Plan, device: Any, dtype: Any) -> Any:
    """The factors of a plan as tensors on a device; each is copied there once."""
    import torch

    key = ("torch", dtype, device)
    if key not in plan.constants:

        def there(array: Any) -> Any:
            return torch.as_tensor(array, device=device)

        def of_type(array: Any) -> Any:
            return torch.as_tensor(array, dtype=dtype, device=device)

        factors = plan.factors
        tables = [
            (there(part.columns.astype(np.int64)), of_type(part.weights))
            if isinstance(part, Table)
            else of_type(part)
            for part in (factors.gathered, factors.responses)
        ]
        plan.constants[key] = (*tables, there(plan.seen))
    return plan.constants[key]
