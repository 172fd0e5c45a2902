/* A planesman as a unit of FMI 2.0: from depth and pitch to the angle of the stern planes.

   He answers in whole tenths of a degree, at the end of a step, to what he saw at its beginning. */

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { OK, WARNING, DISCARD, ERROR };
enum { DEPTH, PITCH, ANGLE, WANTED_DEPTH, VARIABLES }; /* value references */

struct planesman { double values[VARIABLES]; };

static const double START[VARIABLES] = {0.0, 0.0, 0.0, 90.0};

const char *fmi2GetTypesPlatform(void) { return "default"; }
const char *fmi2GetVersion(void) { return "2.0"; }

void *fmi2Instantiate(const char *name, int kind, const char *guid, const char *resources,
                      const void *host, int visible, int logging)
{
    struct planesman *made = malloc(sizeof *made);
    if (made)
        memcpy(made->values, START, sizeof START);
    return made;
}

void fmi2FreeInstance(struct planesman *man) { free(man); }

int fmi2GetReal(struct planesman *man, const unsigned *references, size_t count, double *values)
{
    for (size_t i = 0; i < count; i++)
        values[i] = man->values[references[i]];
    return OK;
}

int fmi2SetReal(struct planesman *man, const unsigned *references, size_t count,
                const double *values)
{
    for (size_t i = 0; i < count; i++)
        man->values[references[i]] = values[i];
    return OK;
}

int fmi2DoStep(struct planesman *man, double now, double step, int no_return)
{
    double rise = 0.5 * (man->values[DEPTH] - man->values[WANTED_DEPTH]);
    double degrees = fmax(-10.0, fmin(10.0, rise - 60.0 * man->values[PITCH]));
    man->values[ANGLE] = rint(10.0 * degrees) / 10.0;
    return OK;
}

int fmi2Reset(struct planesman *man)
{
    memcpy(man->values, START, sizeof START);
    return OK;
}

/* What there is nothing to do for, and what a planesman has none of. */
#define EMPTY(name, status) int name(struct planesman *man) { return status; }
EMPTY(fmi2SetupExperiment, OK) EMPTY(fmi2EnterInitializationMode, OK)
EMPTY(fmi2ExitInitializationMode, OK) EMPTY(fmi2Terminate, OK) EMPTY(fmi2SetDebugLogging, OK)
EMPTY(fmi2GetInteger, ERROR) EMPTY(fmi2SetInteger, ERROR) EMPTY(fmi2GetBoolean, ERROR)
EMPTY(fmi2SetBoolean, ERROR) EMPTY(fmi2GetString, ERROR) EMPTY(fmi2SetString, ERROR)
EMPTY(fmi2GetFMUstate, ERROR) EMPTY(fmi2SetFMUstate, ERROR) EMPTY(fmi2FreeFMUstate, ERROR)
EMPTY(fmi2SerializedFMUstateSize, ERROR) EMPTY(fmi2SerializeFMUstate, ERROR)
EMPTY(fmi2DeSerializeFMUstate, ERROR) EMPTY(fmi2GetDirectionalDerivative, ERROR)
EMPTY(fmi2SetRealInputDerivatives, ERROR) EMPTY(fmi2GetRealOutputDerivatives, ERROR)
EMPTY(fmi2CancelStep, ERROR) EMPTY(fmi2GetStatus, ERROR) EMPTY(fmi2GetRealStatus, ERROR)
EMPTY(fmi2GetIntegerStatus, ERROR) EMPTY(fmi2GetBooleanStatus, ERROR)
EMPTY(fmi2GetStringStatus, ERROR)
