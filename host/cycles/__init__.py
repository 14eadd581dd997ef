"""How many cycles a kernel takes on the attitude computer's processor, a C28x with single-precision FPU.

Nobody emulates its instructions here. A kernel is compiled to LLVM's intermediate code, without vectors;
every block of that code counts how often it runs on real data; and each of its instructions has a price in
cycles (`host.cycles.prices`). The sum is an estimate: see docs/uav_ahrs.md.
"""
