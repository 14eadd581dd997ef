#ifndef CLOCK_H
#define CLOCK_H
#include <stdint.h>

/* Bring the core to 168 MHz, and let the cycle counter run. */
void clock_start(void);

/* Of the core and of the bus that USART1 hangs on, Hz. */
extern uint32_t clock_core_hz, clock_usart_hz;

/* Counts core cycles downwards, 24 bits. */
uint32_t clock_count(void);

#endif
