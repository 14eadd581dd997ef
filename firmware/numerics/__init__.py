"""Float32 and fixed-point arithmetic in the kernel dialect: what the navigation loop computes with.

The rules stand in docs/kernel-dialect.md; `dialect` holds the decorator, the other modules hold kernels.
"""
