/* Makes the calls of a test, and prints for each the function's number, instructions and stack.
 *
 * QEMU's -icount shift=0 lets the clock advance by a nanosecond an instruction; the SysTick counts
 * it at 25 MHz, so one count is 40 instructions. The stack below is painted before a call, and what
 * is no longer painted afterwards was used.
 */
/* A call at the end of a function is a call, and no jump: all have their part of the stack. */
#pragma GCC optimize("no-optimize-sibling-calls")

#include "calls.h"
#include "cases.h"

__attribute__((noinline)) void calls_call(int function, const calls_number *reads,
                                          calls_number *writes);
#include "calls.c"

#include <stdint.h>
#include <stdio.h>
#include <string.h>

enum { WORDS = 1 << 14, INSTRUCTIONS_A_COUNT = 40 };

static const uint32_t PAINT = 0xA5A5A5A5U;

static volatile uint32_t *const CONTROL = (uint32_t *)0xE000E010;
static volatile uint32_t *const RELOAD = (uint32_t *)0xE000E014;
static volatile uint32_t *const COUNTER = (uint32_t *)0xE000E018;

static uint32_t *top(void)
{
    uint32_t *pointer;
    __asm volatile("mov %0, sp" : "=r"(pointer));
    return pointer;
}

/* Paint what is below the stack of this function, which calls none. */
static __attribute__((noinline)) void paint(uint32_t *from)
{
    uint32_t *const end = top();
    for (volatile uint32_t *word = from - WORDS; word < end; word++) {
        *word = PAINT;
    }
}

static __attribute__((noinline)) unsigned used(const uint32_t *from)
{
    const volatile uint32_t *word = from - WORDS;
    while (word < from && *word == PAINT) {
        word++;
    }
    return (unsigned)((uintptr_t)from - (uintptr_t)word);
}

static __attribute__((noinline, noclone)) unsigned counts(int function, const calls_number *reads,
                                                 calls_number *writes)
{
    const uint32_t before = *COUNTER;
    calls_call(function, reads, writes);
    return (before - *COUNTER) & 0xFFFFFFU;
}

int main(void)
{
    static calls_number reads[CALLS_MOST_READ + 1], writes[CALLS_MOST_WRITTEN + 1];
    const double *number = cases_numbers;
    *RELOAD = 0xFFFFFFU;
    *COUNTER = 0;
    *CONTROL = 5;
    for (int call = 0; call < CASES_CALLS; call++) {
        const int k = cases_functions[call];
        unsigned counted;
        for (int i = 0; i < calls_functions[k].reads; i++) {
            reads[i] = (calls_number)*number++;
        }
        number += calls_functions[k].writes;
        memset(writes, 0, sizeof writes);
        paint(top());
        counted = counts(k, reads, writes);
        printf("%d %u %u\n", k, counted * INSTRUCTIONS_A_COUNT, used(top()));
    }
    return 0;
}
