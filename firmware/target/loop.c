/* Inputs are taken in the order of their numbers; each is told again when it is taken, as a board with sensors of
 * its own tells it. What comes out of order is answered by WANTED, with the number that should come. */
#include "loop.h"
#include "arrays.h"
#include "kernels.h"
#include "link.h"
#include <string.h>

enum { SOLUTION = 0x01, START = 0x10, IMU, EPOCH, TEMPERATURE, CLOCK, STATE, WANTED };
enum { RAW_FORMAT = 1, START_LENGTH = 18, IMU_LENGTH = 27, EPOCH_HEAD = 16, BURST = 15 };
enum { SLICE_HEAD = 8, SLICE = 240, SAMPLES_A_SLICE = 10, SOLUTION_HEAD = 33, LARGEST_SOLUTION = 40 };
enum { MS_NS = 1000000, SECOND_NS = 1000000000, DAY_MS = 86400000 };

static uint32_t expected, copied_before;
static int started, has_asked;
static uint32_t steps, samples, slice, slices;
static uint32_t pulses;
static int64_t edge_ns;
static uint8_t burst[1 + BURST];
static float solution_floats[LARGEST_SOLUTION] __attribute__((aligned(8)));
static int64_t solution_integers[LARGEST_SOLUTION];

/* The state lies in the memory of the arrays: floats, integers, epoch, and a copy of all three. */
static uint32_t floats_size(void) { return 4u * loop.floats; }
static uint32_t integers_size(void) { return 8u * loop.integers; }
static uint32_t memory_size(void) { return floats_size() + integers_size() + 8u * loop.record; }
static uint8_t *integers(void) { return memory + ((floats_size() + 7u) & ~7u); }
static int64_t *epoch(void) { return (int64_t *)(integers() + integers_size()); }
static uint8_t *copy(void) { return (uint8_t *)(epoch() + loop.record); }

static int64_t floor_quotient(int64_t value, int64_t by)
{
    int64_t quotient = value / by;
    return quotient - (value % by < 0);
}

static int64_t floor_rest(int64_t value, int64_t by)
{
    int64_t rest = value % by;
    return rest < 0 ? rest + by : rest;
}

static uint64_t run(uint8_t number, uint64_t third, uint64_t fourth)
{
    uint64_t arguments[] = {(uintptr_t)memory, (uintptr_t)integers(), third, fourth};
    uint64_t results[RESULT_LIMIT];
    kernels[number].call(arguments, results);
    return results[kernels[number].results - 1];
}

/* --- inputs ----------------------------------------------------------------------------------- */

/* The configured values of the words [first, end), counted over floats and integers. */
static void configure(uint32_t first, uint32_t end)
{
    for (const struct loop_run *one = loop.runs; one < loop.runs + loop.run_count; one++)
        for (uint32_t n = 0; n < one->count; n++) {
            uint32_t word = one->word + n;
            uint8_t *at = word < loop.floats ? memory + 4 * word : integers() + 4 * (word - loop.floats);
            if (word >= first && word < end)
                memcpy(at, one->values + n, 4);
        }
}

static void start(const uint8_t *payload)
{
    uint32_t words = loop.floats + 2u * loop.integers;
    memset(memory, 0, memory_size() + 8);
    configure(0, words);
    uint16_t crc = link_crc(0xFFFF, memory, floats_size());
    crc = link_crc(crc, integers(), integers_size());
    uint8_t told[START_LENGTH] = {0, 0, 0, 0, RAW_FORMAT, loop.each_sample, 4, loop.steps};
    memcpy(told + 8, &loop.floats, 2);
    memcpy(told + 10, &loop.integers, 2);
    memcpy(told + 12, &crc, 2);
    memcpy(told + 14, payload + 14, 4);
    started = 1;
    has_asked = 0;
    expected = 1;
    steps = samples = slice = slices = pulses = 0;
    edge_ns = 0;
    link_write(START, told, sizeof told);
}

static int take_sample(const uint8_t *payload)
{
    int64_t read_at_ns;
    memcpy(&read_at_ns, payload + 4, 8);
    memcpy(burst + 1, payload + 12, BURST);
    uint64_t made = run(loop.sample, (uintptr_t)burst, (uint64_t)read_at_ns);
    steps += loop.each_sample || made;
    return steps == loop.steps;
}

/* Validity on the board's clock: by the time pulse, or by the nominal latency of the receiver. */
static int64_t validity(int64_t time_of_day_ms, int64_t burst_start_ns)
{
    if (!pulses || burst_start_ns - edge_ns > loop.longest_pulse_age_ns)
        return burst_start_ns - loop.nominal_latency_ns;
    int64_t since_second_ns = floor_rest(time_of_day_ms, 1000) * MS_NS;
    return burst_start_ns - floor_rest(burst_start_ns - edge_ns - since_second_ns, SECOND_NS);
}

static void take_epoch(const uint8_t *payload)
{
    int64_t *record = epoch();
    memcpy(&pulses, payload + 4, 4);
    memcpy(&edge_ns, payload + 8, 8);
    memset(record, 0, 8u * loop.record);
    memcpy(record, payload + EPOCH_HEAD, 8u * loop.told);
    record[loop.valid] = validity(record[loop.time_of_day], record[loop.burst_start]);
    run(loop.epoch, (uintptr_t)record, 0);
}

static void take_temperature(const uint8_t *payload)
{
    double celsius;
    memcpy(&celsius, payload + 4, 8);
    run(loop.temperature, slot_of_float((float)celsius), 0);
}

/* --- outputs ---------------------------------------------------------------------------------- */

static void put(uint8_t **at, uint64_t value, uint32_t size)
{
    memcpy(*at, &value, size);
    *at += size;
}

static void tell_solution(void)
{
    const int64_t *values = solution_integers, *record = epoch(); /* time, latitude, longitude, mode, flags */
    uint8_t payload[SOLUTION_HEAD + 4 + 4 * LARGEST_SOLUTION], *at = payload;
    int64_t time_of_day = 0xFFFFFFFF, date = 0xFFFF;
    run(loop.solution, (uintptr_t)solution_floats, (uintptr_t)solution_integers);
    if (record[loop.flags] & loop.has_time) {
        time_of_day = record[loop.time_of_day] + floor_quotient(values[0] - record[loop.valid], MS_NS);
        date = record[loop.date] + floor_quotient(time_of_day, DAY_MS);
        time_of_day = floor_rest(time_of_day, DAY_MS);
    }
    put(&at, values[0] > 0 ? (uint64_t)values[0] / 1000 : 0, 8);
    put(&at, (uint64_t)time_of_day, 4);
    put(&at, (uint64_t)date, 2);
    put(&at, (uint64_t)values[3], 1);
    put(&at, (uint64_t)values[4], 2);
    put(&at, (uint64_t)values[1], 8);
    put(&at, (uint64_t)values[2], 8);
    memcpy(at, solution_floats, 4u * loop.solution_floats);
    link_write(SOLUTION, payload, (uint8_t)(at - payload + 4u * loop.solution_floats));
}

/* The next part of a copy of the memory, which is made when the last one has gone. */
static void tell_slice(void)
{
    uint32_t size = memory_size();
    if (slice == slices) {
        memcpy(copy(), memory, floats_size());
        memcpy(copy() + floats_size(), integers(), size - floats_size());
        copied_before = expected;
        slice = 0;
        slices = (size + SLICE - 1) / SLICE;
    }
    uint32_t begin = slice * SLICE, count = size - begin < SLICE ? size - begin : SLICE;
    uint8_t payload[SLICE_HEAD + SLICE], *at = payload;
    put(&at, copied_before, 4);
    put(&at, slice++, 2);
    put(&at, slices, 2);
    memcpy(at, copy() + begin, count);
    link_write(STATE, payload, (uint8_t)(SLICE_HEAD + count));
}

static void ask(uint32_t number)
{
    uint8_t wanted[4];
    if (number == expected || (number > expected && has_asked))
        return; /* one question for one gap */
    has_asked = number > expected;
    memcpy(wanted, &expected, 4);
    link_write(WANTED, wanted, sizeof wanted);
}

/* --- the door --------------------------------------------------------------------------------- */

static int is_input(uint8_t kind, uint32_t length)
{
    switch (kind) {
    case START: return length == START_LENGTH;
    case IMU: return length == IMU_LENGTH;
    case EPOCH: return length == EPOCH_HEAD + 8u * loop.told;
    case TEMPERATURE: return length == 12;
    case CLOCK: return length == 4;
    default: return 0;
    }
}

int loop_take(uint8_t kind, const uint8_t *payload, uint32_t length)
{
    uint32_t number;
    if (loop.floats == 0 || !is_input(kind, length))
        return 0;
    if (kind == START) {
        start(payload);
        return 1;
    }
    memcpy(&number, payload, 4);
    if (!started || number != expected) {
        ask(number);
        return started;
    }
    int is_due = 0;
    expected++;
    has_asked = 0;
    switch (kind) {
    case IMU: is_due = take_sample(payload); samples++; break;
    case EPOCH: take_epoch(payload); break;
    case TEMPERATURE: take_temperature(payload); break;
    default: configure(loop.floats + 2u * loop.clock_at, loop.floats + 2u * (loop.clock_at + loop.clock_size));
    }
    link_write(kind, payload, (uint8_t)length);
    if (samples == SAMPLES_A_SLICE) {
        samples = 0;
        tell_slice();
    }
    if (is_due) {
        steps = 0;
        tell_solution();
    }
    return 1;
}

void loop_stop(void)
{
    started = 0;
    expected = 0;
}
