/* A simulator of one unit, for any system: it loads a library, flies a script, and writes the state.

       cc -DVERSION=2 -o host fmu_host.c
       ./host LIBRARY TOKEN STATE < script

   A line of the script is a kind, a value reference and a value, of a variable that is set: r real,
   i whole, b true or false; or g, to go out of the initialization; or s, a count and a size, of
   steps; or k, its size in bytes and its time, for the state kept in the file STATE by an earlier
   run, to go on from. In the end the serialised state goes to that file, what is refused to
   standard output. */

#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>

#ifdef _WIN32
#include <windows.h>
#define OPEN(path) LoadLibraryA(path)
#define FIND(name) ((void *)GetProcAddress(library, name))
#else
#include <dlfcn.h>
#define OPEN(path) dlopen(path, RTLD_NOW | RTLD_LOCAL)
#define FIND(name) dlsym(library, name)
#endif

#if VERSION == 2
#define STATE_WORD "state"
#define DESERIALIZE_NAME "DeSerializeFMUstate"
#define REAL_WORD "Real"
#define INTEGER_WORD "Integer"
typedef int truth;
static void tell(void *host, const char *name, int status, const char *category, const char *form,
                 const char *text)
{
    printf("%s\n", text);
}
#else
#define STATE_WORD "State"
#define DESERIALIZE_NAME "DeserializeFMUState"
#define REAL_WORD "Float64"
#define INTEGER_WORD "Int32"
typedef bool truth;
static void tell(void *host, int status, const char *category, const char *text)
{
    printf("%s\n", text);
}
#endif
#define PREFIX_OF(version) "fmi" #version
#define PREFIX_BY(version) PREFIX_OF(version)
#define CALL(result, name, ...)                                                                \
    ((result (*)())find(PREFIX_BY(VERSION) name))(__VA_ARGS__)

static void *library;

static void *find(const char *name)
{
    void *function = FIND(name);
    if (!function) {
        printf("%s: not in the library\n", name);
        exit(2);
    }
    return function;
}

int main(int count, char **words)
{
    double now = 0.0, value;
    char kind;
    unsigned reference;
    void *kept = NULL;
    if (count != 4 || !(library = OPEN(words[1])))
        return 2;
#if VERSION == 2
    struct { void *logger, *not_used[3], *environment; } host = {tell};
    void *boat = CALL(void *, "Instantiate", "boat", 1, words[2], "", &host, 0, 0);
    if (!boat || CALL(int, "SetupExperiment", boat, 0, 0.0, 0.0, 0, 0.0) ||
        CALL(int, "EnterInitializationMode", boat))
        return 3;
#else
    void *boat = CALL(void *, "InstantiateCoSimulation", "boat", words[2], "", 0, 0, 0, 0, NULL,
                      (size_t)0, NULL, tell, NULL);
    if (!boat || CALL(int, "EnterInitializationMode", boat, 0, 0.0, 0.0, 0, 0.0))
        return 3;
#endif
    while (scanf(" %c %u %lf", &kind, &reference, &value) == 3) {
        int whole = (int)value, status = 0;
        truth truth_value = value != 0.0;
        size_t one = 1;
        if (kind == 'r')
            status = CALL(int, "Set" REAL_WORD, boat, &reference, one, &value, one);
        if (kind == 'i')
            status = CALL(int, "Set" INTEGER_WORD, boat, &reference, one, &whole, one);
        if (kind == 'b')
            status = CALL(int, "SetBoolean", boat, &reference, one, &truth_value, one);
        if (kind == 'g')
            status = CALL(int, "ExitInitializationMode", boat);
        if (kind == 'k') {
            char *bytes = malloc(reference);
            FILE *file = fopen(words[3], "rb");
            if (!bytes || !file || fread(bytes, 1, reference, file) != reference || fclose(file))
                return 7;
            status = CALL(int, DESERIALIZE_NAME, boat, bytes, (size_t)reference, &kept) ||
                     CALL(int, "SetFMU" STATE_WORD, boat, kept);
            now = value;
        }
        for (unsigned i = 0; kind == 's' && i < reference && !status; i++, now += value) {
#if VERSION == 2
            status = CALL(int, "DoStep", boat, now, value, 1);
#else
            bool flags[3];
            double reached;
            status = CALL(int, "DoStep", boat, now, value, 1, flags, flags + 1, flags + 2,
                          &reached);
#endif
        }
        if (status)
            return 4;
    }
    size_t size;
    if (CALL(int, "GetFMU" STATE_WORD, boat, &kept) ||
        CALL(int, "SerializedFMU" STATE_WORD "Size", boat, kept, &size))
        return 5;
    char *bytes = malloc(size);
    FILE *file = fopen(words[3], "wb");
    if (!bytes || !file || CALL(int, "SerializeFMU" STATE_WORD, boat, kept, bytes, size) ||
        fwrite(bytes, 1, size, file) != size || fclose(file))
        return 6;
    CALL(void, "FreeInstance", boat);
    return 0;
}
