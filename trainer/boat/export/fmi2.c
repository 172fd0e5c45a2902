/* The unit by FMI 2.0. */

#define FMI(name) fmi2##name
#define fmi2GetFMUState fmi2GetFMUstate
#define fmi2SetFMUState fmi2SetFMUstate
#define fmi2FreeFMUState fmi2FreeFMUstate
#define fmi2SerializedFMUStateSize fmi2SerializedFMUstateSize
#define fmi2SerializeFMUState fmi2SerializeFMUstate
#define fmi2DeserializeFMUState fmi2DeSerializeFMUstate
#define VALUE_COUNT
#define LOG(host, name, text)                                                                  \
    (host)->logger((host)->environment, name, ERROR, "logStatusError", "%s", text)

struct host {
    void (*logger)(void *, const char *, int, const char *, const char *, ...);
    void *not_used[3]; /* memory and asynchronous steps */
    void *environment;
};

#include "unit.c"

ACCESS(Real, double, REAL)
ACCESS(Integer, int, INTEGER)
ACCESS(Boolean, int, BOOLEAN)

SHOWN const char *fmi2GetTypesPlatform(void) { return "default"; }
SHOWN const char *fmi2GetVersion(void) { return "2.0"; }

SHOWN void *fmi2Instantiate(const char *name, int kind, const char *guid, const char *resources,
                            const struct host *host, int visible, int logging)
{
    return host ? make(host, name, kind == CO_SIMULATION ? guid : NULL, __func__) : NULL;
}

SHOWN int fmi2SetupExperiment(struct instance *boat, int has_tolerance, double tolerance,
                              double start, int has_stop, double stop)
{
    EXPECT(INSTANTIATED);
    return set_times(boat, start, has_stop, stop, __func__);
}

SHOWN int fmi2EnterInitializationMode(struct instance *boat)
{
    EXPECT(INSTANTIATED);
    boat->moment[PHASE] = INITIALIZING;
    return OK;
}

SHOWN int fmi2DoStep(struct instance *boat, double now, double step, int no_return)
{
    EXPECT(STEPPING);
    return sail(boat, now, step, __func__);
}

LACKING(fmi2GetString) LACKING(fmi2SetString) LACKING(fmi2CancelStep)
LACKING(fmi2GetDirectionalDerivative)
LACKING(fmi2SetRealInputDerivatives) LACKING(fmi2GetRealOutputDerivatives)
LACKING(fmi2GetStatus) LACKING(fmi2GetRealStatus) LACKING(fmi2GetIntegerStatus)
LACKING(fmi2GetBooleanStatus) LACKING(fmi2GetStringStatus)
