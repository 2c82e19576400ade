"""The images of a plan as functions of JAX arrays, with derivatives; needs JAX."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from emitree._factors import Table

if TYPE_CHECKING:
    from emitree._plan import Plan


def apply(plan: Plan, rates: Any) -> Any:
    """`Plan.apply` for a JAX array (n,) or (n, k), traced or not.

    It consists of operations of `jax.numpy`, which JAX differentiates, vectorizes and compiles. The
    precision is that of the rates, at least 32 bits.
    """
    import jax
    import jax.numpy as jnp

    if jnp.issubdtype(rates.dtype, jnp.complexfloating):
        raise TypeError(f"the rates are of type {rates.dtype}: expected real numbers")
    plan.check_count(rates.shape)
    floating = jnp.issubdtype(rates.dtype, jnp.floating)
    dtype = jnp.promote_types(rates.dtype, jnp.float32) if floating else jnp.result_type(float)
    gathered, responses, seen = _constants(plan, rates, dtype)
    values = rates.astype(dtype)
    sums = _times(gathered, values.T if values.ndim == 2 else values)
    if isinstance(responses, tuple):
        image = _times(responses, sums)
    else:
        # Devices for machine learning have a faster product with fewer digits.
        image = jnp.matmul(sums, responses.T, precision=jax.lax.Precision.HIGHEST)
    return jnp.where(seen, image.reshape(*image.shape[:-1], *plan.shape), jnp.nan)


def _times(table: Any, values: Any) -> Any:
    """The product of a table with the last axis of an array."""
    columns, weights = table
    return (values[..., columns] * weights).sum(axis=-1)


def _constants(plan: Plan, rates: Any, dtype: Any) -> Any:
    """The factors of a plan as arrays on the device of the rates; each is copied there once."""
    import jax
    import jax.numpy as jnp

    device = None
    if not isinstance(rates, jax.core.Tracer) and len(rates.devices()) == 1:
        (device,) = rates.devices()
    key = ("jax", str(dtype), device)
    if key not in plan.constants:

        def there(array: Any) -> Any:
            return jnp.asarray(array) if device is None else jax.device_put(array, device)

        def of_type(array: Any) -> Any:
            return there(np.asarray(array, dtype=dtype))

        factors = plan.factors
        # Within a transformation these are arrays nonetheless.
        with jax.ensure_compile_time_eval():
            tables = [
                (there(part.columns), of_type(part.weights))
                if isinstance(part, Table)
                else of_type(part)
                for part in (factors.gathered, factors.responses)
            ]
            plan.constants[key] = (*tables, there(plan.seen))
    return plan.constants[key]
