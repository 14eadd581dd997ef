"""Which modules are translated to machine code, in groups that stand for themselves.

A group is translated together and taken together. Calls inside of it are direct; from one group to another,
and to what is interpreted, they are those of Python, so that every group works beside every other one as
machine code or as sources. What users may derive classes of says so (`hal.derivable`).
"""

GROUPS: dict[str, tuple[str, ...]] = {
    "emulation": (
        "hal.emulated.virtual_time",
        "hal.emulated.interrupt_line",
        "hal.emulated.cpu",
        "hal.emulated.pins",
        "hal.emulated.spi",
        "hal.emulated.timers",
        "hal.emulated.dual_port",
        "hal.emulated.packet_link",
        "hal.emulated.alarm",
        "hal.emulated.uart_receiver",
        "hal.emulated.uart_wire",
        "hal.emulated.uart",
        "hal.emulated.watchdog",
        "boards.chips.bmi160.core",
        "boards.chips.bmi160.bus_side",
        "boards.chips.bmi160.chip",
        "boards.chips.adxl345.fifo_lane",
        "boards.chips.adxl345.bus_side",
        "boards.chips.adxl345.chip",
        "boards.chips.equivalent_feed",
    ),
    "firmware": (
        "firmware.drivers.bmi160",
        "firmware.drivers.receiver_stream",
        "firmware.drivers.neo_m8n",
        "firmware.link.nmea_output",
        "firmware.link.frames",
        "firmware.link.solution_output",
        "firmware.apps.gnss_ins.output",
        "firmware.apps.gnss_ins.announcements",
        "firmware.apps.gnss_ins.receiver_port",
        "firmware.apps.gnss_ins.gnss_time",
        "firmware.apps.gnss_ins.pulse_watch",
        "firmware.apps.gnss_ins.navigation",
        "firmware.apps.car_mems.program",
        "firmware.apps.car_mems.acquisition",
        "firmware.apps.car_mems.background",
        "firmware.apps.car_mems.gnss_port",
        "firmware.apps.car_mems.clock_watch",
        "firmware.apps.gfsins.accelerometers",
        "firmware.apps.gfsins.acquisition",
        "firmware.apps.gfsins.reception",
        "firmware.apps.gfsins.equivalent_feed",
        "firmware.apps.gfsins.flight",
        "firmware.nav.gyro_free.packet_door",
    ),
}
"""Time, processor, wires and chips; what boards are programmed with."""
