/* Vector table and start-up: memory, floating-point unit, clock, then what the line asks for. */
#include "clock.h"
#include "line.h"
#include "registers.h"
#include "serial.h"

extern uint32_t data_start, data_end, data_load, bss_start, bss_end, stack_top;

void reset_handler(void);

/* A fault stops here: the host tells that the port is silent. */
static void stop(void)
{
    for (;;) {
    }
}

__attribute__((section(".vectors"), used)) static const void *const vectors[16 + 38] = {
    &stack_top, reset_handler, stop, stop, stop, stop, stop, 0, 0, 0, 0, stop, stop, 0, stop, stop,
    [16 + 37] = serial_interrupt,
};

__attribute__((naked)) void reset_handler(void)
{
    /* Full access to coprocessors 10 and 11 before any function may use a float register. */
    __asm__ volatile("ldr r0, =0xE000ED88\n ldr r1, [r0]\n orr r1, r1, #0xF00000\n str r1, [r0]\n"
                     "dsb\n isb\n b start\n .ltorg");
}

__attribute__((used, noreturn)) void start(void)
{
    const uint32_t *from = &data_load;
    for (uint32_t *to = &data_start; to < &data_end;)
        *to++ = *from++;
    for (uint32_t *to = &bss_start; to < &bss_end;)
        *to++ = 0;
    uint32_t fpscr = 0; /* round to nearest, subnormals kept, NaN as they come */
#ifdef ROUND_TOWARDS_ZERO
    fpscr = 3u << 22;
#endif
    __asm__ volatile("vmsr fpscr, %0" ::"r"(fpscr));
    clock_start();
    serial_start(clock_usart_hz, SERIAL_BAUD);
    line_serve();
}
