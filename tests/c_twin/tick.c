/* One tick of the boat in plain C: what trainer/core/update.py does in the standard configuration.

   Compact set and the wide one, Adams' integration, sea, the boat afloat, autopilot by its own law,
   surfaces, tanks, air, pumps, plant (no fire), casualties, triggers, holds. It works on the records of the trainer; records.h
   is written from their layout, with the constants that both share. Kept plain on purpose: this is
   what a good programmer writes, for the compiler to make fast. */

#include <string.h>

#include "records.h"
#include "elementary.h"
#include "casualties.h"
#include "plant.h"
#include "autopilot.h"
#include "suction.h"
#include "ballast.h"
#include "surface.h"
#include "surfaced.h"
#include "sea.h"
#include "waves.h"
#include "propulsion.h"
#include "motion.h"
#include "envelope.h"
#include "solve.h"
#include "rigid_body.h"
#include "crossflow.h"
#include "wide.h"
#include "stall.h"
#include "attitude.h"
#include "rates.h"
#include "integrators.h"

static int lost(const struct state *s)
{
    for (int i = 0; i < 12; i++)
        if (!(fabs(s->rates[i]) < MAX_RATE))
            return 1 + i;
    for (int i = 0; i < 12; i++)
        if (!(fabs(s->motion[i]) < (i < 6 ? MAX_SPEED : MAX_DISTANCE)))
            return 13 + i;
    return 0;
}

static void outside(const struct vessel *c, double h, const struct state *s, struct scratch *work)
{
    for (int i = 0; i < 6; i++)
        work->external[i] = 0.0;
    int near = is_near_surface(c, h, s);
    if (near || work->levels != 0.0)
        for (int i = 0; i < HULL_STATIONS; i++) {
            work->level[i] = work->rise[i] = 0.0;
            work->station[i] = c->station_x[i];
        }
    work->levels = near ? 1.0 : 0.0;
    wave_forces(c, work, s, work->external);
    surface_forces(c, s, work->external);
    add_compression(c, s, work->external);
    work->cut = near && is_cut(c, work, s) ? 1.0 : 0.0;
}

int64_t update(
    const struct vessel *vessel, const struct compact *compact, const struct scheme *scheme,
    struct state *s, struct scratch *work)
{
    double h = scheme->h;
    memcpy(work->before, s, sizeof *s);

    fire_triggers(scheme, s);
    advance_casualties(s);
    advance_plant(vessel, h, s);
    autopilot(vessel, h, s, work->gains);
    if (s->held_tanks == 0.0)
        advance_ballast(vessel, h, s);
    advance_sea(vessel, h, work, s);
    outside(vessel, h, s, work);
    double x = s->x, y = s->y, z = s->z;
    cast_off(s);
    advance(vessel, compact, scheme, s, work);
    make_fast(x, y, z, s);
    move_surfaces(vessel, h, s);
    answer_telegraph(vessel, h, s);
    s->tick += 1.0;
    s->validity = validity(vessel, s);

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
