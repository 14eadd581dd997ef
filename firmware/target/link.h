/* Frames of the board's link (docs/link.md): A5 5A, type, length, sequence, payload, CRC-16. */
#ifndef LINK_H
#define LINK_H
#include <stdint.h>

enum { LINK_PAYLOAD_LIMIT = 255 };

struct link_frame {
    uint8_t kind, length, sequence, payload[LINK_PAYLOAD_LIMIT + 2];
};

/* The last one that was whole. */
extern struct link_frame link_frame;

/* The next byte of the line; whether it ends a whole frame. */
int link_take(uint8_t byte);

/* Send a frame, numbered behind the one before. */
void link_write(uint8_t kind, const uint8_t *payload, uint8_t length);

/* CRC-16/CCITT-FALSE over more bytes; it begins with 0xFFFF. */
uint16_t link_crc(uint16_t crc, const uint8_t *bytes, uint32_t size);

#endif
