/* Requests of the host, one frame each, one answer each. The answer to a request that comes twice is sent
 * twice; the work is done once. All numbers little endian.
 *
 *   1 HELLO                                 version u8, kernels u8, frame limit u16, memory u32, core clock u32,
 *                                           identity of the image (16)
 *   2 WRITE    offset u32, bytes            nothing
 *   3 READ     offset u32, length u16       bytes
 *   4 ARRAY    handle u8, is float u8,      nothing
 *              offset u32, size u32
 *   5 CALLS    number u16, calls            number done u16, for each: digest u64, cycles u32
 *   6 RESULTS                               status and results of the last call, u64 each
 *
 * A call: kernel u8, patches u8; its arguments (u8 handle of an array, or the scalar); the patches (handle u8,
 * offset u16, length u16, bytes), written before; the digest u64 that the host expects. The digest is over the
 * kernel's number, all its arrays, the status and the results. Calls end behind the first unexpected digest.
 *
 * The answer has the request's type + 0x80 and its sequence number; 0xFF: reason u8 (1 damaged, 2 refused).
 */
#include "monitor.h"
#include "arrays.h"
#include "clock.h"
#include "frames.h"
#include "kernels.h"
#include <string.h>

enum { HELLO = 1, WRITE, READ, ARRAY, CALLS, RESULTS, ANSWER = 0x80, REFUSAL = 0xFF };
enum { VERSION = 1, DAMAGED = 1, REFUSED = 2, ANSWER_LIMIT = 4096, CALL_ANSWER = 12 };

static uint8_t answer[ANSWER_LIMIT + FRAME_HEAD] __attribute__((aligned(8)));
static uint32_t answer_length;
static uint64_t results[RESULT_LIMIT];
static uint8_t result_count;

/* What is left of a request; `bad` once something was asked that it does not hold. */
static const uint8_t *at, *end;
static int bad;

static uint64_t take(uint32_t size)
{
    uint64_t value = 0;
    if (size > (uint32_t)(end - at)) {
        bad = 1;
        return 0;
    }
    memcpy(&value, at, size);
    at += size;
    return value;
}

static void give(uint64_t value, uint32_t size)
{
    memcpy(answer + answer_length, &value, size);
    answer_length += size;
}

static void write_memory(uint32_t offset, uint32_t length)
{
    if (length > (uint32_t)(end - at) || !memory_holds(offset, length)) {
        bad = 1;
        return;
    }
    memcpy(memory + offset, at, length);
    at += length;
}

static void hello(void)
{
    give(VERSION, 1);
    give(kernel_count, 1);
    give(FRAME_LIMIT, 2);
    give(MEMORY_SIZE, 4);
    give(clock_core_hz, 4);
    memcpy(answer + answer_length, image_identity, 16);
    answer_length += 16;
}

static void read_memory(void)
{
    uint32_t offset = (uint32_t)take(4), length = (uint32_t)take(2);
    if (bad || length > ANSWER_LIMIT || !memory_holds(offset, length)) {
        bad = 1;
        return;
    }
    memcpy(answer + answer_length, memory + offset, length);
    answer_length += length;
}

static void define_array(void)
{
    uint8_t handle = (uint8_t)take(1);
    struct array array = {.is_float = (uint8_t)take(1)};
    array.offset = (uint32_t)take(4);
    array.size = (uint32_t)take(4);
    if (bad || !array_define(handle, array))
        bad = 1;
}

static void take_patches(uint8_t number)
{
    while (number-- && !bad) {
        const struct array *array = array_of((uint8_t)take(1));
        uint32_t offset = (uint32_t)take(2), length = (uint32_t)take(2);
        if (offset + length > array->size)
            bad = 1;
        else
            write_memory(array->offset + offset, length);
    }
}

/* One call; 0 when its digest is not the expected one. */
static int call(void)
{
    uint8_t number = (uint8_t)take(1), patches = (uint8_t)take(1);
    uint64_t arguments[ARGUMENT_LIMIT];
    uint8_t handles[ARGUMENT_LIMIT];
    uint32_t n, arrays = 0;
    if (number >= kernel_count) {
        bad = 1;
        return 0;
    }
    const struct kernel *kernel = &kernels[number];
    for (n = 0; kernel->kinds[n]; n++) {
        if (kernel->kinds[n] == 'a') {
            handles[arrays] = (uint8_t)take(1);
            arguments[n] = (uint32_t)(memory + array_of(handles[arrays++])->offset);
        } else {
            arguments[n] = take((uint32_t)(kernel->kinds[n] - '0'));
        }
    }
    take_patches(patches);
    uint64_t expected = take(8), digest = number;
    if (bad)
        return 0;
    uint32_t before = clock_count();
    kernel->call(arguments, results);
    uint32_t cycles = (before - clock_count()) & 0xFFFFFFu;
    result_count = kernel->results;
    for (n = 0; n < arrays; n++)
        digest = digest_array(digest, array_of(handles[n]));
    for (n = 0; n < result_count; n++)
        digest = digest_add(digest_add(digest, (uint32_t)results[n]), (uint32_t)(results[n] >> 32));
    give(digest, 8);
    give(cycles, 4);
    return digest == expected;
}

static void calls(void)
{
    uint32_t wanted = (uint32_t)take(2), done = 0;
    uint32_t count_at = answer_length;
    answer_length += 2;
    if (wanted * CALL_ANSWER + 2 > ANSWER_LIMIT)
        bad = 1;
    while (!bad && done < wanted) {
        int as_expected = call();
        done += !bad;
        if (!as_expected)
            break;
    }
    memcpy(answer + count_at, &done, 2);
}

static void give_results(void)
{
    for (uint32_t n = 0; n < result_count; n++)
        give(results[n], 8);
}

static void serve(uint8_t type)
{
    switch (type) {
    case HELLO: hello(); break;
    case WRITE: { uint32_t offset = (uint32_t)take(4); write_memory(offset, (uint32_t)(end - at)); break; }
    case READ: read_memory(); break;
    case ARRAY: define_array(); break;
    case CALLS: calls(); break;
    case RESULTS: give_results(); break;
    default: bad = 1;
    }
}

static void refuse(uint8_t sequence, uint8_t reason)
{
    answer[0] = REFUSAL;
    answer[1] = sequence;
    answer[2] = reason;
    answer_length = 3;
}

static void answer_to(uint32_t length)
{
    answer[0] = frame[0] | ANSWER;
    answer[1] = frame[1];
    answer_length = FRAME_HEAD;
    at = frame + FRAME_HEAD;
    end = frame + length;
    bad = 0;
    serve(frame[0]);
    if (bad)
        refuse(frame[1], REFUSED);
}

int monitor_take(uint32_t length)
{
    static int sequence = -1;
    if (frame[0] != HELLO && sequence < 0)
        return 0;
    if (frame[0] == HELLO || frame[1] != sequence)
        answer_to(length);
    sequence = frame[1];
    frame_write(answer, answer_length);
    return 1;
}

void monitor_refuse_damaged(void)
{
    static const uint8_t damaged[] = {REFUSAL, 0, DAMAGED};
    frame_write(damaged, sizeof damaged); /* the last answer is kept: it may be asked for again */
}
