/* No interrupt is taken: the processor sleeps until one is pending. The host sends nothing while it computes. */
#include "serial.h"
#include "registers.h"

enum { RXNE = 1u << 5, TXE = 1u << 7, USART1_PENDING = 1u << (37 - 32) };

void serial_start(uint32_t usart_hz, uint32_t baud)
{
    RCC_AHB1ENR |= 1u;
    RCC_APB2ENR |= 1u << 4;
    GPIOA_AFRH = (GPIOA_AFRH & ~0xFF0u) | 0x770u;
    GPIOA_PUPDR = (GPIOA_PUPDR & ~(3u << 20)) | 1u << 20;
    GPIOA_MODER = (GPIOA_MODER & ~(0xFu << 18)) | 0xAu << 18;
    USART1_BRR = (usart_hz + baud / 2) / baud;
    __asm__ volatile("cpsid i");
    NVIC_ISER1 = USART1_PENDING;
    USART1_CR1 = 1u << 13 | RXNE | 1u << 3 | 1u << 2; /* on, interrupt on reception, transmitter, receiver */
}

uint8_t serial_read(void)
{
    for (;;) {
        NVIC_ICPR1 = USART1_PENDING;
        if (USART1_SR & RXNE)
            break;
        __asm__ volatile("wfi");
    }
    return (uint8_t)USART1_DR; /* clears an overrun too; the frame's CRC will tell */
}

void serial_write(uint8_t byte)
{
    while (!(USART1_SR & TXE)) {
    }
    USART1_DR = byte;
}
