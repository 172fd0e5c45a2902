/* Rudder and planes that stall ahead: trainer/core/stall.py. */

static double incidence(const struct vessel *c, int surface, const struct state *s)
{
    double arm = c->stall_arm[surface];
    double flow = surface == RUDDER ? -(s->v + arm * s->r) : s->w - arm * s->q;
    return s->u * s->surface[surface] + flow;
}

static int is_stalled(const struct vessel *c, const struct state *s)
{
    if (s->u <= 0.0)
        return 0;
    int stalled = 0;
    for (int i = 0; i < 3; i++)
        stalled |= fabs(incidence(c, i, s)) > s->u * c->stall_ahead[i];
    return stalled;
}

static double lost_lift(const struct vessel *c, int surface, const struct state *s)
{
    double angle = incidence(c, surface, s), furthest = s->u * c->stall_ahead[surface];
    double beyond = most(angle - furthest, 0.0) + least(angle + furthest, 0.0);
    return (1.0 - c->stall_slope[surface]) * s->u * beyond;
}

static void write_stalled(
    const struct vessel *c, const double *outer, const struct state *s, double *out)
{
    double rudder = lost_lift(c, RUDDER, s);
    double stern = lost_lift(c, STERN, s), bow = lost_lift(c, BOW, s);
    out[0] = outer[0];
    out[1] = outer[1] - c->Y_dr * rudder;
    out[2] = outer[2] - c->Z_ds * stern - c->Z_db * bow;
    out[3] = outer[3] - c->K_dr * rudder;
    out[4] = outer[4] - c->M_ds * stern - c->M_db * bow;
    out[5] = outer[5] - c->N_dr * rudder;
}
