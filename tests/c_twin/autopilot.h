/* The autopilot with its own depth law: trainer/core/autopilot/. */

static double within(double value, double centre, double furthest)
{
    return clamped(value, centre - furthest, centre + furthest);
}

static double slewed_rate(double distance, double rate, double fastest, double gentlest, double h)
{
    double size = fabs(distance);
    double wanted = least(least(fastest, sqrt(gentlest * size)), size / (APPROACH_TICKS * h));
    if (distance < 0.0)
        wanted = -wanted;
    return rate + clamped(wanted - rate, -gentlest * h, gentlest * h);
}

static double leash(const double *gains, int slew)
{
    double rate = gains[slew + SLEW_RATE], acceleration = gains[slew + SLEW_ACCELERATION];
    if (acceleration > 0.0)
        return LEASH_SHARE * rate * rate / acceleration;
    return 0.0;
}

static void move_reference(
    int axis, double here, double h, const double *gains, struct state *s)
{
    int slew = DEPTH_SLEW + SLEW_COUNT * axis;
    double distance = s->ordered_place[axis] - s->reference[axis];
    s->reference_rate[axis] = slewed_rate(
        distance, s->reference_rate[axis], gains[slew + SLEW_RATE],
        gains[slew + SLEW_ACCELERATION], h);
    double moved = s->reference[axis] + h * s->reference_rate[axis];
    s->reference[axis] = within(moved, here, leash(gains, slew));
}

static void follow_boat(
    int axis, double here, double rate, const double *gains, struct state *s)
{
    s->reference[axis] = here;
    double fastest = gains[DEPTH_SLEW + SLEW_COUNT * axis + SLEW_RATE];
    s->reference_rate[axis] = within(rate, 0.0, fastest);
}

static void slew_depth(double h, const double *gains, struct state *s)
{
    if ((s->stern_by_hand != 0.0 && s->bow_by_hand != 0.0) || s->ascent != 0.0)
        follow_boat(DEPTH_AXIS, s->z, s->zdot, gains, s);
    else
        move_reference(DEPTH_AXIS, s->z, h, gains, s);
}

/* a turn astern takes longer */
static void slow_turns(double *gains, struct state *s)
{
    double *slew = gains + DEPTH_SLEW + SLEW_COUNT;
    slew[SLEW_RATE] *= ASTERN_PACE;
    slew[SLEW_ACCELERATION] *= ASTERN_PACE * ASTERN_PACE;
    s->psi_reference_rate = within(s->psi_reference_rate, 0.0, slew[SLEW_RATE]);
}

static void slew_course(double h, const double *gains, struct state *s)
{
    if (s->rudder_by_hand != 0.0)
        follow_boat(COURSE_AXIS, s->psi, s->r, gains, s);
    else
        move_reference(COURSE_AXIS, s->psi, h, gains, s);
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
    double pitch_wanted = -s->depth_reference_rate / most(s->u, MIN_DIVISOR_SPEED);
    return gains[first + DEPTH_GAIN] * (s->depth_reference - s->z)
        + gains[first + DEPTH_RATE_GAIN] * (s->depth_reference_rate - s->zdot)
        + gains[first + PITCH_GAIN] * (s->theta - pitch_wanted)
        + gains[first + PITCH_RATE_GAIN] * s->q;
}

static double course_law(const struct state *s, const double *gains)
{
    return gains[COURSE_GAIN] * (s->psi_reference - s->psi)
        + gains[YAW_RATE_GAIN] * (s->psi_reference_rate - s->r)
        + gains[SWAY_GAIN] * s->v;
}

static void stand_by(struct state *s, int surface, double law, int settled)
{
    double trim = s->surface[surface] - law;
    if (settled && fabs(s->command[surface] - s->surface[surface]) < ARRIVAL_TOLERANCE)
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
    double left = exponential(-h * most(s->u, MIN_DIVISOR_SPEED) / (HANDOVER_LENGTHS * c->ell));
    for (int surface = 0; surface < 3; surface++)
        if (s->by_hand[surface] == 0.0)
            s->handover[surface] *= left;
}

static int is_level(const double *gains, const struct state *s)
{
    double pitch_rate = LEVEL_SHARE * gains[DEPTH_SLEW + SLEW_ACCELERATION] / most(s->u, MIN_DIVISOR_SPEED);
    return fabs(s->zdot) < LEVEL_SHARE * gains[DEPTH_SLEW + SLEW_RATE] && fabs(s->q) < pitch_rate;
}

static double depth_error(const double *gains, const struct state *s)
{
    double error = s->depth_reference - s->z;
    int learning;
    if (fabs(error) > FAR_SHARE * leash(gains, DEPTH_SLEW))
        learning = fabs(s->zdot) < FAR_SHARE * gains[DEPTH_SLEW + SLEW_RATE];
    else
        learning = fabs(s->depth_reference_rate) < LEVEL_SHARE * gains[DEPTH_SLEW + SLEW_RATE];
    return learning ? error : 0.0;
}

static double between_limits(double ratio, const double *factor)
{
    double upper = (ratio / LIMITS[0] - 1.0 + LIMIT_BLEND) / (2.0 * LIMIT_BLEND);
    double lower = (ratio / LIMITS[1] - 1.0 + LIMIT_BLEND) / (2.0 * LIMIT_BLEND);
    double rise = clamped(upper, 0.0, 1.0) * (factor[0] - factor[1]);
    return factor[2] + clamped(lower, 0.0, 1.0) * (factor[1] - factor[2]) + rise;
}

static void count_waves(double h, double band, struct state *s)
{
    s->wave_since += h;
    if (s->wave_band < 0.0 && 0.0 <= band && s->wave_since >= MIN_CROSSING_S) {
        if (s->wave_count > 0.0)
            s->wave_period += (s->wave_since - s->wave_period) / s->wave_count;
        s->wave_count = least(s->wave_count + 1.0, AVERAGED_WAVES);
        s->wave_since = 0.0;
    }
}

static int are_counted(const struct state *s)
{
    return s->wave_count >= AVERAGED_WAVES && s->wave_since < MAX_QUIET_PERIODS * s->wave_period;
}

static double frequency_met(const struct state *s)
{
    return 6.283185307179586 / s->wave_period;
}

static double frequency_ratio(const struct vessel *c, const double *gains, const struct state *s)
{
    double pace = fabs(c->M_ds) * s->u * s->u * fabs(gains[STERN_GAINS + PITCH_RATE_GAIN]) / (c->I_y - c->M_qdot);
    return frequency_met(s) / most(pace, 1e-6);
}

static void sense_waves(
    const struct vessel *c, double h, const double *gains, struct state *s)
{
    if (s->sea_height == 0.0 && s->wave_share == 0.0) {
        s->wave_count = s->wave_power = 0.0;
        return;
    }
    s->wave_slow += h * SLOW_PITCH / (1.0 + h * SLOW_PITCH) * (s->zdot - s->wave_slow);
    double band = s->zdot - s->wave_slow;
    count_waves(h, band, s);
    s->wave_band = band;
    s->wave_power += h / (WAVE_MEMORY + h) * (band * band - s->wave_power);
    int there = s->wave_power > FELT_DEPTH_RATE * FELT_DEPTH_RATE && are_counted(s)
        && frequency_ratio(c, gains, s) > LEAST_RATIO;
    s->wave_share = clamped(s->wave_share + (there ? h / FADE_TIME_S : -h / FADE_TIME_S), 0.0, 1.0);
}

struct section { double b0, b1, b2, a1, a2; };

static double half_tangent(double omega, double h)
{
    double cos_half, sin_half;
    cosine_and_sine(least(0.5 * omega * h, LONGEST_STEP), &cos_half, &sin_half);
    return sin_half / cos_half;
}

static struct section notch_at(double omega, double h, double zeros, double poles)
{
    double c = half_tangent(omega, h);
    double square = c * c, a0 = 1.0 + 2.0 * poles * c + square;
    double middle = 2.0 * (square - 1.0) / a0;
    struct section it = {
        (1.0 + 2.0 * zeros * c + square) / a0, middle, (1.0 - 2.0 * zeros * c + square) / a0,
        middle, (1.0 - 2.0 * poles * c + square) / a0,
    };
    return it;
}

static struct section low_pass(double omega, double h, double damping)
{
    double c = half_tangent(omega, h);
    double square = c * c, a0 = 1.0 + 2.0 * damping * c + square, gain = square / a0;
    struct section it = {
        gain, 2.0 * gain, gain, 2.0 * (square - 1.0) / a0, (1.0 - 2.0 * damping * c + square) / a0,
    };
    return it;
}

static double past(struct section it, double x, int fresh, double *kept)
{
    if (fresh) {
        kept[EARLY] = (1.0 - it.b0) * x;
        kept[LATE] = (it.b2 - it.a2) * x;
    }
    double y = it.b0 * x + kept[EARLY];
    kept[EARLY] = it.b1 * x - it.a1 * y + kept[LATE];
    kept[LATE] = it.b2 * x - it.a2 * y;
    kept[OUTPUT] = y;
    return y;
}

static double law_in_waves(
    const struct vessel *c, double h, const double *gains, struct state *s, int surface,
    double law)
{
    if (s->wave_share == 0.0)
        return law;
    int first = STERN_GAINS + PLANE_COUNT * (surface - STERN), fresh = s->wave_share <= h / FADE_TIME_S;
    double *kept = s->notch + NOTCH_SIZE * (surface - STERN);
    double ratio = frequency_ratio(c, gains, s);
    double damping = gains[first + PITCH_RATE_GAIN] * s->q;
    double x = between_limits(ratio, SOFT) * (law - damping)
        + between_limits(ratio, DAMPED) * damping;
    double omega = frequency_met(s);
    x = past(notch_at(LOWER_NOTCH * omega, h, PLANE_ZEROS, PLANE_POLES), x, fresh, kept);
    x = past(notch_at(UPPER_NOTCH * omega, h, PLANE_ZEROS, PLANE_POLES), x, fresh, kept + SECTION_SIZE);
    return law + s->wave_share * (x - law);
}

static double learning_in_waves(
    const struct vessel *c, const double *gains, const struct state *s)
{
    if (s->wave_share == 0.0)
        return 1.0;
    double factor = between_limits(frequency_ratio(c, gains, s), LEARNT);
    return 1.0 + s->wave_share * (factor - 1.0);
}

static double law_astern(const struct state *s, const double *gains, int surface)
{
    int first = STERN_GAINS + PLANE_COUNT * (surface - STERN);
    if (surface == STERN)
        return -gains[first + PITCH_GAIN] * s->theta - gains[first + PITCH_RATE_GAIN] * s->q;
    double depth = gains[first + DEPTH_GAIN] * (s->depth_reference - s->z);
    return -depth - gains[first + DEPTH_RATE_GAIN] * (s->depth_reference_rate - s->zdot);
}

static void go_astern(
    const struct vessel *c, const double *gains, struct state *s, int surface)
{
    double share = clamped((-s->u - LEAST_ASTERN) / (SURE_ASTERN - LEAST_ASTERN), 0.0, 1.0);
    double angle = within(law_astern(s, gains, surface), 0.0, c->limit[surface]);
    s->command[surface] = share * angle;
}

static void keep_plane(
    const struct vessel *c, double h, const double *gains, struct state *s, int surface,
    double lasting)
{
    int first = STERN_GAINS + PLANE_COUNT * (surface - STERN);
    double law = law_in_waves(c, h, gains, s, surface, plane_law(s, gains, first));
    if (s->by_hand[surface] != 0.0) {
        s->command[surface] = s->ordered[surface];
        stand_by(s, surface, law, is_level(gains, s));
    } else if (s->u < ASTERN_SPEED) {
        go_astern(c, gains, s, surface);
        stand_by(s, surface, law, 0);
    } else {
        double step = h * gains[first + INTEGRAL_GAIN] * depth_error(gains, s);
        step *= learning_in_waves(c, gains, s);
        steer(c, s, surface, law, step + h * gains[first + RELIEF_GAIN] * lasting);
    }
}

static int is_turning(const struct vessel *c, const struct state *s)
{
    double rate = s->rudder_by_hand != 0.0 ? s->turn_followed : s->psi_reference_rate;
    return fabs(rate) >= c->turning_rate;
}

static void keep_depth(const struct vessel *c, double h, const double *gains, struct state *s)
{
    int able = fabs(s->command_s - s->delta_s) <= c->surface_rate * h;
    int automatic = s->stern_by_hand == 0.0 && s->bow_by_hand == 0.0;
    double lasting = able && automatic && is_turning(c, s) ? s->delta_b : 0.0;
    keep_plane(c, h, gains, s, STERN, lasting);
    keep_plane(c, h, gains, s, BOW, lasting);
}

static int is_blown(const struct state *s)
{
    return s->blow_forward == EMERGENCY_OPENING || s->blow_mid == EMERGENCY_OPENING || s->blow_aft == EMERGENCY_OPENING;
}

static int is_surfacing(const struct state *s)
{
    return s->ordered_depth == 0.0 && most(most(s->blow_forward, s->blow_mid), s->blow_aft) > 0.0;
}

static void watch_blow(const struct vessel *c, struct state *s)
{
    int planes = s->stern_by_hand == 0.0 || s->bow_by_hand == 0.0;
    int begins = is_surfacing(s) && s->ascent == 0.0;
    if (!(planes && c->gain_count > 0.0))
        s->ascent = 0.0;
    else if (begins || (is_blown(s) && s->ascent != ASCENT_RISING)) {
        s->ascent = ASCENT_RISING;
        s->ascent_pitch = s->theta;
        s->ascent_quiet = s->ordered_depth = 0.0;
    }
}

static void lay_amidships(struct state *s)
{
    s->command_s = s->stern_by_hand != 0.0 ? s->ordered_s : 0.0;
    s->command_b = s->bow_by_hand != 0.0 ? s->ordered_b : 0.0;
}

static void hold_bubble(const struct vessel *c, double h, const double *gains, struct state *s)
{
    double wanted = 0.0;
    if (is_blown(s))
        wanted = ASCENT_BUBBLE + EXTRA_BUBBLE * clamped((s->u - FAST[0]) / (FAST[1] - FAST[0]), 0.0, 1.0);
    s->ascent_pitch += clamped(wanted - s->ascent_pitch, -BUBBLE_RATE * h, BUBBLE_RATE * h);
    double angle = most(MIN_PITCH_GAIN, fabs(gains[STERN_GAINS + PITCH_GAIN])) * (s->theta - s->ascent_pitch);
    angle += most(DAMPED_BUBBLE, fabs(gains[STERN_GAINS + PITCH_RATE_GAIN])) * s->q;
    double furthest = least(MOST_STERN, c->limit_s);
    double down = c->M_ds <= 0.0 ? 1.0 : -1.0;
    s->command_s = s->stern_by_hand != 0.0 ? s->ordered_s : within(down * angle, 0.0, furthest);
    s->command_b = s->bow_by_hand != 0.0 ? s->ordered_b : 0.0;
    if (s->blow_forward == EMERGENCY_OPENING)
        s->blow_aft = s->theta > AFT_BLOW_PITCH ? EMERGENCY_OPENING : 0.0;
}

static void hand_back(const struct vessel *c, double h, struct state *s)
{
    int still = fabs(s->zdot) < QUIET_RATE && fabs(s->theta) < QUIET_PITCH && !is_blown(s);
    s->ascent_quiet = still ? s->ascent_quiet + h : 0.0;
    if (s->ascent_quiet < QUIET_TIME_S)
        return;
    if (s->z < SURFACED_DEPTH * c->diameter) {
        s->ascent = ASCENT_AFLOAT;
        return;
    }
    if (is_surfacing(s))
        return;
    s->ascent = 0.0;
    s->ordered_depth = s->depth_reference = s->z;
    s->depth_reference_rate = 0.0;
}

static void go_on_from(struct state *s, int surface, double law)
{
    stand_by(s, surface, law, 0);
    if (s->ascent == 0.0) {
        s->integral[surface] += s->handover[surface];
        s->handover[surface] = 0.0;
    }
}

static int is_hovering(const struct state *s)
{
    return s->hover > 0.0 && fabs(s->u) < MAX_WAY_SPEED;
}

static void keep_planes(const struct vessel *c, double h, const double *gains, struct state *s)
{
    watch_blow(c, s);
    double stern_law = plane_law(s, gains, STERN_GAINS), bow_law = plane_law(s, gains, STERN_GAINS + PLANE_COUNT);
    if (s->ascent != 0.0) {
        if (s->ascent == ASCENT_RISING) {
            hold_bubble(c, h, gains, s);
            hand_back(c, h, s);
        } else
            lay_amidships(s);
        go_on_from(s, STERN, stern_law);
        go_on_from(s, BOW, bow_law);
    } else if (is_hovering(s)) {
        lay_amidships(s);
        stand_by(s, STERN, stern_law, 0);
        stand_by(s, BOW, bow_law, 0);
    } else {
        keep_depth(c, h, gains, s);
        return;
    }
    s->wave_share = 0.0;
}

static void keep_course(const struct vessel *c, double h, const double *gains, struct state *s)
{
    double law = course_law(s, gains);
    if (s->rudder_by_hand != 0.0) {
        s->command_r = s->ordered_r;
        stand_by(s, RUDDER, law, fabs(s->r) < c->turning_rate);
    } else if (s->u < ASTERN_SPEED) {
        s->command_r = within(-law, 0.0, c->limit_r);
        stand_by(s, RUDDER, law, 0);
    } else {
        double step = 0.0;
        if (fabs(s->psi_reference_rate) < c->turning_rate)
            step = h * gains[COURSE_INTEGRAL_GAIN] * (s->psi_reference - s->psi);
        steer(c, s, RUDDER, law, step);
    }
}

static double learnt(const struct vessel *c, double h, struct state *s)
{
    double share = h / (LOW_PASS_TIME_S + h);
    double pace = c->speed_integral * most(s->speed_followed, 0.0) / c->gain_speed[0];
    double rate = pace * (s->ordered_speed - s->u) - s->udot;
    if (is_turning(c, s))
        rate = 0.0;
    int answering = (fabs(s->ordered_speed - s->speed_followed) > FAR_SPEED
        && s->speed_since < ANSWER_TIME_S) || fabs(s->command_u_c - s->u_c) > PROPELLER_SLACK;
    double first = s->speed_rate_1 + share * (rate - s->speed_rate_1);
    if (answering)
        first = 0.0;
    double second = s->speed_rate_2 + share * (first - s->speed_rate_2);
    s->speed_rate_1 = first;
    s->speed_rate_2 = answering ? 0.0 : second;
    double furthest = MOST_TRIM[0] * fabs(s->ordered_speed) + MOST_TRIM[1];
    double new = s->speed_trim + h * s->speed_rate_2;
    double command = s->ordered_speed + new;
    int over = (command > c->u_c_ahead || new > furthest) && new > s->speed_trim;
    int under = (command < c->u_c_astern || new < -furthest) && new < s->speed_trim;
    return over || under ? s->speed_trim : new;
}

static int is_short(const struct vessel *c, const struct state *s)
{
    int lacking = s->ordered_speed - s->speed_followed > FAR_SPEED;
    int all_given = s->command_u_c >= c->u_c_ahead || s->command_u_c - s->u_c > PROPELLER_SLACK
        || s->speed_trim >= MOST_TRIM[0] * fabs(s->ordered_speed) + MOST_TRIM[1];
    return lacking && all_given && !is_turning(c, s);
}

static void keep_speed(const struct vessel *c, double h, struct state *s)
{
    double share = h / (LOW_PASS_TIME_S + h);
    s->speed_followed += share * (s->u - s->speed_followed);
    s->turn_followed += share * (s->r - s->turn_followed);
    s->speed_since = s->ordered_speed != s->speed_order ? 0.0 : s->speed_since + h;
    s->speed_order = s->ordered_speed;
    if (s->speed_by_hand != 0.0 || c->gain_count == 0.0) {
        s->command_u_c = s->ordered_u_c;
        s->speed_since = s->speed_short = s->speed_rate_1 = s->speed_rate_2 = 0.0;
        return;
    }
    s->speed_trim = learnt(c, h, s);
    double slowest = most(c->u_c_astern, least(s->ordered_speed, 0.0));
    s->command_u_c = clamped(s->ordered_speed + s->speed_trim, slowest, c->u_c_ahead);
    s->speed_short = is_short(c, s) ? s->speed_short + h : 0.0;
}

static double trim_moved(double wanted, double negligible, double h, double furthest)
{
    if (fabs(wanted) <= negligible)
        return 0.0;
    return clamped(wanted * h / TRIM_TIME_S, -furthest * h, furthest * h);
}

static int is_trimming(const struct state *s)
{
    int free = s->ascent == 0.0 && !is_hovering(s);
    return free && s->stern_by_hand == 0.0 && s->bow_by_hand == 0.0
        && fabs(s->ordered_depth - s->z) < MAX_DEPTH_ERROR_M && s->u > MIN_TRIM_SPEED;
}

static void keep_trim(const struct vessel *c, double h, struct state *s)
{
    s->trim_flood = s->trim_forward = 0.0;
    if (s->trim_by_hand != 0.0)
        return;
    double share = h / (TRIM_MEMORY + h), square = s->u * s->u;
    double lift = square * (c->Z_ds * s->delta_s + c->Z_db * s->delta_b);
    double moment = square * (c->M_ds * s->delta_s + c->M_db * s->delta_b);
    s->trim_lift += share * (lift - s->trim_lift);
    s->trim_moment += share * (moment - s->trim_moment);
    s->trim_pitch += share * (s->theta - s->trim_pitch);
    if (!is_trimming(s) || is_turning(c, s))
        return;
    if (c->limit_b > 0.0 && fabs(s->delta_s) < FREE_PLANES)
        s->stern_integral += (c->M_ds <= 0.0 ? 1.0 : -1.0) * LEVELLING_RATE * h * s->trim_pitch;
    double arm = c->x[TRIM_FORWARD] - c->x[TRIM_AFT];
    s->trim_flood = trim_moved(s->trim_lift / c->g, MIN_HEAVINESS * c->mass, h, MAX_FLOOD_RATE);
    if (arm > 0.0)
        s->trim_forward = trim_moved(-s->trim_moment / (c->g * arm), MIN_IMBALANCE * c->mass, h, MAX_TRANSFER_RATE);
}

static void hold_commands(const double *gains, struct state *s)
{
    s->trim_flood = s->trim_forward = 0.0;
    if (s->speed_by_hand != 0.0)
        s->command_u_c = s->ordered_u_c;
    for (int surface = 0; surface < 3; surface++)
        if (s->by_hand[surface] != 0.0)
            s->command[surface] = s->ordered[surface];
    stand_by(s, RUDDER, course_law(s, gains), 0);
    stand_by(s, STERN, plane_law(s, gains, STERN_GAINS), 0);
    stand_by(s, BOW, plane_law(s, gains, STERN_GAINS + PLANE_COUNT), 0);
}

static void autopilot(const struct vessel *c, double h, struct state *s, double *gains)
{
    if (c->gain_count > 0.0)
        scheduled_gains(c, fabs(s->u), gains);
    if (c->gain_count > 0.0 && s->u < ASTERN_SPEED)
        slow_turns(gains, s);
    slew_depth(h, gains, s);
    slew_course(h, gains, s);
    if (slot_of(AUTOPILOT_FAILED, s) >= 0 || is_dead(FED_AUTOPILOT, s)) {
        hold_commands(gains, s);
        return;
    }
    sense_waves(c, h, gains, s);
    keep_planes(c, h, gains, s);
    keep_course(c, h, gains, s);
    fade(c, h, s);
    keep_speed(c, h, s);
    keep_trim(c, h, s);
}
