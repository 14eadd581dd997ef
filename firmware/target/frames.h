/* Frames on the serial line: COBS( type u8, sequence u8, payload, CRC-32 ) 0x00, little endian. */
#ifndef FRAMES_H
#define FRAMES_H
#include <stdint.h>

enum { FRAME_LIMIT = 8192, FRAME_HEAD = 2, FRAME_TAIL = 4 };

/* Wait for the next frame; returns its length without CRC, 0 for one that is damaged or too long. */
uint32_t frame_read(uint8_t *frame);

/* Send `length` bytes that begin with type and sequence. */
void frame_write(const uint8_t *frame, uint32_t length);

#endif
