#ifndef SERIAL_H
#define SERIAL_H
#include <stdint.h>

enum { SERIAL_RING = 2048 }; /* bytes that may come while the processor is busy */

/* USART1 on PA9 (out) and PA10 (in), 8N1. */
void serial_start(uint32_t usart_hz, uint32_t baud);

/* Sleeps until there is a byte. */
uint8_t serial_read(void);
void serial_write(uint8_t byte);

/* The interrupt of USART1. */
void serial_interrupt(void);

#endif
