/* Drag of the flow across the boat, by strips: trainer/core/crossflow.py. */

static void add_hull_strips(const struct vessel *c, const struct state *s, double *force)
{
    for (int i = 0; i < HULL_STATIONS; i++) {
        double x = c->station_x[i];
        double aside = s->v + x * s->r, down = s->w - x * s->q;
        double speed = sqrt(aside * aside + down * down);
        double lateral = -c->crossflow_Y[i] * speed * aside;
        double normal = -c->crossflow_Z[i] * speed * down;
        force[1] += lateral;
        force[2] += normal;
        force[4] -= x * normal;
        force[5] += x * lateral;
    }
}

static void add_tail_and_sail(
    const struct vessel *c, const struct state *s, double *force)
{
    double aside = s->v + c->tail_x * s->r, down = s->w - c->tail_x * s->q;
    double lateral = -c->tail_Y * fabs(aside) * aside, normal = -c->tail_Z * fabs(down) * down;
    force[1] += lateral;
    force[2] += normal;
    force[4] -= c->tail_x * normal;
    force[5] += c->tail_x * lateral;
    aside = s->v + c->strip_x * s->r - c->strip_z * s->p;
    lateral = -c->strip_Y * sqrt(aside * aside + s->w * s->w) * aside;
    force[1] += lateral;
    force[3] -= c->strip_z * lateral;
    force[5] += c->strip_x * lateral;
}
