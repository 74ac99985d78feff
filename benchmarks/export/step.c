/* Times one function of exported code on the inputs of its test: main FUNCTION ROUNDS.
 *
 * Prints the nanoseconds of processor time that a call takes.
 */
#include "calls.h"
#include "cases.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

static calls_number rows[CASES][CALLS_MOST_READ + 1];

/* Collect the inputs of a function that are numbers, and return how many there are. */
static int collected(int function)
{
    const double *number = cases_numbers;
    int count = 0;
    for (int call = 0; call < CASES_CALLS; call++) {
        const int k = cases_functions[call];
        if (k == function) {
            int finite = 1;
            for (int i = 0; i < calls_functions[k].reads; i++) {
                rows[count][i] = (calls_number)number[i];
                finite = finite && isfinite(number[i]);
            }
            count += finite;
        }
        number += calls_functions[k].reads + calls_functions[k].writes;
    }
    return count;
}

int main(int words, char **word)
{
    static calls_number writes[CALLS_MOST_WRITTEN + 1];
    const int function = words > 1 ? atoi(word[1]) : 0;
    const long rounds = words > 2 ? atol(word[2]) : 1;
    const int count = collected(function);
    double sum = 0.0;
    clock_t start;
    for (int k = 0; k < CALLS_FUNCTIONS; k++) {
        if (calls_functions[k].begins) {
            calls_call(k, NULL, NULL);
        }
    }
    start = clock();
    for (long round = 0; round < rounds; round++) {
        for (int row = 0; row < count; row++) {
            calls_call(function, rows[row], writes);
            sum += (double)writes[1];
        }
    }
    printf("%.17g\n", (double)(clock() - start) / CLOCKS_PER_SEC * 1e9 / (double)(rounds * count));
    /* The sum is used, so the compiler cannot remove a call. */
    return sum == 0.123;
}
