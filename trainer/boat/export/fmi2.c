/* A boat as a functional mock-up unit: co-simulation by FMI 2.0, over the tick of trainer's object.
   model.h, which trainer export-fmu writes, has the boat's records, its variables and its seas. A
   moment is all that evolves, in one row of doubles: the state, then the sea chosen, start time and
   phase. Whatever is refused leaves the moment as it was. */

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { OK = 0, ERROR = 3, CO_SIMULATION = 1 };             /* as FMI counts them */
enum { REAL, INTEGER, BOOLEAN };                           /* types of variables */
enum { READ, GAUGE, NUMBER, COURSE, PARAMETER, CASUALTY }; /* what getting or setting one does */
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

enum { SEA_STATE = STATE_DOUBLES, SEA_FROM, START_TIME, PHASE, MOMENT_DOUBLES };
static const double TURN = 6.283185307179586;

/* The kernels in trainer's object: all numbers are doubles, all records addresses. */
int trainer_update(const void *, const void *, const void *, double *state, double *scratch);
int trainer_order_sea(const void *, double step, double ramp, const double *wanted,
                      double *scratch, double *state);
int trainer_begin(double kind, double amount, double ticks, double *state);
int trainer_end(double kind, double ticks, double *state);
int trainer_instruments(double *state, double *scratch);

struct host {
    void (*logger)(void *, const char *, int, const char *, const char *, ...);
    void *not_used[3]; /* memory and asynchronous steps */
    void *environment;
};

struct saved {
    char guid[sizeof GUID];
    double moment[MOMENT_DOUBLES];
};

struct instance {
    const struct host *host;
    struct saved now;
    double *moment, scratch[SCRATCH_DOUBLES]; /* the moment is that of now */
    char name[];
};

/* Tell the simulator what is wrong; return fmi2Error. */
static int tell(const struct host *host, const char *name, const char *form, ...)
{
    char text[512];
    va_list facts;
    va_start(facts, form);
    vsnprintf(text, sizeof text, form, facts);
    va_end(facts);
    if (host->logger)
        host->logger(host->environment, name, ERROR, "logStatusError", "%s", text);
    return ERROR;
}

#define REFUSE(...) tell(boat->host, boat->name, __VA_ARGS__)
#define EXPECT(phases)                                                                         \
    if (!boat || (!((int)boat->moment[PHASE] & (phases)) &&                                    \
                  REFUSE("%s: not in this phase: set up the experiment, enter and exit "       \
                         "initialization, step, terminate", __func__)))                        \
        return ERROR

static double value_of(const struct variable *v, struct instance *boat)
{
    const double *moment = boat->moment;
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
    if (v->rule == READ || v->rule == GAUGE)
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

#define SHOWN __attribute__((visibility("default")))
#define ACCESS(kind, number, kind_type)                                                        \
    SHOWN int fmi2Get##kind(struct instance *boat, const unsigned *references, size_t count,   \
                            number *values)                                                    \
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
    SHOWN int fmi2Set##kind(struct instance *boat, const unsigned *references, size_t count,   \
                            const number *values)                                              \
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
ACCESS(Real, double, REAL)
ACCESS(Integer, int, INTEGER)
ACCESS(Boolean, int, BOOLEAN)

SHOWN const char *fmi2GetTypesPlatform(void) { return "default"; }
SHOWN const char *fmi2GetVersion(void) { return "2.0"; }

SHOWN int fmi2Reset(struct instance *boat)
{
    EXPECT(ANY_PHASE);
    memcpy(boat->now.guid, GUID, sizeof GUID);
    memcpy(boat->moment, START, sizeof START);
    boat->moment[SEA_STATE] = -1.0;
    boat->moment[SEA_FROM] = START_SEA_FROM;
    boat->moment[START_TIME] = 0.0;
    boat->moment[PHASE] = INSTANTIATED;
    memset(boat->scratch, 0, sizeof boat->scratch);
    return OK;
}

SHOWN void *fmi2Instantiate(const char *name, int kind, const char *guid, const char *resources,
                            const struct host *host, int visible, int logging)
{
    if (!host)
        return NULL;
    if (!name || !*name || kind != CO_SIMULATION || !guid || strcmp(guid, GUID)) {
        tell(host, name ? name : "", "%s: give a name, co-simulation, and the GUID %s of this "
             "FMU's modelDescription.xml", __func__, GUID);
        return NULL;
    }
    struct instance *boat = calloc(1, sizeof *boat + strlen(name) + 1);
    if (!boat)
        return NULL;
    boat->host = host;
    boat->moment = boat->now.moment;
    boat->moment[PHASE] = INSTANTIATED;
    strcpy(boat->name, name);
    fmi2Reset(boat);
    return boat;
}

SHOWN void fmi2FreeInstance(struct instance *boat) { free(boat); }

/* What is refused is always told. */
SHOWN int fmi2SetDebugLogging(struct instance *boat) { return boat ? OK : ERROR; }

SHOWN int fmi2SetupExperiment(struct instance *boat, int has_tolerance, double tolerance,
                              double start, int has_stop, double stop)
{
    EXPECT(INSTANTIATED);
    if (!isfinite(start) || (has_stop && !(stop >= start)))
        return REFUSE("%s: from %g to %g s: a start is a number, and the stop not before it",
                      __func__, start, stop);
    boat->moment[START_TIME] = start;
    return OK;
}

#define CHANGE_PHASE(name, from, to)                                                           \
    SHOWN int name(struct instance *boat)                                                      \
    {                                                                                          \
        EXPECT(from);                                                                          \
        boat->moment[PHASE] = to;                                                              \
        return OK;                                                                             \
    }
CHANGE_PHASE(fmi2EnterInitializationMode, INSTANTIATED, INITIALIZING)
CHANGE_PHASE(fmi2Terminate, STEPPING, TERMINATED)

/* The sea chosen is there at its full height, as after a long time. */
SHOWN int fmi2ExitInitializationMode(struct instance *boat)
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

SHOWN int fmi2DoStep(struct instance *boat, double now, double step, int no_return)
{
    double before[STATE_DOUBLES];
    EXPECT(STEPPING);
    double end = boat->moment[START_TIME] + boat->moment[TICK_PLACE] * STEP_S;
    double ticks = step / STEP_S;
    if (!(ticks > 0.5 && ticks < MAX_TICKS && fabs(remainder(ticks, 1.0)) < 1e-6))
        return REFUSE("%s: step of %g s: must be %g s or its multiple", __func__, step, STEP_S);
    if (!(fabs(now - end) < 0.01 * STEP_S))
        return REFUSE("%s: from %g s: the last step ended at %g s", __func__, now, end);
    memcpy(before, boat->moment, sizeof before);
    for (int tick = (int)(ticks + 0.5); tick > 0; tick--) {
        int status = trainer_update(VESSEL, COMPACT, SCHEME, boat->moment, boat->scratch);
        if (!status)
            continue;
        memcpy(boat->moment, before, sizeof before);
        return REFUSE("%s: %s goes out of all bounds after %g s", __func__,
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

SHOWN int fmi2GetFMUstate(struct instance *boat, struct saved **kept)
{
    return keep(boat, &boat->now, kept);
}

SHOWN int fmi2SetFMUstate(struct instance *boat, const struct saved *kept)
{
    boat->now = *kept;
    return OK;
}

SHOWN int fmi2FreeFMUstate(struct instance *boat, struct saved **kept)
{
    free(*kept);
    *kept = NULL;
    return OK;
}

SHOWN int fmi2SerializedFMUstateSize(struct instance *boat, struct saved *kept, size_t *size)
{
    *size = sizeof *kept;
    return OK;
}

SHOWN int fmi2SerializeFMUstate(struct instance *boat, struct saved *kept, char *bytes, size_t size)
{
    if (size != sizeof *kept)
        return REFUSE("%s: %zu bytes: a state has %zu", __func__, size, sizeof *kept);
    memcpy(bytes, kept, size);
    return OK;
}

SHOWN int fmi2DeSerializeFMUstate(struct instance *boat, const char *bytes, size_t size,
                                  struct saved **kept)
{
    if (size != sizeof **kept || memcmp(bytes, GUID, sizeof GUID))
        return REFUSE("%s: no state of this model: give one that this FMU made", __func__);
    return keep(boat, bytes, kept);
}

/* What modelDescription.xml says that it cannot do; their other arguments are not looked at. */
#define LACKING(name)                                                                          \
    SHOWN int name(struct instance *boat) { return boat ? REFUSE("%s: none", __func__) : ERROR; }
LACKING(fmi2GetString) LACKING(fmi2SetString) LACKING(fmi2CancelStep)
LACKING(fmi2GetDirectionalDerivative)
LACKING(fmi2SetRealInputDerivatives) LACKING(fmi2GetRealOutputDerivatives)
LACKING(fmi2GetStatus) LACKING(fmi2GetRealStatus) LACKING(fmi2GetIntegerStatus)
LACKING(fmi2GetBooleanStatus) LACKING(fmi2GetStringStatus)
