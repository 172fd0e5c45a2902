/* The boat's own mass in turning axes, and its weight: trainer/core/rigid_body.py. */

static void body_forces(const struct vessel *c, const struct state *s, double *force)
{
    double p = s->p, q = s->q, r = s->r;
    double m = c->mass + (s->weight - c->weight) / c->g;
    double ahead = s->v * r - s->w * q, aside = s->w * p - s->u * r, down = s->u * q - s->v * p;
    double spin = p * s->x_g + q * s->y_g + r * s->z_g;
    double square = p * p + q * q + r * r;
    force[0] = m * (ahead + s->x_g * square - p * spin);
    force[1] = m * (aside + s->y_g * square - q * spin);
    force[2] = m * (down + s->z_g * square - r * spin);
    double roll = c->I_x * p - c->I_xy * q - c->I_xz * r;
    double pitch = c->I_y * q - c->I_xy * p - c->I_yz * r;
    double yaw = c->I_z * r - c->I_xz * p - c->I_yz * q;
    force[3] = m * (s->y_g * down - s->z_g * aside) + r * pitch - q * yaw;
    force[4] = m * (s->z_g * ahead - s->x_g * down) + p * yaw - r * roll;
    force[5] = m * (s->x_g * aside - s->y_g * ahead) + q * roll - p * pitch;
}

static void add_weight(const struct vessel *c, const struct state *s, double *force)
{
    double cos_th, sin_th, cos_phi, sin_phi;
    cosine_and_sine(s->theta, &cos_th, &sin_th);
    cosine_and_sine(s->phi, &cos_phi, &sin_phi);
    double down_x = -sin_th, down_y = cos_th * sin_phi, down_z = cos_th * cos_phi;
    double heavy = s->weight - c->buoyancy;
    double x = s->x_g * s->weight - c->x_b * c->buoyancy;
    double y = s->y_g * s->weight - c->y_b * c->buoyancy;
    double z = s->z_g * s->weight - c->z_b * c->buoyancy;
    force[0] += heavy * down_x;
    force[1] += heavy * down_y;
    force[2] += heavy * down_z;
    force[3] += y * down_z - z * down_y;
    force[4] += z * down_x - x * down_z;
    force[5] += x * down_y - y * down_x;
}
