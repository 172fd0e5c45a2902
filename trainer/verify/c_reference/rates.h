/* The twelve rates by the compact set, the surface, stall and the wide set: trainer/core/rates.py. */

static void rates(
    const struct vessel *vessel, const struct compact *compact, const struct scheme *how,
    struct state *s, struct scratch *work)
{
    const double *outer = work->external;
    if (how->envelope && is_near_surface(vessel, s)) {
        write_near(vessel, work, s);
        outer = work->near;
    }
    const double *felt = outer;
    if (how->envelope && is_stalled(vessel, s)) {
        write_stalled(vessel, outer, s, work->felt);
        felt = work->felt;
    }
    forces(compact, how->trig, s, work->force);
    if (compact->extended != 0.0)
        further_forces(compact, s, work->force);
    add_external(compact, felt, work->force);
    if (how->exact) {
        compact_inertia(compact, s, work->inertia);
        exact(work->inertia, work->force, work->system, s->rates);
    } else {
        lagged(compact, work->force, s);
    }
    if (how->envelope && wide_share(vessel, s) > 0.0)
        correct(vessel, s, work, outer);
    kinematics(how->trig, s);
}
