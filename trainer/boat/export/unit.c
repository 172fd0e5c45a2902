/* A boat as a functional mock-up unit for co-simulation, over the tick of trainer's object: what
   fmi2.c and fmi3.c have in common. Each is one version of the standard, begins with what it calls
   things, and then includes this file. model.h, which trainer boat export-fmu writes, has the
   boat's records, its variables and its seas. A moment is all that evolves, in one row of doubles:
   the state, then the sea chosen, start time, phase, and the value last given to each variable that
   can be set. Whatever is refused leaves the moment as it was. */

#include <math.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Of a version: FMI(name) and the names that differ; struct host, which has what a simulator
   offers, and LOG(host, name, text), which tells it; more arguments of functions on values. */

enum { OK = 0, ERROR = 3, CO_SIMULATION = 1 };             /* as FMI counts them */
enum { REAL, INTEGER, BOOLEAN };                           /* types of variables */
enum { READ, TIME, GAUGE, NUMBER, COURSE, PARAMETER, CASUALTY }; /* what getting or setting does */
enum { INSTANTIATED = 1, INITIALIZING = 2, STEPPING = 4, TERMINATED = 8, ANY_PHASE = 15 };

enum { WANTED_DOUBLES = 9, WANTED_DIRECTION = 3, SEA_DOUBLES = 8, MAX_TICKS = 1000000 };

struct sea { double wanted[WANTED_DOUBLES], fits; }; /* as it is ordered; 0: too short for the step */

struct variable {
    int type, rule;
    const char *name, *limits;     /* limits in words */
    double low, high, scale;       /* SI = scale x value */
    int place, cleared, shortened; /* in the moment; -1 none */
    double ramp, clear_ramp;       /* [ticks] of a casualty */
};

#include "model.h"

enum { SEA_STATE = STATE_DOUBLES, SEA_FROM, START_TIME, PHASE, GIVEN };
enum { MOMENT_DOUBLES = GIVEN + SETTABLE_COUNT };
static const double TURN = 6.283185307179586;

/* The kernels in trainer's object: all numbers are doubles, all records addresses. */
int trainer_update(const void *, const void *, const void *, double *state, double *scratch);
int trainer_order_sea(const void *, double step, double ramp, const double *wanted,
                      double *scratch, double *state);
int trainer_begin(double kind, double amount, double ticks, double *state);
int trainer_end(double kind, double ticks, double *state);
int trainer_instruments(double *state, double *scratch);

struct saved {
    char guid[sizeof GUID];
    double moment[MOMENT_DOUBLES];
};

struct instance {
    struct host host;
    struct saved now;
    double *moment, scratch[SCRATCH_DOUBLES]; /* the moment is that of now */
    char name[];
};

/* Tell the simulator what is wrong; return the error. */
static int tell(const struct host *host, const char *name, const char *form, ...)
{
    char text[512];
    va_list facts;
    va_start(facts, form);
    vsnprintf(text, sizeof text, form, facts);
    va_end(facts);
    if (host->logger)
        LOG(host, name, text);
    return ERROR;
}

#define REFUSE(...) tell(&boat->host, boat->name, __VA_ARGS__)
#define EXPECT(phases)                                                                         \
    if (!boat || (!((int)boat->moment[PHASE] & (phases)) &&                                    \
                  REFUSE("%s: not in this phase: set up the experiment, enter and exit "       \
                         "initialization, step, terminate", __func__)))                        \
        return ERROR

/* Return the moment [s] of the simulator at which the last step ended. */
static double time_of(const struct instance *boat)
{
    return boat->moment[START_TIME] + boat->moment[TICK_PLACE] * STEP_S;
}

static double value_of(const struct variable *v, struct instance *boat)
{
    const double *moment = boat->moment;
    if (v->rule == TIME)
        return time_of(boat);
    if (v->rule == GAUGE) {
        trainer_instruments(boat->moment, boat->scratch);
        return boat->scratch[READING_PLACE + v->place] / v->scale;
    }
    if (v->rule == CASUALTY) {
        for (int i = 0; i < CASUALTY_SLOTS; i++) /* one that is being cleared counts no more */
            if (moment[CASUALTY_PLACE + i] == v->place && moment[TICKS_PLACE + i] >= 0.0)
                return v->type == BOOLEAN ? 1.0 : moment[TARGET_PLACE + i] / v->scale;
        return 0.0;
    }
    double value = moment[v->place] / v->scale;
    return v->rule == COURSE ? value - v->high * floor(value / v->high) : value;
}

/* Do what a variable that is set does; return why it cannot be, NULL if it can. */
static const char *set_value(const struct variable *v, double value, struct instance *boat)
{
    double *moment = boat->moment, number = v->scale * value, psi = moment[PSI_PLACE];
    if (v->rule == READ || v->rule == TIME || v->rule == GAUGE)
        return "can only be read";
    if (v->rule == PARAMETER && moment[PHASE] == STEPPING)
        return "a parameter is set before initialization ends";
    if (!(value >= v->low && value <= v->high)) /* true of what is not a number too */
        return v->limits;
    if (v->place == SEA_STATE && v->rule == PARAMETER && !SEAS[(int)value + 1].fits)
        return "a sea above Nyquist for this step: export with a shorter --step";
    if (v->rule == CASUALTY) {
        if (value == value_of(v, boat))
            return NULL;
        if (value == 0.0)
            trainer_end(v->place, v->clear_ramp, moment);
        else if (!trainer_begin(v->place, number, v->ramp, moment))
            return "there are as many casualties as can be: clear one";
        return NULL;
    }
    double *given = moment + GIVEN + (v - VARIABLES); /* what is set again is no new order, even */
    if (value == *given)                              /* where the boat has changed the number */
        return NULL;
    *given = value;
    if (v->rule == COURSE) { /* the short way, but one that is ordered already stands to the bit */
        double course = value == v->high ? 0.0 : number, ordered = moment[v->place];
        if (fabs(remainder(course - ordered, TURN)) < 1e-9)
            return NULL;
        number = psi + remainder(course - psi, TURN);
    }
    if (moment[v->place] == number)
        return NULL;
    moment[v->place] = number;
    if (v->cleared >= 0)
        moment[v->cleared] = 0.0;
    if (v->shortened >= 0 && number == 0.0)
        moment[v->shortened] = psi + remainder(moment[v->shortened] - psi, TURN);
    return NULL;
}

static const struct variable *find(unsigned reference, int type)
{
    const struct variable *v = reference < VARIABLE_COUNT ? &VARIABLES[reference] : NULL;
    return v && v->type == type ? v : NULL;
}

#ifdef _WIN32
#define SHOWN __attribute__((dllexport))
#else
#define SHOWN __attribute__((visibility("default")))
#endif
#define ACCESS(kind, number, kind_type)                                                        \
    SHOWN int FMI(Get##kind)(struct instance *boat, const unsigned *references, size_t count,  \
                             number *values VALUE_COUNT)                                       \
    {                                                                                          \
        EXPECT(ANY_PHASE);                                                                     \
        for (size_t i = 0; i < count; i++) {                                                   \
            const struct variable *v = find(references[i], kind_type);                         \
            if (!v)                                                                            \
                return REFUSE("%s: no " #kind " has value reference %u", __func__,             \
                              references[i]);                                                  \
            values[i] = (number)value_of(v, boat);                                             \
        }                                                                                      \
        return OK;                                                                             \
    }                                                                                          \
    SHOWN int FMI(Set##kind)(struct instance *boat, const unsigned *references, size_t count,  \
                             const number *values VALUE_COUNT)                                 \
    {                                                                                          \
        double before[MOMENT_DOUBLES];                                                         \
        EXPECT(INSTANTIATED | INITIALIZING | STEPPING);                                        \
        memcpy(before, boat->moment, sizeof before);                                           \
        for (size_t i = 0; i < count; i++) {                                                   \
            const struct variable *v = find(references[i], kind_type);                         \
            const char *why = v ? set_value(v, values[i], boat) : "no such value reference";   \
            if (!why)                                                                          \
                continue;                                                                      \
            memcpy(boat->moment, before, sizeof before);                                       \
            return REFUSE("%s: %s (%u) = %g: %s", __func__, v ? v->name : "no " #kind,         \
                          references[i], (double)values[i], why);                              \
        }                                                                                      \
        return OK;                                                                             \
    }
SHOWN int FMI(Reset)(struct instance *boat)
{
    EXPECT(ANY_PHASE);
    memcpy(boat->now.guid, GUID, sizeof GUID);
    memcpy(boat->moment, START, sizeof START);
    boat->moment[SEA_STATE] = -1.0;
    boat->moment[SEA_FROM] = START_SEA_FROM;
    boat->moment[START_TIME] = 0.0;
    boat->moment[PHASE] = INSTANTIATED;
    memset(boat->scratch, 0, sizeof boat->scratch);
    for (int i = 0; i < SETTABLE_COUNT; i++)
        boat->moment[GIVEN + i] = value_of(&VARIABLES[i], boat);
    return OK;
}

/* Return a new boat, NULL where a name or the token is missing or wrong. */
static struct instance *make(const struct host *host, const char *name, const char *token,
                             const char *caller)
{
    if (!name || !*name || !token || strcmp(token, GUID)) {
        tell(host, name ? name : "", "%s: give a name, co-simulation, and the GUID %s of this "
             "FMU's modelDescription.xml", caller, GUID);
        return NULL;
    }
    struct instance *boat = calloc(1, sizeof *boat + strlen(name) + 1);
    if (!boat)
        return NULL;
    boat->host = *host;
    boat->moment = boat->now.moment;
    boat->moment[PHASE] = INSTANTIATED;
    strcpy(boat->name, name);
    FMI(Reset)(boat);
    return boat;
}

SHOWN void FMI(FreeInstance)(struct instance *boat) { free(boat); }

/* What is refused is always told. */
SHOWN int FMI(SetDebugLogging)(struct instance *boat) { return boat ? OK : ERROR; }

static int set_times(struct instance *boat, double start, bool has_stop, double stop,
                     const char *caller)
{
    if (!isfinite(start) || (has_stop && !(stop >= start)))
        return REFUSE("%s: from %g to %g s: a start is a number, and the stop not before it",
                      caller, start, stop);
    boat->moment[START_TIME] = start;
    return OK;
}

SHOWN int FMI(Terminate)(struct instance *boat)
{
    EXPECT(STEPPING);
    boat->moment[PHASE] = TERMINATED;
    return OK;
}

/* The sea chosen is there at its full height, as after a long time. */
SHOWN int FMI(ExitInitializationMode)(struct instance *boat)
{
    double wanted[WANTED_DOUBLES];
    EXPECT(INITIALIZING);
    memcpy(wanted, SEAS[(int)boat->moment[SEA_STATE] + 1].wanted, sizeof wanted);
    wanted[WANTED_DIRECTION] = fmod(boat->moment[SEA_FROM] + 180.0, 360.0) * DEGREE;
    boat->moment[SEA_PLACE] = 0.0;
    memcpy(boat->moment + SEA_PLACE + 1, wanted + 1, (SEA_DOUBLES - 1) * sizeof *wanted);
    trainer_order_sea(VESSEL, STEP_S, 0.0, wanted, boat->scratch, boat->moment);
    boat->moment[PHASE] = STEPPING;
    return OK;
}

static int sail(struct instance *boat, double now, double step, const char *caller)
{
    double before[STATE_DOUBLES];
    double end = time_of(boat), ticks = step / STEP_S;
    if (!(ticks > 0.5 && ticks < MAX_TICKS && fabs(remainder(ticks, 1.0)) < 1e-6))
        return REFUSE("%s: step of %g s: must be %g s or its multiple", caller, step, STEP_S);
    if (!(fabs(now - end) < 0.01 * STEP_S))
        return REFUSE("%s: from %g s: the last step ended at %g s", caller, now, end);
    memcpy(before, boat->moment, sizeof before);
    for (int tick = (int)(ticks + 0.5); tick > 0; tick--) {
        int status = trainer_update(VESSEL, COMPACT, SCHEME, boat->moment, boat->scratch);
        if (!status)
            continue;
        memcpy(boat->moment, before, sizeof before);
        return REFUSE("%s: %s goes out of all bounds after %g s", caller,
                      status > 0 ? WATCHED[status - 1] : "a number", now);
    }
    return OK;
}

static int keep(struct instance *boat, const void *bytes, struct saved **kept)
{
    if (!*kept && !(*kept = malloc(sizeof **kept)))
        return REFUSE("%s: no memory", __func__);
    memcpy(*kept, bytes, sizeof **kept);
    return OK;
}

SHOWN int FMI(GetFMUState)(struct instance *boat, struct saved **kept)
{
    return keep(boat, &boat->now, kept);
}

SHOWN int FMI(SetFMUState)(struct instance *boat, const struct saved *kept)
{
    boat->now = *kept;
    return OK;
}

SHOWN int FMI(FreeFMUState)(struct instance *boat, struct saved **kept)
{
    free(*kept);
    *kept = NULL;
    return OK;
}

SHOWN int FMI(SerializedFMUStateSize)(struct instance *boat, struct saved *kept, size_t *size)
{
    *size = sizeof *kept;
    return OK;
}

SHOWN int FMI(SerializeFMUState)(struct instance *boat, struct saved *kept, char *bytes, size_t size)
{
    if (size != sizeof *kept)
        return REFUSE("%s: %zu bytes: a state has %zu", __func__, size, sizeof *kept);
    memcpy(bytes, kept, size);
    return OK;
}

SHOWN int FMI(DeserializeFMUState)(struct instance *boat, const char *bytes, size_t size,
                                  struct saved **kept)
{
    if (size != sizeof **kept || memcmp(bytes, GUID, sizeof GUID))
        return REFUSE("%s: no state of this model: give one that this FMU made", __func__);
    return keep(boat, bytes, kept);
}

/* What modelDescription.xml says that it cannot do; their other arguments are not looked at. */
#define LACKING(name)                                                                          \
    SHOWN int name(struct instance *boat) { return boat ? REFUSE("%s: none", __func__) : ERROR; }
