/* Calls every function as Python did, and compares what they write with what Python wrote. */
#include "calls.h"
#include "cases.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static int same(double one, double other)
{
    return one == other || (isnan(one) && isnan(other));
}

int main(void)
{
    static calls_number reads[CALLS_MOST_READ + 1], writes[CALLS_MOST_WRITTEN + 1];
    const double *number = cases_numbers, *size = cases_sizes;
    double worst = 0.0;
    int identical = 0, numbers = 0, wrong = 0;
    for (int call = 0; call < CASES_CALLS; call++) {
        const int k = cases_functions[call];
        for (int i = 0; i < calls_functions[k].reads; i++) {
            reads[i] = (calls_number)*number++;
        }
        memset(writes, 0, sizeof writes);
        calls_call(k, reads, writes);
        for (int i = 0; i < calls_functions[k].writes; i++, number++, size++) {
            const double found = (double)writes[i], right = *number;
            const double off = same(found, right) ? 0.0 : fabs(found - right) / *size;
            numbers++;
            identical += same(found, right);
            if (off > worst) {
                worst = off;
            }
            if (!(off <= CASES_TOLERANCE)) {
                wrong++;
                printf("call %d, %s, number %d: %.17g, but %.17g in Python\n", call,
                       calls_functions[k].name, i, found, right);
            }
        }
    }
    printf("%d cases, %d calls: %d of %d numbers are Python's to the last bit, the others are "
           "at most %.1e of their size off\n",
           CASES, CASES_CALLS, identical, numbers, worst);
    printf("%s: %d differ by more than %.0e\n", wrong ? "FAILED" : "passed", wrong,
           CASES_TOLERANCE);
    return wrong != 0;
}
