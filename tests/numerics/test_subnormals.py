import os
import platform
import subprocess
import sys
from pathlib import Path

import pytest

from firmware.numerics.subnormals import check_subnormals

REPOSITORY = Path(__file__).resolve().parents[2]

# MXCSR with flush-to-zero and denormals-are-zero set, all exceptions masked: what such a library does.
FLUSHING = """
import ctypes
import llvmlite.binding as llvm
llvm.initialize_native_target()
llvm.initialize_native_asmprinter()
module = llvm.parse_assembly('''
declare void @llvm.x86.sse.ldmxcsr(ptr)
@mode = global i32 40896
define void @flush() {
  call void @llvm.x86.sse.ldmxcsr(ptr @mode)
  ret void
}''')
engine = llvm.create_mcjit_compiler(module, llvm.Target.from_default_triple().create_target_machine())
engine.finalize_object()
flush = ctypes.CFUNCTYPE(None)(engine.get_function_address("flush"))
from firmware.numerics.subnormals import check_subnormals
check_subnormals()
print("before: fine")
flush()
check_subnormals()
"""


def test_subnormals_work_here():
    check_subnormals()


@pytest.mark.skipif(platform.machine() not in ("x86_64", "AMD64"), reason="sets a register of x86")
def test_flushing_to_zero_is_noticed():
    environment = dict(os.environ, PYTHONPATH=str(REPOSITORY))
    done = subprocess.run(
        [sys.executable, "-c", FLUSHING], env=environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 1
    assert "RuntimeError: this process flushes subnormal numbers to zero" in done.stderr
    assert done.stdout == "before: fine\n"
