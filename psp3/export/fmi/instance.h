/* An instance of an FMU, shared by all versions of FMI.
 *
 * model.h, which is written for each FMU, has the model: its values, its state, and the functions
 * that start and advance it. Only instances are written to, so there can be many at once.
 */
#ifndef INSTANCE_H
#define INSTANCE_H

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "model.h"

enum phase { INSTANTIATED, INITIALIZING, RUNNING, TERMINATED, FAILED };

#define REAL_ONLY "all variables of this FMU are real numbers of 64 bits"
#define INITIALIZED "the FMU is initialized already: reset it first"
#define NO_DERIVATIVES "this FMU offers no derivatives"

/* Tolerance of times for rounding errors, as a share of a period. */
#define TIME_TOLERANCE 1e-6

/* The state of an instance. It has no pointers, so a copy saves it. */
typedef struct {
    double values[MODEL_VALUES];
    model_state model;
    double start_time;
    double time;
    int phase;
    int is_stale;
} snapshot;

typedef struct {
    snapshot now;
    char problem[MODEL_LONGEST + 512];
} instance;

static void reset_instance(instance *it)
{
    int i;
    memset(&it->now, 0, sizeof it->now);
    for (i = 0; i < MODEL_VALUES; i++) {
        it->now.values[i] = model_start[i];
    }
    it->now.phase = INSTANTIATED;
    it->now.is_stale = 1;
    it->problem[0] = '\0';
}

static int fail(instance *it, double time, int code)
{
    snprintf(it->problem, sizeof it->problem, "at %.9g s: %s", time, model_message(code));
    it->now.phase = FAILED;
    return 0;
}

/* Set the initial state of the model and its outputs; return whether this succeeded. */
static int begin_instance(instance *it)
{
    int code;
    if (!it->now.is_stale) {
        return 1;
    }
    code = model_begin(&it->now.model, it->now.values);
    if (code == 1) {
        code = model_show(&it->now.model, it->now.values, it->now.time);
    }
    if (code != 1) {
        return fail(it, it->now.time, code);
    }
    it->now.is_stale = 0;
    return 1;
}

/* Begin the initialization; return whether this succeeded. */
static int enter_initialization(instance *it)
{
    if (it->now.phase != INSTANTIATED) {
        snprintf(it->problem, sizeof it->problem, INITIALIZED);
        return 0;
    }
    it->now.phase = INITIALIZING;
    return 1;
}

/* End the initialization, after which steps are allowed; return whether this succeeded. */
static int exit_initialization(instance *it)
{
    if (it->now.phase != INITIALIZING) {
        snprintf(it->problem, sizeof it->problem, "the FMU is not in initialization mode");
        return 0;
    }
    if (!begin_instance(it)) {
        return 0;
    }
    it->now.phase = RUNNING;
    return 1;
}

static int may_be_read(instance *it, size_t place)
{
    if (place >= MODEL_VALUES) {
        snprintf(it->problem, sizeof it->problem, "there is no variable of value reference %lu",
                 (unsigned long)place);
        return 0;
    }
    return 1;
}

/* Get values; before the first step outputs are those of the initial state. */
static int get_values(instance *it, const unsigned int places[], size_t count, double values[])
{
    size_t i;
    if (it->now.phase == INITIALIZING && !begin_instance(it)) {
        return 0;
    }
    for (i = 0; i < count; i++) {
        if (!may_be_read(it, places[i])) {
            return 0;
        }
        values[i] = it->now.values[places[i]];
    }
    return 1;
}

static int set_values(instance *it, const unsigned int places[], size_t count,
                      const double values[])
{
    size_t i;
    for (i = 0; i < count; i++) {
        if (!may_be_read(it, places[i])) {
            return 0;
        }
        if (model_causality[places[i]] == 'o') {
            snprintf(it->problem, sizeof it->problem, "%s is an output and cannot be set",
                     model_names[places[i]]);
            return 0;
        }
        if (model_causality[places[i]] == 'p' && it->now.phase > INITIALIZING) {
            snprintf(it->problem, sizeof it->problem,
                     "%s is a parameter and can be set before the simulation begins only",
                     model_names[places[i]]);
            return 0;
        }
        it->now.values[places[i]] = values[i];
        if (it->now.phase <= INITIALIZING) {
            it->now.is_stale = 1;
        }
    }
    return 1;
}

/* Return a time as a number of periods, or -1 if that is not a whole number. */
static double in_periods(double time)
{
    double count = floor(time / MODEL_PERIOD + 0.5);
    return fabs(time - count * MODEL_PERIOD) <= TIME_TOLERANCE * MODEL_PERIOD ? count : -1.0;
}

/* Advance by a number of periods with constant inputs; return whether this succeeded. */
static int move_on(instance *it, double time, double duration)
{
    double first = in_periods(time - it->now.start_time), count = in_periods(duration), k;
    if (it->now.phase != RUNNING) {
        snprintf(it->problem, sizeof it->problem, "no step is possible before initialization, "
                 "after termination or after an error: reset the FMU, or restore a state");
        return 0;
    }
    if (count < 1.0 || first < 0.0) {
        snprintf(it->problem, sizeof it->problem,
                 "a step of %.9g s from %.9g s on is none of whole periods of %.9g s from the start "
                 "at %.9g s: give such a communication step, or export another period",
                 duration, time, MODEL_PERIOD, it->now.start_time);
        return 0;
    }
    for (k = first; k < first + count; k += 1.0) {
        double from = it->now.start_time + MODEL_PERIOD * k;
        double to = it->now.start_time + MODEL_PERIOD * (k + 1.0);
        int code = model_step(&it->now.model, it->now.values, from);
        if (code != 1) {
            return fail(it, to, code);
        }
        it->now.time = to;
    }
    return 1;
}

#endif
