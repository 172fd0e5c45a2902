/* One tick of the boat in plain C: what trainer/core/update.py does in the standard configuration.

   Compact set, lagged rates, Adams' integration, filtered sea, autopilot by its own law, surfaces,
   tanks, air, pumps, casualties, triggers, holds. It works on the records of the trainer; records.h
   is written from their layout, with the constants that both share. Kept plain on purpose: this is
   what a good programmer writes, for the compiler to make fast. */

#include <string.h>

#include "elementary.h"
#include "records.h"
#include "casualties.h"
#include "autopilot.h"
#include "ballast.h"
#include "sea.h"
#include "surface.h"
#include "motion.h"

static int lost(const struct state *s)
{
    for (int i = 0; i < 12; i++)
        if (!(fabs(s->rates[i]) < FASTEST_RATE))
            return 1 + i;
    for (int i = 0; i < 12; i++)
        if (!(fabs(s->motion[i]) < (i < 6 ? FASTEST : FURTHEST)))
            return 13 + i;
    return 0;
}

int64_t update(
    const struct vessel *vessel, const struct compact *compact, const struct scheme *scheme,
    struct state *s, struct scratch *work)
{
    double h = scheme->h;
    memcpy(work->before, s, sizeof *s);

    fire_triggers(scheme, s);
    advance_casualties(s);
    autopilot(vessel, h, s, work->gains);
    if (s->held_tanks == 0.0)
        advance_ballast(vessel, h, s);
    advance_sea(vessel, h, work, s);
    for (int i = 0; i < 6; i++)
        work->external[i] = 0.0;
    wave_forces(vessel, work, s, work->external);
    surface_forces(vessel, s, work->external);
    buoyancy_forces(vessel, s, work->external);
    double x = s->x, y = s->y, z = s->z;
    cast_off(s);
    forces(compact, scheme->trig, s, work->force);
    if (compact->extended != 0.0)
        further_forces(compact, s, work->force);
    int off_centre = is_off_centre(compact, s);
    if (off_centre)
        off_centre_forces(compact, scheme->trig, s, work->force);
    add_external(compact, work->external, work->force);
    if (off_centre)
        lagged_off_centre(compact, work->force, s);
    else
        lagged(compact, work->force, s);
    kinematics(scheme->trig, s);
    adams(scheme, s);
    make_fast(x, y, z, s);
    move_surfaces(vessel, h, s);
    answer_telegraph(vessel, h, s);
    s->tick += 1.0;

    int failed = lost(s);
    if (failed)
        memcpy(s, work->before, sizeof *s);
    return failed;
}

int64_t take_ticks(
    const struct vessel *vessel, const struct compact *compact, const struct scheme *scheme,
    int64_t count, struct state *state, struct scratch *scratch)
{
    int64_t status = 0;
    for (int64_t i = 0; i < count; i++)
        status = update(vessel, compact, scheme, state, scratch);
    return status;
}
