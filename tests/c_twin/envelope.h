/* How far the motion is beyond the equations of 1969: trainer/core/envelope.py. */

static double cross_speed_squared(const struct vessel *c, const struct state *s)
{
    return s->v * s->v + s->w * s->w + c->cross_arm * (s->q * s->q + s->r * s->r);
}

static double wide_share(const struct vessel *c, const struct state *s)
{
    double cross = cross_speed_squared(c, s), square = s->u * s->u;
    if (s->u < 0.0)
        return 1.0;
    if (cross <= c->handover_from * square)
        return 0.0;
    if (cross >= c->handover_to * square)
        return 1.0;
    double x =
        (cross - c->handover_from * square) / ((c->handover_to - c->handover_from) * square);
    return x * x * (3.0 - 2.0 * x);
}

static int validity(const struct vessel *c, const struct state *s)
{
    double cross = cross_speed_squared(c, s), square = s->u * s->u;
    if (s->u < 0.0 || cross > c->handover_from * square)
        return OUTSIDE_RANGE;
    return cross > c->tested * square ? EXTRAPOLATED_RANGE : INSIDE_RANGE;
}

static int substeps(const struct vessel *c, double h, int afloat, const struct state *s)
{
    double phase = 0.0;
    if (c->u_c_ahead > 0.0)
        phase = s->u / (PROVED_TURN_RATIO * c->u_c_ahead);
    if (wide_share(c, s) > 0.0) {
        double speed = sqrt(s->u * s->u + cross_speed_squared(c, s));
        phase = most(phase, h * c->stiffness * speed / SUBSTEP_PHASE);
        phase = most(phase, h * c->still_mode / STILL_SUBSTEP);
    }
    if (afloat)
        phase = most(phase, h * c->surface_mode / SURFACE_SUBSTEP);
    return phase > 1.0 ? (int)least(ceil(phase - 1e-9), MOST_SUBSTEPS) : 1;
}
