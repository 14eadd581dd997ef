/* Memory of the kernels' arrays. Where each lies is the host's business. */
#ifndef ARRAYS_H
#define ARRAYS_H
#include <stdint.h>

enum { MEMORY_SIZE = 96 * 1024 };

struct array {
    uint32_t offset, size; /* bytes; offset a multiple of 8, zeros behind an odd size */
    uint8_t is_float;
};

extern uint8_t memory[MEMORY_SIZE];

/* 0 when it lies outside the memory. */
int memory_holds(uint32_t offset, uint32_t size);
int array_define(uint8_t handle, struct array array);
const struct array *array_of(uint8_t handle);

/* The running digest h := h * M + word over all 32-bit words; one changed word always changes it. */
uint64_t digest_add(uint64_t digest, uint32_t word);
uint64_t digest_array(uint64_t digest, const struct array *array);

#endif
