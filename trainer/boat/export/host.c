/* A host in plain C: the boat turns, dives and slows down, and each tick is a row of CSV.

       cc -O2 -ffp-contract=off -o host host.c trainer_core.o
       ./host 7200 end.bin > run.csv

   The last state, to the bit, goes into the file named second. */

#include <stdio.h>
#include <stdlib.h>

#include "trainer_core.h"

static const double DEGREE = 3.14159265358979323846 / 180.0;

/* Orders are numbers written into the state before the tick that they are for. */
static void give_orders(long tick, struct trainer_state *s)
{
    if (tick == 60) {
        s->ordered_r = -15.0 * DEGREE;
        s->rudder_by_hand = 1.0;
    }
    if (tick == 600) {
        s->ordered_depth = 90.0;
        s->stern_by_hand = s->bow_by_hand = 0.0;
    }
    if (tick == 1800) {
        s->ordered_u_c = 3.0;
        s->speed_by_hand = 1.0;
    }
}

static void print_row(const struct trainer_state *s)
{
    printf("%.0f,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g\n", s->tick, s->tick * TRAINER_STEP_S,
           s->x, s->y, s->z, s->psi, s->theta, s->u);
}

static int keep(const char *path, const struct trainer_state *s)
{
    FILE *file = fopen(path, "wb");
    if (!file)
        return 1;
    size_t written = fwrite(s, sizeof *s, 1, file);
    return fclose(file) != 0 || written != 1;
}

int main(int count, char **words)
{
    static struct trainer_scratch scratch;
    struct trainer_state state = trainer_start;
    long ticks = count > 1 ? atol(words[1]) : 120;

    puts("tick,t,x,y,z,psi,theta,u");
    print_row(&state);
    for (long tick = 0; tick < ticks; tick++) {
        give_orders(tick, &state);
        int status = trainer_tick(&trainer_vessel, &trainer_compact, &state, &scratch);
        if (status) {
            fprintf(stderr, "host: tick %ld failed with status %d\n", tick, status);
            return 1;
        }
        print_row(&state);
    }
    if (count > 2 && keep(words[2], &state)) {
        fprintf(stderr, "host: cannot write %s\n", words[2]);
        return 1;
    }
    return 0;
}
