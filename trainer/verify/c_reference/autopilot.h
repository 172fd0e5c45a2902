/* The autopilot with its own depth law: trainer/core/reference.py, autopilot.py. */

static double within(double value, double centre, double furthest)
{
    return clamped(value, centre - furthest, centre + furthest);
}

static double slewed_rate(double distance, double rate, double fastest, double gentlest, double h)
{
    double size = fabs(distance);
    double wanted = least(least(fastest, sqrt(gentlest * size)), size / (APPROACH * h));
    if (distance < 0.0)
        wanted = -wanted;
    return rate + clamped(wanted - rate, -gentlest * h, gentlest * h);
}

static double leash(const double *gains, int slew)
{
    if (gains[slew + 1] > 0.0)
        return LEASH * gains[slew] * gains[slew] / gains[slew + 1];
    return 0.0;
}

static void move_reference(
    int axis, double here, double h, const double *gains, struct state *s)
{
    int slew = DEPTH_SLEW + 2 * axis;
    double distance = s->ordered_place[axis] - s->reference[axis];
    s->reference_rate[axis] = slewed_rate(
        distance, s->reference_rate[axis], gains[slew], gains[slew + 1], h);
    double moved = s->reference[axis] + h * s->reference_rate[axis];
    s->reference[axis] = within(moved, here, leash(gains, slew));
}

static void slew_depth(double h, const double *gains, struct state *s)
{
    if (s->stern_by_hand != 0.0 && s->bow_by_hand != 0.0) {
        s->depth_reference = s->z;
        s->depth_reference_rate = s->zdot;
    } else
        move_reference(DEPTH, s->z, h, gains, s);
}

static void slew_course(double h, const double *gains, struct state *s)
{
    if (s->rudder_by_hand != 0.0) {
        s->psi_reference = s->psi;
        s->psi_reference_rate = s->r;
    } else
        move_reference(COURSE, s->psi, h, gains, s);
}

static void scheduled_gains(const struct vessel *c, double u, double *gains)
{
    int last = (int)c->gain_count - 1;
    int upper = 1;
    while (upper < last && c->gain_speed[upper] < u)
        upper++;
    const double *low = c->gain[upper - 1], *high = c->gain[upper];
    double share = (u - c->gain_speed[upper - 1]) / (c->gain_speed[upper] - c->gain_speed[upper - 1]);
    share = clamped(share, 0.0, 1.0);
    for (int i = 0; i < GAIN_COUNT; i++)
        gains[i] = low[i] + share * (high[i] - low[i]);
}

static double plane_law(const struct state *s, const double *gains, int first)
{
    double pitch_wanted = -s->depth_reference_rate / most(s->u, SLOWEST);
    return gains[first] * (s->depth_reference - s->z)
        + gains[first + 1] * (s->depth_reference_rate - s->zdot)
        + gains[first + 2] * (s->theta - pitch_wanted)
        + gains[first + 3] * s->q;
}

static double course_law(const struct state *s, const double *gains)
{
    return gains[RUDDER_GAINS] * (s->psi_reference - s->psi)
        + gains[RUDDER_GAINS + 1] * (s->psi_reference_rate - s->r)
        + gains[RUDDER_GAINS + 2] * s->v;
}

static void stand_by(struct state *s, int surface, double law, int settled)
{
    double trim = s->surface[surface] - law;
    if (settled && fabs(s->command[surface] - s->surface[surface]) < STANDS)
        s->integral[surface] = trim;
    s->handover[surface] = trim - s->integral[surface];
}

static void steer(const struct vessel *c, struct state *s, int surface, double law, double step)
{
    double limit = c->limit[surface];
    double angle = law + s->integral[surface] + s->handover[surface];
    if (!(angle > limit && step > 0.0) && !(angle < -limit && step < 0.0))
        s->integral[surface] += step;
    s->command[surface] = within(law + s->integral[surface] + s->handover[surface], 0.0, limit);
}

static void fade(const struct vessel *c, double h, struct state *s)
{
    double left = exponential(-h * most(s->u, SLOWEST) / (HANDOVER * c->ell));
    for (int surface = 0; surface < 3; surface++)
        if (s->by_hand[surface] == 0.0)
            s->handover[surface] *= left;
}

static int is_level(const double *gains, const struct state *s)
{
    double pitch_rate = SETTLED * gains[DEPTH_SLEW + 1] / most(s->u, SLOWEST);
    return fabs(s->zdot) < SETTLED * gains[DEPTH_SLEW] && fabs(s->q) < pitch_rate;
}

static double depth_error(const double *gains, const struct state *s)
{
    double error = s->depth_reference - s->z;
    int learning;
    if (fabs(error) > FAR * leash(gains, DEPTH_SLEW))
        learning = fabs(s->zdot) < FAR * gains[DEPTH_SLEW];
    else
        learning = fabs(s->depth_reference_rate) < SETTLED * gains[DEPTH_SLEW];
    return learning ? error : 0.0;
}

static void keep_plane(
    const struct vessel *c, double h, const double *gains, struct state *s, int surface,
    double lasting)
{
    int first = PLANE_GAINS * (surface - STERN);
    double law = plane_law(s, gains, first);
    if (s->by_hand[surface] != 0.0) {
        s->command[surface] = s->ordered[surface];
        stand_by(s, surface, law, is_level(gains, s));
    } else {
        double error = depth_error(gains, s);
        steer(c, s, surface, law, h * (gains[first + 4] * error + gains[first + 5] * lasting));
    }
}

static void keep_depth(const struct vessel *c, double h, const double *gains, struct state *s)
{
    int able = fabs(s->command_s - s->delta_s) <= c->surface_rate * h;
    double lasting = 0.0;
    if (able && s->stern_by_hand == 0.0 && s->bow_by_hand == 0.0)
        lasting = s->delta_b;
    keep_plane(c, h, gains, s, STERN, lasting);
    keep_plane(c, h, gains, s, BOW, lasting);
}

static void keep_course(const struct vessel *c, double h, const double *gains, struct state *s)
{
    double law = course_law(s, gains);
    if (s->rudder_by_hand != 0.0) {
        s->command_r = s->ordered_r;
        stand_by(s, RUDDER, law, fabs(s->r) < c->turning_rate);
        return;
    }
    double step = 0.0;
    if (fabs(s->psi_reference_rate) < c->turning_rate)
        step = h * gains[RUDDER_GAINS + 3] * (s->psi_reference - s->psi);
    steer(c, s, RUDDER, law, step);
}

static void keep_speed(const struct vessel *c, double h, struct state *s)
{
    if (s->speed_by_hand != 0.0 || c->gain_count == 0.0) {
        s->command_u_c = s->ordered_u_c;
        return;
    }
    double error = s->ordered_speed - s->u;
    double step = h * (c->speed_integral * most(s->u, 0.0) / c->gain_speed[0] * error - s->udot);
    double wanted = s->ordered_speed + s->speed_trim + step;
    int possible = c->u_c_astern < wanted && wanted < c->u_c_ahead;
    if (possible && fabs(s->r) < c->turning_rate && fabs(error) < SPEED_BAND)
        s->speed_trim += step;
    s->command_u_c = clamped(s->ordered_speed + s->speed_trim, c->u_c_astern, c->u_c_ahead);
}

static void hold_commands(const double *gains, struct state *s)
{
    if (s->speed_by_hand != 0.0)
        s->command_u_c = s->ordered_u_c;
    for (int surface = 0; surface < 3; surface++)
        if (s->by_hand[surface] != 0.0)
            s->command[surface] = s->ordered[surface];
    stand_by(s, RUDDER, course_law(s, gains), 0);
    stand_by(s, STERN, plane_law(s, gains, 0), 0);
    stand_by(s, BOW, plane_law(s, gains, PLANE_GAINS), 0);
}

static void autopilot(const struct vessel *c, double h, struct state *s, double *gains)
{
    if (c->gain_count > 0.0)
        scheduled_gains(c, s->u, gains);
    slew_depth(h, gains, s);
    slew_course(h, gains, s);
    if (slot_of(AUTOPILOT_FAILED, s) >= 0) {
        hold_commands(gains, s);
        return;
    }
    keep_depth(c, h, gains, s);
    keep_course(c, h, gains, s);
    fade(c, h, s);
    keep_speed(c, h, s);
}
