#ifndef LINE_H
#define LINE_H

/* Serves the serial line for ever: requests to the monitor, or the raw frames of a navigation loop. */
__attribute__((noreturn)) void line_serve(void);

#endif
