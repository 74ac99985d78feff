/* Reads lines of numbers and answers each with a line of numbers.
 *
 * A line holds the numbers that a function reads, in the order of README.md. A word before them
 * names another function; without one it is that of the command line, or else the first that reads
 * numbers. The answer is what the function returns, where it returns anything, and what it writes.
 * What is remembered between two calls is remembered from line to line.
 */
#include "calls.h"

#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { CHARACTERS_A_NUMBER = 40, LINE = CHARACTERS_A_NUMBER * (CALLS_MOST_READ + 2) };

static int named(const char *name, size_t length)
{
    for (int k = 0; k < CALLS_FUNCTIONS; k++) {
        if (strlen(calls_functions[k].name) == length
            && strncmp(calls_functions[k].name, name, length) == 0) {
            return k;
        }
    }
    return -1;
}

static int first_that_reads(void)
{
    for (int k = 0; k < CALLS_FUNCTIONS; k++) {
        if (calls_functions[k].reads > 0) {
            return k;
        }
    }
    return 0;
}

/* Return how many numbers a text holds, or -1 if there is something else in it. */
static int numbers_in(const char *text, calls_number *numbers, int most)
{
    int count = 0;
    for (;;) {
        char *end;
        double number;
        while (isspace((unsigned char)*text) || *text == ',') {
            text++;
        }
        if (*text == '\0') {
            return count;
        }
        number = strtod(text, &end);
        if (end == text || count == most) {
            return -1;
        }
        numbers[count++] = (calls_number)number;
        text = end;
    }
}

static int answer(const char *text, int function)
{
    static calls_number reads[CALLS_MOST_READ + 1], writes[CALLS_MOST_WRITTEN + 1];
    while (isspace((unsigned char)*text)) {
        text++;
    }
    if (isalpha((unsigned char)*text)) {
        size_t length = strcspn(text, " \t\r\n,");
        int other = named(text, length);
        if (other >= 0) {
            function = other;
            text += length;
        }
    }
    if (numbers_in(text, reads, CALLS_MOST_READ) != calls_functions[function].reads) {
        fprintf(stderr, "%s reads %d numbers, not: %s\n", calls_functions[function].name,
                calls_functions[function].reads, text);
        return 0;
    }
    memset(writes, 0, sizeof writes);
    calls_call(function, reads, writes);
    for (int i = 0; i < calls_functions[function].writes; i++) {
        printf(i ? " %.*g" : "%.*g", CALLS_DIGITS, (double)writes[i]);
    }
    putchar('\n');
    return 1;
}

int main(int count, char **words)
{
    static char line[LINE];
    int function = count > 1 ? named(words[1], strlen(words[1])) : first_that_reads();
    if (function < 0) {
        fprintf(stderr, "there is no function %s; there are:", words[1]);
        for (int k = 0; k < CALLS_FUNCTIONS; k++) {
            fprintf(stderr, " %s", calls_functions[k].name);
        }
        fputc('\n', stderr);
        return 2;
    }
    for (int k = 0; k < CALLS_FUNCTIONS; k++) {
        if (calls_functions[k].begins) {
            calls_call(k, NULL, NULL);
        }
    }
    while (fgets(line, LINE, stdin)) {
        if (strchr(line, '\n') == NULL && strlen(line) == LINE - 1) {
            fprintf(stderr, "a line has more than %d characters\n", LINE - 2);
            return 2;
        }
        if (line[strspn(line, " \t\r\n")] != '\0' && !answer(line, function)) {
            return 2;
        }
    }
    return 0;
}
