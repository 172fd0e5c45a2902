/* The start of a program on an ARM Cortex-M7: its vectors, and the processor's own arithmetic.

   They lie at address 0, as on the board MPS2 AN500. Another board has its own file of this kind,
   with its memory, its clock and its handlers; the tick needs doubles in hardware, and no more. */

#include <stdint.h>

static volatile uint32_t *const ACCESS = (uint32_t *)0xE000ED88; /* to coprocessors */

void _start(void); /* of the C library, or the host's own */

static void reset(void)
{
    *ACCESS |= 0xFu << 20;
    __asm volatile("dsb\n\tisb");
    _start();
}

static void stop(void)
{
    for (;;)
        continue;
}

struct vectors {
    void *stack;
    void (*handlers[15])(void);
};

__attribute__((section(".vectors"), used)) static const struct vectors VECTORS = {
    (void *)0x20400000, /* behind the board's second memory */
    {reset, stop, stop, stop, stop, stop, stop, stop, stop, stop, stop, stop, stop, stop, stop},
};
