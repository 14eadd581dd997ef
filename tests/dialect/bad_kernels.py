"""Kernels that break the dialect, each in one way, with who must find it and under which name of the rule.

Not imported: the gate's own tests run this file with a decorator of theirs in place of `kernel`.
"""

import math

import numpy as np

from firmware.numerics.dialect import kernel

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
TENTH = np.float32(0.1)
PLAIN_TENTH = 0.1
WIDE_TENTH = np.float64(0.1)
SIZE = 8
TABLE = np.zeros(4, np.float32)


# source: float literal; host: float64; target: float64
@kernel("float32(float32)")
def float_literal(x):
    return x * 0.1


# source: float literal
@kernel("float32(float32)")
def float_literal_wrapped_in_place(x):
    return x * np.float32(0.1)


# source: float64 constant; host: float64; target: float64
@kernel("float32(float32)")
def python_float_constant(x):
    return x * PLAIN_TENTH


# source: float64 constant; host: float64
@kernel("float32(float32)")
def float64_constant(x):
    return x * WIDE_TENTH


# host: float64; target: float64
@kernel("float32(float32, int32)")
def float32_times_int(x, n):
    return x * n


# host: float64; target: float64
@kernel("float32(int32, int32)")
def int_by_int(a, b):
    return np.float32(a / b)


# source: power; host: interpreted and compiled differ
@kernel("float32(float32)")
def power(x):
    return x**3


# source: unwrapped math; host: interpreted and compiled differ
@kernel("float32(float32, float32)")
def unwrapped_roots(a, b):
    return np.float32(math.sqrt(abs(a)) * math.sqrt(abs(b)))


# source: unwrapped math
@kernel("float32(float32, float32)")
def unwrapped_copysign(a, b):
    return math.copysign(a, b) * HALF


# host: interpreted and compiled differ
@kernel("int64(int32, int32)")
def int32_product(a, b):
    return np.int64(a * b)


# host: interpreted and compiled differ
@kernel("int64(int32, int32)")
def int32_sum(a, b):
    return np.int64(a + b)


# host: interpreted and compiled differ
@kernel("int32(int32)")
def int32_shift(a):
    return (a << np.int32(20)) >> np.int32(20)


# host: interpreted and compiled differ
@kernel("int64(uint8[::1])")
def narrow_byte_shift(p):
    return np.int64(p[0] << 8)


# source: C library; target: library call on the target
@kernel("float32(float32)")
def sine_of_the_platform(x):
    return np.float32(math.sin(x))


# source: C library; target: library call on the target
@kernel("float32(float32)")
def floor_of_the_platform(x):
    return np.float32(math.floor(x))


# source: call
@kernel("float32(float32)")
def rounded(x):
    return np.float32(round(x))


# source: call; target: library call on the target
@kernel("int64(float32)")
def python_int(x):
    return int(x)


# source: % by a variable; target: library call on the target
@kernel("float32(float32)")
def float_remainder(x):
    return x % TENTH


# source: // by a variable; target: library call on the target
@kernel("int64(int64, int64)")
def divided_by_variable(a, b):
    return a // b


# source: % by a variable; target: library call on the target
@kernel("int64(int64, int64)")
def remainder_by_variable(a, b):
    a %= b
    return a


# target: library call on the target
@kernel("int64(int64)")
def loop_that_subtracts(a):
    while a >= 9_000_000:
        a -= 9_000_000
    return a


# target: library call on the target
@kernel("int64(int64)")
def int64_by_constant(a):
    return a // 10


# target: library call on the target
@kernel("int64(float32)")
def float_to_int64(x):
    return np.int64(min(max(x, -HALF), HALF))


# target: library call on the target
@kernel("float32(int64)")
def int64_to_float(a):
    return np.float32(a)


# source: NumPy function; target: library call on the target
@kernel("float32(float32)")
def allocation(x):
    p = np.zeros(3, np.float32)
    p[0] = x
    return p[0]


# source: NumPy function
@kernel("float32(float32[::1], float32[::1])")
def dot_product(a, b):
    return np.dot(a, b)


# source: matrix product
@kernel("float32(float32[::1], float32[::1])")
def matrix_product(a, b):
    return a @ b


# source: call; target: library call on the target
@kernel("void(float32)")
def printing(x):
    print(x)


# source: call; target: does not compile for bare pointers
@kernel("int64(float32[::1])")
def length(p):
    return len(p)


# source: two-dimensional index; host: does not compile
@kernel("float32(float32[::1])")
def two_dimensions(p):
    return p[1, 2]


# source: slice; target: does not compile for bare pointers
@kernel("void(float32[::1])")
def sliced(p):
    p[0:3] = ZERO


# source: list; target: library call on the target
@kernel("int64(int64)")
def listed(n):
    values = [n, n]
    return values[0]


# source: dict
@kernel("int64(int64)")
def dictionary(n):
    values = {0: n}
    return values[0]


# source: text
@kernel("boolean(int64)")
def text(n):
    name = "navigating"
    return n == 3 and name != ""


# source: global container
@kernel("float32(int64)")
def global_table(n):
    return TABLE[n & 3]


# source: exception
@kernel("float32(float32)")
def raises(x):
    if x < ZERO:
        raise ValueError
    return x


# source: exception
@kernel("float32(float32)")
def catches(x):
    try:
        y = x
    except ValueError:
        y = ZERO
    return y


# source: inner function
@kernel("float32(float32)")
def inner_function(x):
    halve = lambda y: y * HALF  # noqa: E731
    return halve(x)


# source: recursion
@kernel("int64(int64)")
def recursion(n):
    return np.int64(0) if n <= 0 else recursion(n - 1)


# source: recursion
@kernel("int64(int64)")
def even(n):
    return np.int64(1) if n == 0 else odd(n - 1)


# source: recursion
@kernel("int64(int64)")
def odd(n):
    return np.int64(0) if n == 0 else even(n - 1)


# source: 64-bit loop; target: 64-bit loop
@kernel("void(float32[::1])")
def wide_loop(p):
    for i in range(8):
        p[i] = ZERO


# source: 64-bit loop; target: 64-bit loop
@kernel("void(float32[::1])")
def wide_loop_of_constant(p):
    for i in range(SIZE):
        p[i] = ZERO


# source: 64-bit loop; target: 64-bit loop
@kernel("void(float32[::1], int32)")
def wide_loop_of_a_sum(p, n):
    for i in range(n + n):
        p[i & 7] = ZERO


# target: 64-bit loop
@kernel("void(float32[::1], int64)")
def wide_loop_of_variable(p, n):
    m = n & 7
    for i in range(m):
        p[i] = ZERO


def plain(x):
    return x


# source: call of a plain function; host: does not compile
@kernel("float32(float32)")
def calls_plain_function(x):
    return plain(x)


# source: negative index; host: index outside the array
@kernel("float32(float32[::1])")
def negative_literal_index(p):
    return p[-1]


# host: index outside the array
@kernel("void(float32[::1])")
def negative_index(p):
    i = np.int32(0)
    p[i - 1] = ZERO


# host: index outside the array
@kernel("float32(float32[::1], int64)")
def far_outside(p, n):
    return p[(n & 7) + 1_000_000_000]


# host: interpreted run failed
@kernel("int32(float32)")
def undefined_cast(x):
    return np.int32(x)


# host: interpreted run failed
@kernel("float32(float32)")
def root_of_negative(x):
    return np.float32(math.sqrt(x))


# host: interpreted run failed
@kernel("int64(int64)")
def endless(n):
    while n != 1:
        n = n & 2
    return n


# host: float in fixed point; target: float in fixed point
@kernel("int64(int64)")
def in_fixed_point_halved(x):
    return np.int64(np.int32(np.float32(np.int32(x & 0xFFFF)) * HALF))


# host: float in fixed point; target: float in fixed point
@kernel("void(int32[::1], float32[::1])")
def in_fixed_point_moved(out, values):
    if values[0] > ZERO:
        out[0] = np.int32(1)


# target: no signature
@kernel
def never_called(x):
    return x


# source: parameters
@kernel
def default_argument(x, y=ZERO):
    return x + y


# source: keyword argument
@kernel("float32(float32)")
def keyword_argument(x):
    return default_argument(x, y=x)
