/* A program's navigation loop by itself: raw frames in, solution frames out (docs/link.md). */
#ifndef LOOP_H
#define LOOP_H
#include <stdint.h>

/* What a program's loop is made of; generated when the image is built. `floats` is 0 where there is none. */
struct loop {
    uint16_t floats, integers, record, told; /* of the state, and of an epoch: kept, and in a frame */
    uint8_t each_sample, steps;              /* whether every sample is a step; steps to a solution */
    uint8_t sample, epoch, temperature, solution; /* numbers of the kernels */
    uint16_t clock_at, clock_size;           /* integers that begin anew with the sensor */
    uint8_t solution_floats, solution_integers;
    uint8_t flags, time_of_day, date, burst_start, valid; /* places in an epoch */
    uint32_t has_time;
    int64_t nominal_latency_ns, longest_pulse_age_ns;
    const struct loop_run *runs; /* of the configured state, floats and integers; the rest is zero */
    uint16_t run_count;
};

struct loop_run {
    uint16_t word, count; /* 32-bit words from the first one on */
    const uint32_t *values;
};

extern const struct loop loop;

/* A frame of the link; whether it is one that the loop takes. */
int loop_take(uint8_t kind, const uint8_t *payload, uint32_t length);

/* Another START is wanted before anything else. */
void loop_stop(void);

#endif
