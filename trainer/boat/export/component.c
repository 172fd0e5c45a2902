/* A unit of FMI 3.0 as a component of WebAssembly, by the draft of its layered standard,
   fmi-ls-wasm: what the interface co-simulation passes goes to the functions of fmi3.c. A list that
   is passed has an address and a count, and is ours to free. An answer that is more than one number
   lies in `answer` until the next call: 0, or 1 for an error, then the value or the status. */

#include "fmi3.c"

#include <stdint.h>
#include <wasi/api.h>

#define FACE "fmi:fmi3/co-simulation@3.0.0"
#define KIND "co-simulation-instance"
#define ASKED(name) __attribute__((export_name(name)))
#define METHOD(name) ASKED(FACE "#[method]" KIND "." name)

typedef uint32_t word;

__attribute__((import_module("[export]" FACE), import_name("[resource-new]" KIND)))
word make_handle(struct instance *boat);
__attribute__((import_module("fmi:fmi3/callbacks@3.0.0"), import_name("log-message")))
void log_message(const char *name, size_t, int status, const char *category, size_t,
                 const char *text, size_t);

static _Alignas(8) unsigned char answer[32];
static void *listed; /* the list of the last answer */

/* The C library would ask the host for files if it wrote to any: a component has none. */
#define NO_FILE(call, ...)                                                                     \
    int32_t __imported_wasi_snapshot_preview1_fd_##call(int32_t file, ##__VA_ARGS__)           \
    {                                                                                          \
        return __WASI_ERRNO_BADF;                                                              \
    }
NO_FILE(close)
NO_FILE(seek, int64_t by, int32_t whence, int32_t place)
NO_FILE(write, int32_t parts, int32_t count, int32_t size)

/* Where the host writes what it passes. */
ASKED("cabi_realloc") void *make_room(void *room, size_t old, size_t align, size_t size)
{
    void *made = size ? realloc(room, size) : (void *)align;
    if (!made)
        __builtin_trap(); /* no memory: the host is told by the end of the component */
    return made;
}

static void drop(void *list, size_t count)
{
    if (count)
        free(list);
}

/* Return a text of the host as C has it. */
static char *text_of(char *bytes, size_t count)
{
    char *text = make_room(count ? bytes : NULL, count, 1, count + 1);
    text[count] = 0;
    return text;
}

static word put_word(int place, word value)
{
    memcpy(answer + place, &value, sizeof value);
    return (word)answer;
}

/* Answer that it failed; the status lies where a value would. */
static word refuse(int place, int status)
{
    answer[0] = 1;
    return put_word(place, (word)status);
}

static word answer_list(size_t count)
{
    answer[0] = 0;
    put_word(4, (word)listed);
    return put_word(8, (word)count);
}

static void *make_list(size_t size)
{
    free(listed);
    return listed = make_room(NULL, 0, 8, size + 1);
}

static void pass_on(void *name, int status, const char *category, const char *text)
{
    log_message(name, strlen(name), status, category, strlen(category), text, strlen(text));
}

ASKED(FACE "#[static]" KIND ".instantiate-co-simulation")
word instantiate(char *name, size_t name_size, char *token, size_t token_size, char *resources,
                 size_t resources_size, word visible, word logging, word events, word early_return,
                 unsigned *intermediate, size_t intermediate_count)
{
    name = text_of(name, name_size); /* kept as long as the boat, for what it tells */
    token = text_of(token, token_size);
    struct instance *boat = fmi3InstantiateCoSimulation(
        name, token, "", visible, logging, events, early_return, intermediate, intermediate_count,
        name, pass_on, NULL);
    drop(resources, resources_size);
    drop(intermediate, intermediate_count);
    free(token);
    answer[0] = boat != NULL;
    if (boat)
        return put_word(4, make_handle(boat));
    free(name);
    return (word)answer;
}

ASKED(FACE "#[dtor]" KIND) void free_boat(struct instance *boat)
{
    free(boat->host.environment);
    fmi3FreeInstance(boat);
}

ASKED("fmi:fmi3/common@3.0.0#get-version") word get_version(void)
{
    const char *version = fmi3GetVersion();
    put_word(4, (word)strlen(version));
    return put_word(0, (word)version);
}

METHOD("set-debug-logging") int set_logging(struct instance *boat, word on, void **names, size_t n)
{
    for (size_t i = 0; i < n; i++) /* each has an address and a size */
        drop(names[2 * i], (size_t)names[2 * i + 1]);
    drop(names, n);
    return fmi3SetDebugLogging(boat);
}

METHOD("enter-initialization-mode")
int enter(struct instance *boat, word has_tolerance, double tolerance, double start, word has_stop,
          double stop)
{
    return fmi3EnterInitializationMode(boat, has_tolerance, tolerance, start, has_stop, stop);
}

METHOD("do-step") word do_step(struct instance *boat, double now, double step, word no_return)
{
    bool event, terminate, early;
    double reached;
    int status = fmi3DoStep(boat, now, step, no_return, &event, &terminate, &early, &reached);
    if (status)
        return refuse(8, status);
    memset(answer, 0, sizeof answer); /* neither event, nor end, nor early return */
    memcpy(answer + 8, &reached, sizeof reached);
    return (word)answer;
}

METHOD("get-fmu-state") word get_state(struct instance *boat)
{
    memcpy(make_list(sizeof boat->now), &boat->now, sizeof boat->now);
    return answer_list(sizeof boat->now);
}

METHOD("set-fmu-state") int set_state(struct instance *boat, char *bytes, size_t size)
{
    struct saved *kept = NULL;
    int status = fmi3DeserializeFMUState(boat, bytes, size, &kept);
    if (!status)
        fmi3SetFMUState(boat, kept);
    free(kept);
    drop(bytes, size);
    return status;
}

#define PLAIN(name, function)                                                                  \
    METHOD(name) int plain_##function(struct instance *boat) { return function(boat); }
PLAIN("exit-initialization-mode", fmi3ExitInitializationMode)
PLAIN("terminate", fmi3Terminate)
PLAIN("reset", fmi3Reset)
PLAIN("enter-event-mode", fmi3EnterEventMode)
PLAIN("enter-step-mode", fmi3EnterStepMode)
PLAIN("enter-configuration-mode", fmi3EnterConfigurationMode)
PLAIN("exit-configuration-mode", fmi3ExitConfigurationMode)
PLAIN("evaluate-discrete-states", fmi3EvaluateDiscreteStates)

#define VALUES(name, type, number)                                                             \
    METHOD("get-" name) word get_##type(struct instance *boat, unsigned *references, size_t n)  \
    {                                                                                          \
        int status = fmi3Get##type(boat, references, n, make_list(n * sizeof(number)), n);     \
        drop(references, n);                                                                   \
        return status ? refuse(4, status) : answer_list(n);                                    \
    }                                                                                          \
    METHOD("set-" name)                                                                        \
    int set_##type(struct instance *boat, unsigned *references, size_t n, number *values, size_t m) \
    {                                                                                          \
        int status = n == m ? fmi3Set##type(boat, references, n, values, m)                    \
                            : REFUSE("%s: %zu values for %zu references", __func__, m, n);     \
        drop(references, n);                                                                   \
        drop(values, m);                                                                       \
        return status;                                                                         \
    }
VALUES("float64", Float64, double)
VALUES("int32", Int32, int)
VALUES("boolean", Boolean, bool)

/* What this unit has none of: an empty list may be asked for, and is given. */
#define GET_NONE(name, function)                                                               \
    METHOD(name) word none_##function(struct instance *boat, void *references, size_t n)       \
    {                                                                                          \
        drop(references, n);                                                                   \
        make_list(0);                                                                          \
        return n ? refuse(4, function(boat)) : answer_list(0);                                 \
    }
#define SET_NONE(name, function)                                                               \
    METHOD(name)                                                                               \
    int none_##function(struct instance *boat, void *references, size_t n, void *values, size_t m) \
    {                                                                                          \
        drop(references, n);                                                                   \
        drop(values, m);                                                                       \
        return n || m ? function(boat) : OK;                                                   \
    }
#define NO_VALUES(name, type)                                                                  \
    GET_NONE("get-" name, fmi3Get##type) SET_NONE("set-" name, fmi3Set##type)
NO_VALUES("float32", Float32) NO_VALUES("int8", Int8) NO_VALUES("uint8", UInt8)
NO_VALUES("int16", Int16) NO_VALUES("uint16", UInt16) NO_VALUES("uint32", UInt32)
NO_VALUES("int64", Int64) NO_VALUES("uint64", UInt64) NO_VALUES("string", String)
NO_VALUES("binary", Binary) NO_VALUES("clock", Clock)
NO_VALUES("interval-decimal", IntervalDecimal) NO_VALUES("interval-fraction", IntervalFraction)
NO_VALUES("shift-decimal", ShiftDecimal) NO_VALUES("shift-fraction", ShiftFraction)
GET_NONE("get-output-derivatives", fmi3GetOutputDerivatives)
LACKING(fmi3SetInputDerivatives)
SET_NONE("set-input-derivatives", fmi3SetInputDerivatives)

METHOD("update-discrete-states") word update_states(struct instance *boat)
{
    return refuse(8, fmi3UpdateDiscreteStates(boat));
}

METHOD("get-number-of-variable-dependencies") word count_dependencies(struct instance *boat, word v)
{
    return refuse(8, fmi3GetNumberOfVariableDependencies(boat));
}

METHOD("get-variable-dependencies") word get_dependencies(struct instance *boat, word v)
{
    return refuse(4, fmi3GetVariableDependencies(boat));
}

#define NO_DERIVATIVE(name, function)                                                          \
    METHOD(name)                                                                               \
    word none_##function(struct instance *boat, void *unknowns, size_t n, void *knowns,        \
                         size_t m, void *seed, size_t k)                                       \
    {                                                                                          \
        drop(unknowns, n);                                                                     \
        drop(knowns, m);                                                                       \
        drop(seed, k);                                                                         \
        return refuse(4, function(boat));                                                      \
    }
NO_DERIVATIVE("get-directional-derivative", fmi3GetDirectionalDerivative)
NO_DERIVATIVE("get-adjoint-derivative", fmi3GetAdjointDerivative)
