/* An interrupt puts what comes into a ring; bytes beyond it are lost, as the check sums will tell. */
#include "serial.h"
#include "registers.h"

enum { RXNE = 1u << 5, TXE = 1u << 7, OVERRUN = 1u << 3, USART1_LINE = 1u << (37 - 32) };

static volatile uint8_t ring[SERIAL_RING];
static volatile uint32_t received;
static uint32_t taken;

void serial_start(uint32_t usart_hz, uint32_t baud)
{
    RCC_AHB1ENR |= 1u;
    RCC_APB2ENR |= 1u << 4;
    GPIOA_AFRH = (GPIOA_AFRH & ~0xFF0u) | 0x770u;
    GPIOA_PUPDR = (GPIOA_PUPDR & ~(3u << 20)) | 1u << 20;
    GPIOA_MODER = (GPIOA_MODER & ~(0xFu << 18)) | 0xAu << 18;
    USART1_BRR = (usart_hz + baud / 2) / baud;
    NVIC_ISER1 = USART1_LINE;
    USART1_CR1 = 1u << 13 | RXNE | 1u << 3 | 1u << 2; /* on, interrupt on reception, transmitter, receiver */
    __asm__ volatile("cpsie i");
}

void serial_interrupt(void)
{
    while (USART1_SR & (RXNE | OVERRUN)) {
        uint8_t byte = (uint8_t)USART1_DR; /* reading status and data clears both */
        if (received - taken < SERIAL_RING)
            ring[received++ % SERIAL_RING] = byte;
    }
}

uint8_t serial_read(void)
{
    __asm__ volatile("cpsid i");
    while (received == taken) {
        __asm__ volatile("wfi"); /* wakes up for an interrupt that is held off, too */
        __asm__ volatile("cpsie i\n isb\n cpsid i");
    }
    uint8_t byte = ring[taken++ % SERIAL_RING];
    __asm__ volatile("cpsie i");
    return byte;
}

void serial_write(uint8_t byte)
{
    while (!(USART1_SR & TXE)) {
    }
    USART1_DR = byte;
}
