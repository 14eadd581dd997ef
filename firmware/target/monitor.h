#ifndef MONITOR_H
#define MONITOR_H

/* Serves requests on the serial port for ever. */
__attribute__((noreturn)) void monitor_run(void);

#endif
