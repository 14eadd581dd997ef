"""The program of the uav_ahrs board (TMS320F28335): acquisition, attitude, output, background."""
