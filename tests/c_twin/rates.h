/* The twelve rates, by the compact set, surface, stall and the wide set: trainer/core/rates.py. */

static void compact_accelerations(
    const struct compact *compact, const struct scheme *how, struct state *s, struct scratch *work,
    const double *outer)
{
    forces(compact, how->trig, s, work->force);
    if (compact->extended != 0.0)
        further_forces(compact, s, work->force);
    if (compact->slipping != 0.0)
        slip_forces(compact, s, work->force);
    int off_centre = is_off_centre(compact, s);
    if (off_centre)
        off_centre_forces(compact, how->trig, s, work->force);
    add_external(compact, outer, work->force);
    if (!how->exact && !off_centre) {
        lagged(compact, work->force, s);
        return;
    }
    compact_inertia(compact, s, work->inertia);
    if (off_centre)
        off_centre_inertia(compact, s, work->inertia);
    if (how->exact)
        exact(work->inertia, work->force, work->system, s->rates);
    else
        sweep(work->inertia, work->force, s->rates);
}

static void rates(
    const struct vessel *vessel, const struct compact *compact, const struct scheme *how,
    struct state *s, struct scratch *work)
{
    const double *outer = work->external;
    if (how->envelope && is_shallow(vessel, s)) {
        write_near(vessel, work, s);
        outer = work->near;
    }
    const double *felt = outer;
    if (how->envelope && is_stalled(vessel, s)) {
        write_stalled(vessel, outer, s, work->felt);
        felt = work->felt;
    }
    compact_accelerations(compact, how, s, work, felt);
    if (how->envelope && wide_share(vessel, s) > 0.0)
        correct(vessel, s, work, outer);
    kinematics(how->trig, s);
}
