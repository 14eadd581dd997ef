"""Navigation: alignment, strapdown, error-state filter, GNSS and vehicle aiding, health; kernels on two
arrays.

Doors: `configure` (config), `imu_step` (imu), `gnss_step` (gnss), and what `solution` fills.
"""
