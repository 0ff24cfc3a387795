/* Vectors and reset of a Cortex-M4F; newlib's own start does the rest. */
extern void _start(void);
extern unsigned stack_top;

void reset(void) {
    *(volatile unsigned *)0xE000ED88 |= 0xF << 20; /* the floating-point unit */
    __asm volatile("dsb\nisb");
    _start();
    for (;;)
        ;
}

__attribute__((section(".vectors"), used)) const void *const vectors[] = {
    &stack_top, (const void *)reset};
