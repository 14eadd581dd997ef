#include "arrays.h"
#include "kernels.h"

uint8_t memory[MEMORY_SIZE] __attribute__((aligned(8)));
static struct array arrays[256];

int memory_holds(uint32_t offset, uint32_t size)
{
    return offset <= MEMORY_SIZE && size <= MEMORY_SIZE - offset;
}

int array_define(uint8_t handle, struct array array)
{
    if (array.offset % 8 || !memory_holds(array.offset, (array.size + 7u) & ~7u))
        return 0;
    arrays[handle] = array;
    return 1;
}

const struct array *array_of(uint8_t handle)
{
    return &arrays[handle];
}

uint64_t digest_add(uint64_t digest, uint32_t word)
{
    return digest * 0x9E3779B97F4A7C15u + word;
}

uint64_t digest_array(uint64_t digest, const struct array *array)
{
    const uint32_t *word = (const uint32_t *)(memory + array->offset);
    const uint32_t *end = word + (array->size + 3u) / 4u;
    if (array->is_float)
        while (word < end)
            digest = digest_add(digest, canonical(*word++));
    else
        while (word < end)
            digest = digest_add(digest, *word++);
    return digest;
}
