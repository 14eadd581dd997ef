/* 168 MHz from the internal oscillator of 16 MHz, so that the image runs on any board with this chip, whatever
 * its crystal. Where the oscillator's registers do not answer (an emulator), the reset clock stays. */
#include "clock.h"
#include "registers.h"

enum { PATIENCE = 100000, HSI_HZ = 16000000, CORE_HZ = 168000000 };

uint32_t clock_core_hz = HSI_HZ, clock_usart_hz = HSI_HZ;

static int waited_for(volatile uint32_t *at, uint32_t mask, uint32_t wanted)
{
    for (int n = 0; n < PATIENCE; n++)
        if ((*at & mask) == wanted)
            return 1;
    return 0;
}

static void start_pll(void)
{
    RCC_PLLCFGR = 16u | 336u << 6 | 0u << 16 | 7u << 24; /* 16 MHz / 16 * 336 / 2 */
    RCC_CR |= 1u << 24;
    if (!waited_for(&RCC_CR, 1u << 25, 1u << 25))
        return;
    FLASH_ACR = 5u | 7u << 8;                  /* 5 wait states, prefetch, both caches */
    RCC_CFGR = 5u << 10 | 4u << 13;            /* APB1 a quarter, APB2 half */
    RCC_CFGR |= 2u;
    if (waited_for(&RCC_CFGR, 3u << 2, 2u << 2)) {
        clock_core_hz = CORE_HZ;
        clock_usart_hz = CORE_HZ / 2;
    }
}

void clock_start(void)
{
    start_pll();
    SYST_RVR = 0xFFFFFFu;
    SYST_CVR = 0;
    SYST_CSR = 5u; /* core clock, no interrupt */
}

uint32_t clock_count(void)
{
    return SYST_CVR;
}
