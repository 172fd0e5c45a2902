/* The loop of metronome.py in plain C, to tell what is the machine's own doing.
   Usage: control SECONDS STEP; prints p50, p99, p99.9 and maximum of its lateness [ns]. */
#define _GNU_SOURCE
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/prctl.h>
#include <time.h>

#define SPIN 300000 /* [ns] as trainer/session/time/pacer.py */

static int64_t now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return t.tv_sec * INT64_C(1000000000) + t.tv_nsec;
}

static int earlier(const void *a, const void *b)
{
    int64_t x = *(const int64_t *)a, y = *(const int64_t *)b;
    return (x > y) - (x < y);
}

int main(int count, char **words)
{
    if (count != 3)
        return 2;
    double step = atof(words[2]);
    int ticks = (int)(atof(words[1]) / step);
    int64_t *late = calloc(ticks, sizeof *late), start;
    if (ticks < 1 || !late)
        return 2;
    prctl(PR_SET_TIMERSLACK, 1, 0, 0, 0);
    start = now();
    for (int i = 0; i < ticks; i++) {
        int64_t due = start + (int64_t)(i * step * 1e9), early = due - SPIN;
        struct timespec until = {early / 1000000000, early % 1000000000};
        clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, NULL);
        while (now() < due)
            ;
        late[i] = now() - due;
    }
    qsort(late, ticks, sizeof *late, earlier);
    printf("%lld %lld %lld %lld\n", (long long)late[ticks / 2], (long long)late[ticks * 99LL / 100],
           (long long)late[ticks * 999LL / 1000], (long long)late[ticks - 1]);
    return 0;
}
