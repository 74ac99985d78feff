/* What runs before main on a Cortex-M4 or M7 with a floating-point unit, and its table of vectors.
 *
 * The C library's files of semihosting write to QEMU's output. A fault ends the emulation with an
 * error instead of hanging. Memory that is not given a value is zero when the emulation begins.
 */
#include <stdint.h>

extern uint32_t end_of_stack[];
extern int main(void);
extern void exit(int status);
extern void initialise_monitor_handles(void);

void reset(void);
void fault(void);
void _init(void);
void _fini(void);

/* The coprocessor access control register: full access to the floating-point unit. */
static volatile uint32_t *const CPACR = (uint32_t *)0xE000ED88;

void reset(void)
{
    *CPACR |= 0xFU << 20;
    __asm volatile("dsb\n isb");
#ifndef SILENT
    initialise_monitor_handles();
#endif
    exit(main());
}

void fault(void)
{
    exit(99);
}

/* The C library calls them around main. */
void _init(void) {}
void _fini(void) {}

typedef struct {
    uint32_t *stack;
    void (*handlers[15])(void);
} table_of_vectors;

__attribute__((section(".vectors"), used)) static const table_of_vectors vectors = {
    end_of_stack, {reset, fault, fault, fault, fault, fault},
};
