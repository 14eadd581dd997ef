import math
import sys

import numpy as np
import pytest

import firmware.numerics.trigonometry as trigonometry
from firmware.numerics import reference_trigonometry
from firmware.numerics.precision import load
from firmware.numerics.variants import KernelVariant


def test_float64_kernels_are_accurate_to_a_billionth():
    wide = load("firmware.numerics.quaternion", "float64")
    yaw, pitch, roll = 1.0, -0.4, 2.5
    got = wide.euler_of_quaternion(*wide.quaternion_of_euler(yaw, pitch, roll))
    assert got == pytest.approx((yaw, pitch, roll), abs=1e-14)
    for angle in (1e-3, 0.49, 0.51, 3.0):
        w, x, _, _ = wide.quaternion_of_rotation(angle, 0.0, 0.0)
        assert (w, x) == pytest.approx((math.cos(angle / 2), math.sin(angle / 2)), abs=1e-9)


def test_kernels_that_are_called_compute_in_float64_too():
    wide = load("firmware.numerics.fixed_position", "float64")
    assert wide.radians_of_units(3**25) == 3**25 * 2.0**-40
    assert load("firmware.numerics.fixed_position", "float32").radians_of_units(3**25) != 3**25 * 2.0**-40


def test_trigonometry_is_that_of_the_c_library():
    wide = load("firmware.numerics.trigonometry", "float64")
    assert wide.sine(1.0) == math.sin(1.0)
    assert wide.cosine(-2.0) == math.cos(-2.0)
    assert wide.arc_tangent2(1.0, -2.0) == math.atan2(1.0, -2.0)
    assert wide.arc_sine(0.3) == math.asin(0.3)
    assert wide.square_root(2.0) == math.sqrt(2.0)


def test_limits_are_those_of_the_original():
    wide = load("firmware.numerics.trigonometry", "float64")
    for module in (wide, trigonometry):
        assert math.isnan(module.sine(9000.0))
        assert math.isnan(module.square_root(-1.0))
        assert module.arc_sine(1.5) == pytest.approx(math.pi / 2)


def test_reference_has_every_function_of_the_original():
    def functions(module):
        return {
            name
            for name in vars(module)
            if not name.startswith("_") and hasattr(getattr(module, name), "py_func")
        }

    assert functions(reference_trigonometry) == functions(trigonometry)


def test_float32_is_the_ordinary_module():
    assert load("firmware.numerics.trigonometry", "float32") is trigonometry


def test_original_modules_are_left_alone():
    load("firmware.numerics.quaternion", "float64")
    assert sys.modules["firmware.numerics.trigonometry"].HALF.dtype == np.float32
    assert sys.modules["firmware_float64.numerics.quaternion"].HALF.dtype == np.float64


def test_unknown_precision_is_refused():
    with pytest.raises(ValueError, match="precision 'float16' is not known; one of float32, float64"):
        load("firmware.numerics.quaternion", "float16")


@pytest.mark.parametrize("module", ["host.sim", "numpy", "firmwares.nav"])
def test_only_firmware_has_variants(module):
    with pytest.raises(ValueError, match="only firmware modules"):
        load(module, "float64")


def test_unknown_module_is_an_import_error():
    with pytest.raises(ModuleNotFoundError):
        load("firmware.numerics.absent", "float64")


def test_variant_gets_every_kernel_with_its_signature():
    seen = {}

    def decorate(function, signature):
        seen[function.__name__] = signature and signature.text
        return function

    variant = KernelVariant("for_this_test", decorate)
    module = variant.load("firmware.numerics.fixed_position")
    assert module.wrap_longitude(5) == 5
    assert seen["wrap_longitude"] == "int64(int64)"
    assert seen["float32_of_int64"] == "float32(int64)", "kernels of imported modules too"
    with pytest.raises(ValueError, match="'for_this_test' exists already"):
        KernelVariant("for_this_test", decorate)
