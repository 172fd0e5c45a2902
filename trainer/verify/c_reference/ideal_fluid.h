/* Products of velocities in an ideal fluid: trainer/core/ideal_fluid.py. */

static void add_ideal_fluid(
    const struct vessel *c, double dry, const struct state *s, double *force)
{
    double u = s->u, v = s->v, w = s->w, p = s->p, q = s->q, r = s->r;
    double sail = dry * c->sail_mass;
    double m22 = c->m22 - sail, m24 = c->m24 + sail * c->strip_z;
    double m44 = c->m44 - sail * c->strip_z * c->strip_z, m26 = c->m26 - sail * c->strip_x;
    double along = c->m11 * u;
    double aside = m22 * v + m24 * p + m26 * r;
    double down = c->m33 * w + c->m35 * q;
    double roll = m24 * v + m44 * p + c->m46 * r;
    double pitch = c->m35 * w + c->m55 * q;
    double yaw = m26 * v + c->m46 * p + c->m66 * r;
    force[0] += r * aside - q * down;
    force[1] += p * down - r * along;
    force[2] += q * along - p * aside;
    force[3] += r * pitch - q * yaw + w * aside - v * down;
    force[4] += p * yaw - r * roll + u * down - w * along;
    force[5] += q * roll - p * pitch + v * along - u * aside;
}
