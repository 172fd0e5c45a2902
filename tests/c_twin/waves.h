/* What waves do to the hull and to the water along it: trainer/core/sea/forces.py. */

static double tapered(const struct vessel *c, const struct state *s)
{
    if (s->sea_taper == 0.0 || c->diameter <= 0.0)
        return 1.0;
    double t = least(most(s->z / c->diameter - TAPER[0], 0.0) / (TAPER[1] - TAPER[0]), 1.0);
    return 1.0 - t * t * (3.0 - 2.0 * t);
}

static double kept(int row)
{
    double t = most(row - LAST_TRUE, 0.0) / (STRIP_ROWS - LAST_TRUE);
    return 1.0 - t * t * (3.0 - 2.0 * t);
}

static void prepare_strips(const struct vessel *c, struct scratch *work)
{
    int same = 0;
    for (int i = 0; i < 4; i++)
        for (int strip = 0; strip < STRIP_COUNT; strip++)
            same += work->strips_of[i][strip] == c->strips[i][strip];
    if (same == 4 * STRIP_COUNT)
        return;
    memcpy(work->strips_of, c->strips, sizeof c->strips);
    for (int row = 0; row <= STRIP_ROWS; row++) {
        double left = kept(row), (*sums)[SUM_NUMBERS] = work->strip_sums[row];
        memset(sums, 0, sizeof work->strip_sums[row]);
        for (int strip = 0; strip < STRIP_COUNT; strip++) {
            double x = c->strips[0][strip], turn_cos, turn_sin;
            cosine_and_sine(row / ROWS_PER_TURN * x, &turn_cos, &turn_sin);
            for (int kind = 0; kind < 3; kind++) {
                double share = left * c->strips[1 + kind][strip];
                sums[kind][0] += share * turn_cos;
                sums[kind][1] += share * turn_sin;
                sums[kind][2] += share * x * turn_cos;
                sums[kind][3] += share * x * turn_sin;
            }
        }
    }
}

/* the strips' sums of one kind at the present wave number */
struct sums { double heave, surge, pitch, yaw; };

static struct sums at_strips(const struct scratch *work, int kind, double rise, double swing)
{
    double x = ROWS_PER_TURN * fabs(work->kappa), inside = 1.0, sum[SUM_NUMBERS];
    int row = STRIP_ROWS - 1;
    if (x < STRIP_ROWS) {
        row = (int)floor(x);
        inside = x - row;
    }
    for (int j = 0; j < SUM_NUMBERS; j++) {
        double before = work->strip_sums[row][kind][j];
        sum[j] = before + inside * (work->strip_sums[row + 1][kind][j] - before);
    }
    if (work->kappa < 0.0) {
        sum[1] = -sum[1];
        sum[3] = -sum[3];
    }
    struct sums found = {
        rise * sum[0] + swing * sum[1], swing * sum[0] - rise * sum[1],
        rise * sum[2] + swing * sum[3], swing * sum[2] - rise * sum[3]};
    return found;
}

static void raise_levels(struct scratch *work, double k, double a_cos, double a_sin)
{
    double omega = sqrt(work->g * k);
    for (int i = 0; i < HULL_STATIONS; i++) {
        double turn_cos, turn_sin;
        cosine_and_sine(k * work->station[i] * work->along, &turn_cos, &turn_sin);
        work->level[i] += a_cos * turn_cos + a_sin * turn_sin;
        work->rise[i] -= omega * (a_sin * turn_cos - a_cos * turn_sin);
    }
}

static void add_component(struct scratch *work, double omega, double rise, double swing)
{
    work->kappa = omega * omega / work->g * work->ell * work->along;
    struct sums hull = at_strips(work, 0, rise, swing);
    struct sums down = at_strips(work, 1, rise, swing);
    struct sums aside = at_strips(work, 2, rise, swing);
    double *pull = work->pull;
    pull[SURGE] -= work->along * hull.surge;
    pull[SWAY] -= work->across * hull.surge;
    pull[SWAY_ADDED] -= work->across * aside.surge;
    pull[HEAVE] += hull.heave;
    pull[HEAVE_ADDED] += down.heave;
    pull[PITCH] -= hull.pitch;
    pull[PITCH_ADDED] -= down.pitch;
    pull[YAW] -= work->across * hull.yaw;
    pull[YAW_ADDED] -= work->across * aside.yaw;
    pull[RISE] += rise;
    pull[SWING] += swing;
    pull[FLOW] += swing / omega;
}

static double filter_number(
    const struct vessel *c, double number, const struct scratch *work, const struct state *s)
{
    if (!is_shallow(c, s))
        return s->push_number;
    double covered = 2.0 * (work->depth + c->hull_axis) / c->hull_diameter - 1.0;
    return number + least(most(covered, 0.0), 1.0) * (s->push_number - number);
}

static void add_wave_filter(
    const struct vessel *c, double a, struct scratch *work, const struct state *s)
{
    double number = s->sea_omega * s->sea_omega / work->g;
    double size = a * work->g * number * exponential(-number * work->depth);
    double omega = sqrt(work->g * filter_number(c, number, work, s));
    add_component(work, omega, size * s->push_cos, size * s->push_sin);
    if (work->levels != 0.0)
        raise_levels(work, number, a * s->wave_cos, a * s->wave_sin);
}

static void add_filter_1969(struct scratch *work, double a, const struct state *s)
{
    double number = s->sea_omega * s->sea_omega / work->g;
    double size = a * work->g * number * exponential(-number * work->depth);
    add_component(work, s->sea_omega, size * s->sea_elevation, size * s->sea_quadrature);
    if (work->levels != 0.0)
        raise_levels(work, number, a * s->sea_elevation, a * s->sea_quadrature);
}

static void add_filters(const struct vessel *c, struct scratch *work, const struct state *s)
{
    cosine_and_sine(s->sea_direction - s->psi, &work->along, &work->across);
    double a = 0.25 * s->sea_height * sqrt(1.0 - s->sea_cosines);
    if (s->sea_1969 < 1.0)
        add_wave_filter(c, a * sqrt(1.0 - s->sea_1969), work, s);
    if (s->sea_1969 > 0.0)
        add_filter_1969(work, a * sqrt(s->sea_1969), s);
}

static void add_sum(struct scratch *work, const struct state *s)
{
    double height = 0.25 * s->sea_height * sqrt(s->sea_cosines);
    double chi_cos, chi_sin;
    cosine_and_sine(s->sea_direction - s->psi, &chi_cos, &chi_sin);
    for (int i = 0; i < SEA_COMPONENTS; i++) {
        double angle_cos = ANGLE_COS[i / BAND_COUNT], angle_sin = ANGLE_SIN[i / BAND_COUNT];
        work->along = chi_cos * angle_cos - chi_sin * angle_sin;
        work->across = chi_sin * angle_cos + chi_cos * angle_sin;
        double omega = s->sea_omega * work->relative[i];
        double number = omega * omega / work->g, a = height * work->amplitude[i];
        double size = a * work->g * number * exponential(-number * work->depth);
        double phase_cos, phase_sin;
        cosine_and_sine(phase(work, s, i), &phase_cos, &phase_sin);
        add_component(work, omega, size * phase_cos, size * phase_sin);
        if (work->levels != 0.0)
            raise_levels(work, number, a * phase_cos, a * phase_sin);
    }
}

static void push(
    const struct vessel *c, const struct scratch *work, double left, const struct state *s,
    double *force)
{
    const double *pull = work->pull;
    double displaced = left * c->buoyancy / c->g, arm = left * c->ell;
    double sway = left * c->Y_vdot, heave = left * c->Z_wdot;
    double swell = pull[RISE] * pull[RISE] + pull[SWING] * pull[SWING];
    double flow = left * most(s->u, 0.0) * pull[FLOW];
    force[0] += (displaced - left * c->X_udot) * pull[SURGE];
    force[1] += displaced * pull[SWAY] - sway * pull[SWAY_ADDED];
    force[2] += displaced * pull[HEAVE] - heave * pull[HEAVE_ADDED];
    force[2] -= (displaced - heave) * s->sea_suction * left * swell / c->g + c->Z_w * flow;
    force[4] += displaced * c->ell * pull[PITCH] - arm * c->Z_wdot * pull[PITCH_ADDED];
    force[4] -= c->M_w * flow;
    force[5] += displaced * c->ell * pull[YAW] - arm * c->Y_vdot * pull[YAW_ADDED];
    double mass = c->buoyancy / c->g;
    double aside = mass * pull[SWAY] - c->Y_vdot * pull[SWAY_ADDED];
    force[3] -= left * (c->K_vdot + c->z_b * mass) * aside / (mass - c->Y_vdot);
}

static void wave_forces(
    const struct vessel *c, struct scratch *work, const struct state *s, double *force)
{
    double left = tapered(c, s);
    if (s->sea_height == 0.0 || left == 0.0)
        return;
    prepare_strips(c, work);
    work->g = c->g;
    work->depth = most(s->z, 0.0);
    work->ell = c->ell;
    for (int i = 0; i < (int)(sizeof work->pull / sizeof *work->pull); i++)
        work->pull[i] = 0.0;
    if (s->sea_cosines < 1.0)
        add_filters(c, work, s);
    if (s->sea_cosines > 0.0)
        add_sum(work, s);
    if (work->levels != 0.0)
        left *= 1.0 - share_above(c, work, s);
    push(c, work, left, s, force);
}
