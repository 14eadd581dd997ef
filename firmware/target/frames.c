/* A zero ends a frame and stands nowhere else: after lost or false bytes the next zero is a new beginning. */
#include "frames.h"
#include "serial.h"

enum { FULL = 0xFF, FIRST = 0x100 }; /* codes without a zero behind them */

/* CRC-32 as in IEEE 802.3, four bits at a time. */
static uint32_t crc_add(uint32_t crc, uint8_t byte)
{
    static const uint32_t table[16] = {
        0x00000000, 0x1DB71064, 0x3B6E20C8, 0x26D930AC, 0x76DC4190, 0x6B6B51F4, 0x4DB26158, 0x5005713C,
        0xEDB88320, 0xF00F9344, 0xD6D6A3E8, 0xCB61B38C, 0x9B64C2B0, 0x86D3D2D4, 0xA00AE278, 0xBDBDF21C,
    };
    crc ^= byte;
    crc = crc >> 4 ^ table[crc & 15];
    return crc >> 4 ^ table[crc & 15];
}

uint8_t frame[FRAME_LIMIT] __attribute__((aligned(8)));

static uint32_t length, left, code = FIRST;
static int whole = 1;

static void take_decoded(uint8_t byte)
{
    if (length < FRAME_LIMIT)
        frame[length++] = byte;
    else
        whole = 0;
}

static int32_t end_frame(void)
{
    uint32_t crc = 0xFFFFFFFFu, size = length;
    int sound = whole && left == 0 && size >= FRAME_HEAD + FRAME_TAIL;
    length = left = 0;
    code = FIRST;
    whole = 1;
    if (!sound)
        return FRAME_DAMAGED;
    for (uint32_t n = 0; n < size; n++)
        crc = crc_add(crc, frame[n]);
    return crc == 0xDEBB20E3u ? (int32_t)size - FRAME_TAIL : FRAME_DAMAGED; /* the residue of a whole frame */
}

int32_t frame_take(uint8_t byte)
{
    if (byte == 0)
        return code == FIRST ? FRAME_UNFINISHED : end_frame(); /* FIRST: nothing stood between two ends */
    if (left == 0) {
        if (code < FULL)
            take_decoded(0);
        code = byte;
        left = byte - 1u;
    } else {
        take_decoded(byte);
        left--;
    }
    return FRAME_UNFINISHED;
}

/* One COBS block: up to 254 bytes without a zero, kept until its length is known. */
static uint8_t block[254];
static uint32_t held;

static void end_block(void)
{
    serial_write((uint8_t)(held + 1));
    for (uint32_t n = 0; n < held; n++)
        serial_write(block[n]);
    held = 0;
}

static void put(uint8_t byte)
{
    if (byte == 0) {
        end_block();
        return;
    }
    block[held++] = byte;
    if (held == sizeof block)
        end_block();
}

void frame_write(const uint8_t *bytes, uint32_t size)
{
    uint32_t crc = 0xFFFFFFFFu;
    held = 0;
    for (uint32_t n = 0; n < size; n++) {
        crc = crc_add(crc, bytes[n]);
        put(bytes[n]);
    }
    crc = ~crc;
    for (int n = 0; n < FRAME_TAIL; n++, crc >>= 8)
        put((uint8_t)crc);
    end_block();
    serial_write(0);
}
