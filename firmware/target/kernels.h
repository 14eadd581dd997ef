/* The kernels of an image; the table is generated when the image is built. */
#ifndef KERNELS_H
#define KERNELS_H
#include <stdint.h>

enum { ARGUMENT_LIMIT = 16, RESULT_LIMIT = 16 };

struct kernel {
    /* results[0] is the kernel's status, the others follow; scalars lie in the low bytes. */
    void (*call)(const uint64_t *arguments, uint64_t *results);
    const char *kinds; /* an argument each: 'a' array, or the bytes of a scalar, '1' '2' '4' '8' */
    uint8_t results;   /* with the status */
};

extern const struct kernel kernels[];
extern const uint8_t kernel_count;
extern const char image_identity[17]; /* 16 characters */

/* Bits of a float; every NaN is the same one, x86 and ARM differ in sign and payload. */
static inline uint32_t canonical(uint32_t bits)
{
    return (bits & 0x7FFFFFFFu) > 0x7F800000u ? 0x7FC00000u : bits;
}

static inline float float_of(uint64_t slot)
{
    union { uint32_t bits; float value; } both = {(uint32_t)slot};
    return both.value;
}

static inline uint64_t slot_of_float(float value)
{
    union { float value; uint32_t bits; } both = {value};
    return canonical(both.bits);
}

#endif
