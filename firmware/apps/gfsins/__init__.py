"""The programs of the gfsins board: `acquisition` for its FPGA, `navigator` for its DSP."""
