/* Tanks, air, pumps, and weight and balance: trainer/core/ballast/tanks.py, air.py, pumps.py, ballast.py. */

static double sea_pressure(double specific, double depth)
{
    return ATMOSPHERIC_PRESSURE + specific * most(depth, 0.0);
}

static void admit(const struct vessel *c, int tank, double wanted, struct state *s)
{
    double before = s->water[tank];
    s->water[tank] = clamped(before + wanted, 0.0, c->capacity[tank]);
    s->water_taken += s->water[tank] - before;
}

static double through_hole(double rho, double area, double pressure)
{
    return pressure > 0.0 ? area * sqrt(2.0 * rho * pressure) : 0.0;
}

static double sonic_share(double ratio)
{
    if (ratio <= CRITICAL_RATIO)
        return 1.0;
    if (ratio >= 1.0)
        return 0.0;
    double beyond = (ratio - CRITICAL_RATIO) / (1.0 - CRITICAL_RATIO);
    return sqrt(1.0 - beyond * beyond);
}

static double drawn(
    const struct vessel *c, int bank, double area, double pressure, const struct state *s)
{
    double held = s->bank[bank];
    if (held <= 0.0 || area <= 0.0)
        return 0.0;
    double own = held * c->gas / c->bank_volume[bank];
    double flow = c->choked * area * own * sonic_share(pressure / own);
    return flow * (1.0 - clamped(s->bank_fault[bank], 0.0, 1.0));
}

static void pass_air(
    const struct vessel *c, int bank, int tank, double flow, double pressure, struct state *s)
{
    double spare = s->bank[bank] - pressure * c->bank_volume[bank] / c->gas;
    double before = s->bank[bank];
    s->bank[bank] = most(before - most(least(flow, spare), 0.0), 0.0);
    s->tank_air[tank] += before - s->bank[bank];
}

static void blow(const struct vessel *c, int tank, double pressure, double h, struct state *s)
{
    double order = s->blow[tank];
    double sound = 1.0 - clamped(s->blow_fault[tank], 0.0, 1.0);
    double area = c->blow_area[tank] * least(order, 1.0) * sound;
    double flow = drawn(c, MAIN_BANK, area, pressure, s);
    pass_air(c, MAIN_BANK, tank, flow * h, pressure, s);
    if (order > 1.0) {
        area = c->emergency_area[tank] * least(order - 1.0, 1.0) * sound;
        flow = drawn(c, EMERGENCY_BANK, area, pressure, s);
        pass_air(c, EMERGENCY_BANK, tank, flow * h, pressure, s);
    }
}

static double vent_opening(int tank, const struct state *s)
{
    double fault = s->vent_fault[tank];
    if (fault < 0.0)
        return least(-fault, 1.0);
    return least(s->vent[tank], 1.0) * (1.0 - least(fault, 1.0));
}

static void vent(const struct vessel *c, int tank, double top, double h, struct state *s)
{
    double area = c->vent_area[tank] * vent_opening(tank, s);
    double volume = (c->capacity[tank] - s->water[tank]) / c->rho;
    double space = c->capacity[tank] / c->rho;
    double head = least(top, 0.0) + c->height[tank] * volume / space;
    double pressure = ATMOSPHERIC_PRESSURE + c->rho * c->g * (head + most(top, 0.0));
    double density = most(pressure, MIN_TANK_PRESSURE) / c->gas;
    double flow = through_hole(density, area, c->rho * c->g * fabs(head)) * h;
    double passed = least(flow, fabs(head) / c->height[tank] * space * density);
    passed = head > 0.0 ? least(passed, s->tank_air[tank]) : -passed;
    if (volume <= 0.0 && 0.0 <= top)
        passed = s->tank_air[tank];
    s->tank_air[tank] -= passed;
    s->air_taken -= passed;
}

static void settle(const struct vessel *c, int tank, double top, double h, struct state *s)
{
    double space = c->capacity[tank] / c->rho;
    double volume = (c->capacity[tank] - s->water[tank]) / c->rho;
    double p_top = most(ATMOSPHERIC_PRESSURE + c->rho * c->g * top, MIN_TANK_PRESSURE);
    double slope = c->rho * c->g * c->height[tank] / space;
    double content = s->tank_air[tank] * c->gas;
    double balance = 2.0 * content / (p_top + sqrt(p_top * p_top + 4.0 * slope * content));
    double inward = c->capacity[tank] - c->rho * balance - s->water[tank];
    if (volume > 0.0) {
        double excess = fabs(content / volume - p_top - slope * volume);
        double reach = through_hole(c->rho, c->port[tank], excess) * h;
        inward = clamped(inward, -reach, reach);
    }
    admit(c, tank, inward, s);
    if (s->water[tank] == 0.0) {
        double surplus = s->tank_air[tank] - (p_top + slope * space) * space / c->gas;
        if (surplus > 0.0) {
            s->tank_air[tank] -= surplus;
            s->air_taken -= surplus;
        }
    }
}

static int at_work(const struct vessel *c, int tank, const struct state *s)
{
    if (tank == NEGATIVE_TANK && s->negative_flood <= 0.0)
        return 0;
    if (s->tank_air[tank] > 0.0 || s->water[tank] < c->capacity[tank])
        return 1;
    return (s->blow[tank] > 0.0 || vent_opening(tank, s) > 0.0) && c->capacity[tank] > 0.0;
}

static void work_blown_tank(
    const struct vessel *c, int tank, double depth, double h, struct state *s)
{
    double top = depth - 0.5 * c->height[tank];
    if (s->blow[tank] > 0.0) {
        double level = top + c->height[tank] * (1.0 - s->water[tank] / c->capacity[tank]);
        blow(c, tank, sea_pressure(c->rho * c->g, level), h, s);
    }
    if (vent_opening(tank, s) > 0.0)
        vent(c, tank, top, h, s);
    settle(c, tank, top, h, s);
}

static void compress(const struct vessel *c, double h, struct state *s)
{
    double left = c->compressor_rate * h;
    for (int i = 0; i < 2; i++) {
        double before = s->bank[i];
        s->bank[i] = least(before + left, most(c->bank_full[i], before));
        s->air_taken += s->bank[i] - before;
        left -= s->bank[i] - before;
    }
}

static double delivery(const struct vessel *c, double depth)
{
    double left = 1.0 - most(depth, 0.0) / c->shutoff_depth;
    return left > 0.0 ? sqrt(left) : 0.0;
}

static double sound_rate(const struct vessel *c, int pump, const struct state *s)
{
    if (is_dead(FED_TRIM + pump, s))
        return 0.0;
    return c->pump_rate[pump] * (1.0 - clamped(s->pump_fault[pump], 0.0, 1.0));
}

static void pump_tank(const struct vessel *c, int pump, int tank, double h, struct state *s)
{
    double order = s->to_move[pump];
    double furthest = sound_rate(c, pump, s) * h;
    double amount = least(most(order, -furthest * delivery(c, s->z)), furthest);
    admit(c, tank, amount, s);
    s->to_move[pump] = order - amount;
    int full = order > 0.0 && s->water[tank] >= c->capacity[tank];
    if (full || (order < 0.0 && s->water[tank] <= 0.0))
        s->to_move[pump] = 0.0;
}

static int move_forward(const struct vessel *c, double amount, struct state *s)
{
    double forward = s->water[TRIM_FORWARD], aft = s->water[TRIM_AFT];
    double possible = least(least(amount, aft), c->capacity[TRIM_FORWARD] - forward);
    possible = most(most(possible, -forward), aft - c->capacity[TRIM_AFT]);
    s->water[TRIM_FORWARD] = clamped(forward + possible, 0.0, c->capacity[TRIM_FORWARD]);
    s->water[TRIM_AFT] = clamped(aft - possible, 0.0, c->capacity[TRIM_AFT]);
    return possible == amount;
}

static void transfer_trim(const struct vessel *c, double h, struct state *s)
{
    double order = s->to_move[TRIM_PUMP];
    double furthest = sound_rate(c, TRIM_PUMP, s) * h;
    if (order == 0.0) {
        move_forward(c, clamped(s->trim_forward, -furthest, furthest), s);
        return;
    }
    double amount = clamped(order, -furthest, furthest);
    int whole = move_forward(c, amount, s);
    s->to_move[TRIM_PUMP] = whole ? order - amount : 0.0;
}

static void flood_auxiliary(const struct vessel *c, double h, struct state *s)
{
    double furthest = sound_rate(c, DRAIN_PUMP, s) * h;
    double amount = clamped(s->trim_flood, -furthest * delivery(c, s->z), furthest);
    admit(c, AUXILIARY_TANK, amount, s);
}

static void drain(const struct vessel *c, double h, struct state *s)
{
    int place = FIRST_DRY - 1 + (int)s->drained;
    if (FIRST_DRY <= place && place < TANKS_END)
        admit(c, place, -sound_rate(c, DRAIN_PUMP, s) * h * delivery(c, s->z), s);
}

static double heaved_mass(const struct vessel *c)
{
    return c->buoyancy / c->g - c->Z_wdot;
}

static double suction_gradient(const struct vessel *c, double depth, const struct state *s)
{
    double lift, gradient;
    if (s->sea_height == 0.0 || s->sea_suction == 0.0)
        return 0.0;
    suction(c->g, s->sea_omega, s->sea_height, depth, &lift, &gradient);
    return s->sea_suction * gradient;
}

static void follow_error(double h, struct state *s)
{
    double *kept = s->hover_filter;
    int fresh = s->hover_time == 0.0 || s->ordered_depth != s->hover_order;
    s->hover_order = s->ordered_depth;
    double x = s->ordered_depth - s->z;
    if (are_counted(s)) {
        double omega = frequency_met(s);
        int anew = fresh || s->hover_notched == 0.0;
        x = past(notch_at(LOWER_NOTCH * omega, h, HOVER_ZEROS, HOVER_POLES), x, anew, kept);
        x = past(notch_at(UPPER_NOTCH * omega, h, HOVER_ZEROS, HOVER_POLES), x, anew, kept + SECTION_SIZE);
        s->hover_notched = 1.0;
    } else
        s->hover_notched = 0.0;
    double last = kept[2 * SECTION_SIZE + 2];
    s->hover_error = past(low_pass(HOVER_SLOW, h, SLOW_DAMPING), x, fresh, kept + 2 * SECTION_SIZE);
    s->hover_error_rate = fresh ? 0.0 : (s->hover_error - last) / h;
    double room = fabs(s->hover_error) + HOVER_FURTHEST;
    s->hover_room = fresh ? room : most(least(s->hover_room, room), HOVER_FURTHEST);
}

static int cannot_hold(const struct vessel *c, double gradient, const struct state *s)
{
    if (gradient == 0.0)
        return 0;
    double pole = sqrt(gradient);
    double caught = c->pump_rate[DEPTH_CONTROL_PUMP] * c->g
        / (heaved_mass(c) * pole * pole * pole);
    return s->hover_full > HOVER_LONGEST || fabs(s->hover_error) > s->hover_room
        || fabs(s->hover_error + s->hover_error_rate / pole) > CATCH_SHARE * caught;
}

static void hover(const struct vessel *c, double h, struct state *s)
{
    follow_error(h, s);
    s->hover_time += h;
    double gradient = suction_gradient(c, s->ordered_depth, s);
    if (cannot_hold(c, gradient, s)) {
        s->hover = s->to_move[DEPTH_CONTROL_PUMP] = s->hover_time = 0.0;
        s->hover_lost = 1.0;
        if (s->speed_by_hand == 0.0)
            s->ordered_speed = most(s->ordered_speed, GIVE_UP_SPEED);
        return;
    }
    int rough = s->wave_power > FELT_DEPTH_RATE * FELT_DEPTH_RATE;
    double frequency = SOFTER[rough] * c->hover_frequency, per_acceleration = heaved_mass(c) / c->g;
    double asked = s->hover_error * frequency / (2.0 * HOVER_DAMPING[rough]);
    double lack = clamped(asked, -c->hover_rate, c->hover_rate) + s->hover_error_rate;
    double held = gradient * clamped(s->hover_error, -HOVER_NEAR, HOVER_NEAR);
    double wanted = s->hover_integral
        + per_acceleration * (2.0 * HOVER_DAMPING[rough] * frequency * lack + held);
    double possible = clamped(wanted, 0.0, c->capacity[DEPTH_CONTROL]);
    s->to_move[DEPTH_CONTROL_PUMP] = possible - s->water[DEPTH_CONTROL];
    double rate = c->pump_rate[DEPTH_CONTROL_PUMP], size = fabs(s->to_move[DEPTH_CONTROL_PUMP]);
    s->hover_full = size > rate * h ? s->hover_full + h : 0.0;
    if (wanted == possible && size < LEARNING_TIME_S * rate) {
        double learnt_now = HOVER_INTEGRAL[rough] * frequency * frequency * lack * h;
        s->hover_integral += per_acceleration * learnt_now;
    }
}

static void work_pumps(const struct vessel *c, double h, struct state *s)
{
    if (is_hovering(s))
        hover(c, h, s);
    else
        s->hover_integral = s->water[DEPTH_CONTROL], s->hover_time = s->hover_full = 0.0;
    if (s->to_move[TRIM_PUMP] != 0.0 || s->trim_forward != 0.0)
        transfer_trim(c, h, s);
    if (s->drained > 0.0)
        drain(c, h, s);
    else if (s->to_move[DRAIN_PUMP] != 0.0)
        pump_tank(c, DRAIN_PUMP, AUXILIARY_TANK, h, s);
    else if (s->trim_flood != 0.0)
        flood_auxiliary(c, h, s);
    if (s->to_move[DEPTH_CONTROL_PUMP] != 0.0)
        pump_tank(c, DEPTH_CONTROL_PUMP, DEPTH_CONTROL, h, s);
}

static void balance(const struct vessel *c, struct state *s)
{
    double weight = 0.0, x = 0.0, y = 0.0, z = 0.0;
    for (int i = 0; i < TANKS_END; i++) {
        double more = (s->water[i] - c->start[i]) * c->g;
        weight += more;
        x += more * (c->x[i] - c->x_g);
        y += more * (c->y[i] - c->y_g);
        z += more * (c->z[i] - c->z_g);
    }
    s->weight = c->weight + weight;
    s->x_g = c->x_g + x / s->weight;
    s->y_g = c->y_g + y / s->weight;
    s->z_g = c->z_g + z / s->weight;
}

static void breached(const struct vessel *c, int tank, double depth, double h, struct state *s)
{
    double outside = sea_pressure(c->rho * c->g, depth);
    double limit = c->capacity[tank], inside = ATMOSPHERIC_PRESSURE;
    if (tank >= FIRST_DRY) {
        limit *= 1.0 - ATMOSPHERIC_PRESSURE / outside;
        inside = ATMOSPHERIC_PRESSURE / (1.0 - least(s->water[tank], limit) / c->capacity[tank]);
    }
    double area = DISCHARGE_COEFFICIENT * s->breach[tank - TRIM_FORWARD];
    double amount =
        least(through_hole(c->rho, area, outside - inside) * h, limit - s->water[tank]);
    if (amount > 0.0)
        admit(c, tank, amount, s);
}

static void advance_ballast(const struct vessel *c, double h, struct state *s)
{
    if (c->fitted == 0.0)
        return;
    double cos_th, sin_th, cos_phi, sin_phi;
    cosine_and_sine(s->theta, &cos_th, &sin_th);
    cosine_and_sine(s->phi, &cos_phi, &sin_phi);
    double down_x = -sin_th, down_y = cos_th * sin_phi, down_z = cos_th * cos_phi;
    work_pumps(c, h, s);
    for (int i = TRIM_FORWARD; i < TANKS_END; i++)
        if (s->breach[i - TRIM_FORWARD] > 0.0 && c->capacity[i] > 0.0)
            breached(c, i, s->z + down_x * c->x[i] + down_y * c->y[i] + down_z * c->z[i], h, s);
    for (int i = 0; i <= NEGATIVE_TANK; i++)
        if (at_work(c, i, s))
            work_blown_tank(
                c, i, s->z + down_x * c->x[i] + down_y * c->y[i] + down_z * c->z[i], h, s);
    if (s->compressor > 0.0)
        compress(c, h, s);
    balance(c, s);
}
