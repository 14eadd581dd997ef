/* Frames of the monitor: COBS( type u8, sequence u8, payload, CRC-32 ) 0x00, little endian. */
#ifndef FRAMES_H
#define FRAMES_H
#include <stdint.h>

enum { FRAME_LIMIT = 8192, FRAME_HEAD = 2, FRAME_TAIL = 4 };
enum { FRAME_UNFINISHED = -1, FRAME_DAMAGED = 0 };

/* What has been received of a frame lies here. */
extern uint8_t frame[FRAME_LIMIT];

/* The next byte of the line. At the end of a frame its length without CRC, or FRAME_DAMAGED. */
int32_t frame_take(uint8_t byte);

/* Send `length` bytes that begin with type and sequence. */
void frame_write(const uint8_t *bytes, uint32_t length);

#endif
