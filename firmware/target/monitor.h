#ifndef MONITOR_H
#define MONITOR_H
#include <stdint.h>

/* A request of `length` bytes, which lies in `frame`: work it off and answer. Returns 0 when it is none: the
 * first one must be HELLO. */
int monitor_take(uint32_t length);

/* A request came damaged: say so. */
void monitor_refuse_damaged(void);

#endif
