/* The unit by FMI 3.0. */

#include <stdbool.h>
#include <stddef.h>

#define FMI(name) fmi3##name
#define VALUE_COUNT , size_t value_count /* as many as references: all are single numbers */
#define LOG(host, name, text) (host)->logger((host)->environment, ERROR, "logStatusError", text)

struct host {
    void (*logger)(void *environment, int status, const char *category, const char *text);
    void *environment;
};

#include "unit.c"

ACCESS(Float64, double, REAL)
ACCESS(Int32, int, INTEGER)
ACCESS(Boolean, bool, BOOLEAN)

SHOWN const char *fmi3GetVersion(void) { return "3.0"; }

SHOWN void *fmi3InstantiateCoSimulation(
    const char *name, const char *token, const char *resources, bool visible, bool logging,
    bool events, bool early_return, const unsigned *intermediate, size_t intermediate_count,
    void *environment, void (*logger)(void *, int, const char *, const char *), void *update)
{
    struct host host = {logger, environment};
    if (!events && !intermediate_count)
        return make(&host, name, token, __func__);
    tell(&host, name ? name : "", "%s: no event mode and no intermediate variables", __func__);
    return NULL;
}

#define LACKING_INTERFACE(function)                                                            \
    SHOWN void *function(const char *name, const char *token, const char *resources,           \
                         bool visible, bool logging, void *environment,                        \
                         void (*logger)(void *, int, const char *, const char *))              \
    {                                                                                          \
        struct host host = {logger, environment};                                              \
        tell(&host, name ? name : "", "%s: none; this unit is for co-simulation", __func__);   \
        return NULL;                                                                           \
    }
LACKING_INTERFACE(fmi3InstantiateModelExchange)
LACKING_INTERFACE(fmi3InstantiateScheduledExecution)

SHOWN int fmi3EnterInitializationMode(struct instance *boat, bool has_tolerance, double tolerance,
                                      double start, bool has_stop, double stop)
{
    EXPECT(INSTANTIATED);
    if (set_times(boat, start, has_stop, stop, __func__) != OK)
        return ERROR;
    boat->moment[PHASE] = INITIALIZING;
    return OK;
}

SHOWN int fmi3DoStep(struct instance *boat, double now, double step, bool no_return, bool *event,
                     bool *terminate, bool *early, double *reached)
{
    EXPECT(STEPPING);
    int status = sail(boat, now, step, __func__);
    *event = *terminate = *early = false;
    *reached = time_of(boat);
    return status;
}

LACKING(fmi3GetFloat32) LACKING(fmi3GetInt8) LACKING(fmi3GetUInt8) LACKING(fmi3GetInt16)
LACKING(fmi3GetUInt16) LACKING(fmi3GetUInt32) LACKING(fmi3GetInt64) LACKING(fmi3GetUInt64)
LACKING(fmi3GetString) LACKING(fmi3GetBinary) LACKING(fmi3GetClock)
LACKING(fmi3SetFloat32) LACKING(fmi3SetInt8) LACKING(fmi3SetUInt8) LACKING(fmi3SetInt16)
LACKING(fmi3SetUInt16) LACKING(fmi3SetUInt32) LACKING(fmi3SetInt64) LACKING(fmi3SetUInt64)
LACKING(fmi3SetString) LACKING(fmi3SetBinary) LACKING(fmi3SetClock)
LACKING(fmi3GetNumberOfVariableDependencies) LACKING(fmi3GetVariableDependencies)
LACKING(fmi3GetDirectionalDerivative) LACKING(fmi3GetAdjointDerivative)
LACKING(fmi3EnterConfigurationMode) LACKING(fmi3ExitConfigurationMode)
LACKING(fmi3EnterEventMode) LACKING(fmi3EnterStepMode) LACKING(fmi3EnterContinuousTimeMode)
LACKING(fmi3EvaluateDiscreteStates) LACKING(fmi3UpdateDiscreteStates)
LACKING(fmi3GetIntervalDecimal) LACKING(fmi3GetIntervalFraction)
LACKING(fmi3SetIntervalDecimal) LACKING(fmi3SetIntervalFraction)
LACKING(fmi3GetShiftDecimal) LACKING(fmi3GetShiftFraction)
LACKING(fmi3SetShiftDecimal) LACKING(fmi3SetShiftFraction)
LACKING(fmi3CompletedIntegratorStep) LACKING(fmi3SetTime) LACKING(fmi3SetContinuousStates)
LACKING(fmi3GetContinuousStateDerivatives) LACKING(fmi3GetEventIndicators)
LACKING(fmi3GetContinuousStates) LACKING(fmi3GetNominalsOfContinuousStates)
LACKING(fmi3GetNumberOfEventIndicators) LACKING(fmi3GetNumberOfContinuousStates)
LACKING(fmi3GetOutputDerivatives) LACKING(fmi3ActivateModelPartition)
