#ifndef SERIAL_H
#define SERIAL_H
#include <stdint.h>

/* USART1 on PA9 (out) and PA10 (in), 8N1. */
void serial_start(uint32_t usart_hz, uint32_t baud);
uint8_t serial_read(void);
void serial_write(uint8_t byte);

#endif
