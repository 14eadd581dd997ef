"""The programs of the dual_antenna board: `front_end` for its FPGA, `navigator` for its DSP."""
