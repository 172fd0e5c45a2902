/* The hull at the surface, by station: trainer/core/surfaced.py. */

static int is_shallow(const struct vessel *c, const struct state *s)
{
    return s->z < c->surface_line + s->sea_height;
}

static int is_near_surface(const struct vessel *c, double h, const struct state *s)
{
    double pitch = fabs(s->theta);
    double room = s->z - c->station_reach * pitch - c->hull_reach - TROUGH_SHARE * s->sea_height;
    double rise = fabs(s->u) * pitch + fabs(s->v) + fabs(s->w)
        + c->station_reach * (fabs(s->q) + fabs(s->r));
    return is_shallow(c, s) && room < TRAVEL_SHARE * h * rise;
}

static double axis_depth(
    const struct vessel *c, int station, const struct scratch *work, const struct state *s)
{
    double cos_th, sin_th, cos_phi, sin_phi;
    cosine_and_sine(s->theta, &cos_th, &sin_th);
    cosine_and_sine(s->phi, &cos_phi, &sin_phi);
    double level = s->z + work->level[station];
    double across = c->hull_axis * cos_phi + c->y_b * sin_phi;
    return level - c->station_x[station] * sin_th + across * cos_th;
}

static double share_above(
    const struct vessel *c, const struct scratch *work, const struct state *s)
{
    double share = 0.0;
    for (int i = 0; i < HULL_STATIONS; i++) {
        double depth = axis_depth(c, i, work, s);
        share += c->station_share[i] * segment(0.5 - depth / c->hull_diameter);
    }
    return share;
}

static int is_cut(const struct vessel *c, const struct scratch *work, const struct state *s)
{
    for (int i = 0; i < HULL_STATIONS; i++)
        if (axis_depth(c, i, work, s) < 0.5 * c->hull_diameter)
            return 1;
    return 0;
}

static double dry_sail(const struct vessel *c, const struct state *s)
{
    if (c->sail_height <= 0.0 || !is_shallow(c, s)
        || s->z + s->eta_wave >= fabs(c->z_sail) + fabs(c->x_sail * s->theta))
        return 0.0;
    double cos_th, sin_th;
    cosine_and_sine(s->theta, &cos_th, &sin_th);
    double top =
        s->z + s->eta_wave - c->x_sail * sin_th + c->z_sail * cos_th * cosine(s->phi);
    return clamped(-top / c->sail_height, 0.0, 1.0);
}

static double sinking(const struct vessel *c, int station, const struct state *s)
{
    double x = c->station_x[station], z = c->hull_axis;
    double cos_th, sin_th, cos_phi, sin_phi;
    cosine_and_sine(s->theta, &cos_th, &sin_th);
    cosine_and_sine(s->phi, &cos_phi, &sin_phi);
    double aside = s->v + x * s->r - z * s->p, down = s->w - x * s->q;
    down += c->y_b * s->p;
    return (aside * sin_phi + down * cos_phi) * cos_th - (s->u + z * s->q - c->y_b * s->r) * sin_th;
}

static double station_damping(const struct vessel *c, int station, double chord)
{
    double share = c->station_share[station];
    double stiffness = share * c->buoyancy * 4.0 * chord / (M_PI * c->hull_diameter);
    return 2.0 * c->surface_damping * sqrt(stiffness * share * (c->mass + c->m33));
}

static void add_waterplane(
    const struct vessel *c, const struct scratch *work, const struct state *s, double *force)
{
    double heavy = 0.0, x = 0.0, above = 0.0;
    for (int i = 0; i < HULL_STATIONS; i++) {
        double depth = axis_depth(c, i, work, s) / c->hull_diameter;
        if (depth >= 0.5)
            continue;
        double share = segment(0.5 - depth);
        double down = c->station_share[i] * c->buoyancy * share;
        if (depth > -0.5) {
            double chord = sqrt(1.0 - 4.0 * depth * depth);
            double speed = sinking(c, i, s) + work->rise[i];
            down -= station_damping(c, i, chord) * speed;
        }
        above += c->station_share[i] * share;
        heavy += down;
        x += down * c->station_x[i];
    }
    if (above == 0.0)
        return;
    double cos_th, sin_th, cos_phi, sin_phi;
    cosine_and_sine(s->theta, &cos_th, &sin_th);
    cosine_and_sine(s->phi, &cos_phi, &sin_phi);
    double down_x = -sin_th, down_y = cos_th * sin_phi, down_z = cos_th * cos_phi;
    double z = heavy * c->hull_axis;
    double square = least(s->u * s->u, HUMP_FROUDE * HUMP_FROUDE * c->g * c->ell);
    force[0] += heavy * down_x;
    force[0] -= c->wave_drag * least(above / 0.05, 1.0) * square * square * s->u * fabs(s->u);
    force[1] += heavy * down_y;
    force[2] += heavy * down_z;
    force[3] -= z * down_y;
    force[4] += z * down_x - x * down_z;
    force[5] += x * down_y;
    force[3] += heavy * c->y_b * down_z;
    force[5] -= heavy * c->y_b * down_x;
}

static void take_off(double x, double z, double lateral, double *force)
{
    force[1] -= lateral;
    force[3] += z * lateral;
    force[5] -= x * lateral;
}

static void take_off_dry_sail(
    const struct vessel *c, const struct state *s, double *force)
{
    double dry = dry_sail(c, s);
    if (dry == 0.0)
        return;
    double ahead = s->u > 0.0 ? s->u : 0.0, cross = sqrt(s->v * s->v + s->w * s->w);
    double side = ahead * (c->Y_v * s->v + c->Y_r * s->r) + c->Y_vav * s->v * cross;
    double heeling = ahead * (c->K_v * s->v + c->K_r * s->r) + c->K_vav * s->v * cross;
    double along = s->v + c->lift_x * s->r;
    double lift = c->sail_lift * ahead * along;
    take_off(
        c->lift_x, c->lift_z, -dry * c->sail_lift * fabs(s->u) * (along - c->lift_z * s->p), force);
    double aside = s->v + c->strip_x * s->r;
    double drag = c->strip_Y * sqrt(aside * aside + s->w * s->w) * aside;
    aside -= c->strip_z * s->p;
    double by_roll = c->strip_Y * sqrt(aside * aside + s->w * s->w) * aside;
    take_off(c->strip_x, c->strip_z, -dry * by_roll, force);
    side += lift + drag;
    heeling -= c->lift_z * lift + c->strip_z * drag;
    force[3] -= dry * (heeling + c->hull_axis * side);
}

static void write_near(const struct vessel *c, struct scratch *work, const struct state *s)
{
    for (int i = 0; i < 6; i++)
        work->near[i] = work->external[i];
    if (is_near_surface(c, 0.0, s))
        add_waterplane(c, work, s, work->near);
    take_off_dry_sail(c, s, work->near);
}
