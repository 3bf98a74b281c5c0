/* Start-up of the example on an emulated Cortex-M4F board (mps2-an386): vector table, FPU on, then the C library's
 * start-up code, which prints through semihosting. */
#include <stdint.h>

extern void _start(void);
extern uint32_t _stack_top;

void reset(void) {
    *(volatile uint32_t *)0xE000ED88u |= 0xFu << 20; /* CPACR: full access to the FPU */
    __asm volatile("dsb\n isb");
    _start();
}

/* A fault is an error that the emulator can report: exit with status 1. */
void fault(void) {
    static const uint32_t block[2] = {0x20026u, 1u};
    register uint32_t operation __asm("r0") = 0x20u;
    register const uint32_t *argument __asm("r1") = block;
    __asm volatile("bkpt 0xAB" : : "r"(operation), "r"(argument) : "memory");
    for (;;) {
    }
}

struct vector_table {
    uint32_t *stack;
    void (*handlers[15])(void);
};

__attribute__((section(".vectors"), used)) static const struct vector_table vectors = {
    &_stack_top, {reset, fault, fault, fault, fault, fault}};
