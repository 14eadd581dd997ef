#include "link.h"
#include "serial.h"

enum { SYNC_1 = 0xA5, SYNC_2 = 0x5A, HEAD = 3, CRC = 2 };

struct link_frame link_frame;

static uint32_t held; /* bytes of a frame so far, with its sync */

uint16_t link_crc(uint16_t crc, const uint8_t *bytes, uint32_t size)
{
    while (size--) {
        uint8_t x = (uint8_t)(crc >> 8) ^ *bytes++;
        x ^= x >> 4;
        crc = (uint16_t)(crc << 8) ^ (uint16_t)(x << 12) ^ (uint16_t)(x << 5) ^ x;
    }
    return crc;
}

/* After a wrong check sum the search goes on behind the frame, unlike the PC's: what was lost is sent again. */
int link_take(uint8_t byte)
{
    uint8_t *bytes = &link_frame.kind;
    if (held < 2) {
        held = byte == (held ? SYNC_2 : SYNC_1) ? held + 1 : byte == SYNC_1;
        return 0;
    }
    bytes[held++ - 2] = byte;
    if (held < 2 + HEAD || held < 2u + HEAD + link_frame.length + CRC)
        return 0;
    held = 0;
    uint32_t sealed = HEAD + link_frame.length;
    uint16_t crc = link_crc(0xFFFF, bytes, sealed);
    return bytes[sealed] == (uint8_t)crc && bytes[sealed + 1] == crc >> 8;
}

void link_write(uint8_t kind, const uint8_t *payload, uint8_t length)
{
    static uint8_t sequence;
    uint8_t head[HEAD] = {kind, length, sequence++};
    uint16_t crc = link_crc(link_crc(0xFFFF, head, HEAD), payload, length);
    serial_write(SYNC_1);
    serial_write(SYNC_2);
    for (uint32_t n = 0; n < HEAD; n++)
        serial_write(head[n]);
    for (uint32_t n = 0; n < length; n++)
        serial_write(payload[n]);
    serial_write((uint8_t)crc);
    serial_write((uint8_t)(crc >> 8));
}
