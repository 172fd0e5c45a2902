/* The plant without fire and noise: power, oil and modes as trainer/core/plant has them. */

static int is_sound_bus(const struct vessel *c, int bus, const struct state *s)
{
    int dips = bus != DC && s->dip_time < s->plant_fault[DIP];
    int broken = s->plant_fault[FIRST_BUS + bus] >= 1.0;
    return !(s->battery_spent >= c->battery_full || dips || broken);
}

static int feeding_bus(const struct vessel *c, int consumer, const struct state *s)
{
    int feeders = (int)c->feeders[consumer];
    for (int bus = 0; bus < 3; bus++)
        if (((feeders >> bus) & 1) && s->bus_dead[bus] == 0.0)
            return bus;
    return -1;
}

static int is_running(int consumer, const struct state *s)
{
    if (consumer < HYDRAULIC_END)
        return s->hydraulic_pump[consumer] == RUNNING;
    if (consumer == FED_TRIM)
        return s->to_move[0] != 0.0 || s->trim_forward != 0.0;
    if (consumer == FED_DRAIN)
        return s->to_move[1] != 0.0 || s->drained > 0.0 || s->trim_flood != 0.0;
    if (consumer == FED_DEPTH_CONTROL)
        return s->to_move[2] != 0.0 || s->hover != 0.0;
    if (consumer == FED_COMPRESSOR)
        return s->compressor > 0.0;
    return 1;
}

static double bus_load(const struct vessel *c, int bus, const struct state *s)
{
    double load = (1.0 - s->bus_dead[bus]) * (c->hotel[bus] - s->loads_shed * c->hotel_shed[bus]);
    for (int i = 0; i < CONSUMER_COUNT; i++)
        if (feeding_bus(c, i, s) == bus && is_running(i, s))
            load += c->power_drawn[i];
    return load;
}

static void watch_overload(
    const struct vessel *c, double h, int single, int port_feeds, struct state *s)
{
    double port = bus_load(c, PORT, s), starboard = bus_load(c, STARBOARD, s);
    if ((single ? port + starboard : most(port, starboard)) <= c->bus_limit) {
        s->overload = 0.0;
        return;
    }
    s->overload += h;
    if (s->overload < c->overload_time)
        return;
    s->breaker_open[(single ? port_feeds : port >= starboard) ? PORT : STARBOARD] = 1.0;
    if (single)
        s->bus_tie = 0.0;
    s->overload = 0.0;
}

static void feed_buses(const struct vessel *c, double h, struct state *s)
{
    int port = s->breaker_open[PORT] == 0.0, starboard = s->breaker_open[STARBOARD] == 0.0;
    int port_feeds = port && is_sound_bus(c, PORT, s);
    int starboard_feeds = starboard && is_sound_bus(c, STARBOARD, s);
    int tied = s->bus_tie > 0.0 && port && starboard;
    s->bus_dead[PORT] = port_feeds || (tied && starboard_feeds) ? 0.0 : 1.0;
    s->bus_dead[STARBOARD] = starboard_feeds || (tied && port_feeds) ? 0.0 : 1.0;
    s->bus_dead[DC] = is_sound_bus(c, DC, s) ? 0.0 : 1.0;
    s->dip_time = s->plant_fault[DIP] > 0.0 ? s->dip_time + h : 0.0;
    watch_overload(c, h, tied && port_feeds != starboard_feeds, port_feeds, s);
}

static void cut_off_consumers(const struct vessel *c, double h, struct state *s)
{
    double unpowered = 0.0;
    for (int i = 0; i < CONSUMER_COUNT; i++) {
        int dead = feeding_bus(c, i, s) < 0;
        if (i == FED_GYRO) {
            s->gyro_unfed = dead ? s->gyro_unfed + h : 0.0;
            dead = s->gyro_unfed > c->gyro_time;
        }
        if (dead)
            unpowered += (double)(1 << i);
    }
    s->unpowered = unpowered;
}

static void stop_gauges(struct state *s)
{
    for (int i = 0; i < 3; i++) {
        if (is_dead(FED_GYRO + i, s))
            continue;
        int stuck = slot_of(GAUGE_CODE[GYRO + i][GAUGE_STUCK], s);
        double read = GYRO + i == SOUNDER ? 0.0 : shown(GYRO + i, s); /* no ground, no noise */
        s->gauge_held[i] = stuck >= 0 ? s->casualty_amount[stuck] : read;
    }
}

static void lose_cells(const struct vessel *c, struct state *s)
{
    double gone = clamped(s->plant_fault[CELLS], 0.0, 1.0);
    if (gone > s->cells_gone) {
        double kept = (1.0 - gone) / (1.0 - s->cells_gone);
        s->battery_spent = c->battery_full - (c->battery_full - s->battery_spent) * kept;
    }
    s->cells_gone = gone;
}

static void drain_battery(const struct vessel *c, double h, struct state *s)
{
    if (c->battery_full == 0.0)
        return;
    double speed = s->u_c / c->screw_speed;
    double load = bus_load(c, PORT, s) + bus_load(c, STARBOARD, s);
    double power = c->screw_power * fabs(speed * speed * speed) + load + bus_load(c, DC, s);
    s->battery_spent
        = least(s->battery_spent + h * power * (1.0 + power / c->cell_power), c->battery_full);
    if (s->battery_spent == c->battery_full)
        s->plant_touched = 1.0;
}

static double oil_held(const struct vessel *c, int system, const struct state *s)
{
    return c->oil_usable[system] - s->oil_spent[system];
}

static double oil_pressure(const struct vessel *c, int system, const struct state *s)
{
    if (oil_held(c, system, s) <= 0.0)
        return 0.0;
    double full = c->oil_full[system], low = c->oil_low[system];
    double gas = low * c->oil_usable[system] / (full - low);
    return full * gas / (gas + s->oil_spent[system]);
}

static double fed_share(const struct vessel *c, int surface, const struct state *s)
{
    if (s->mode[surface] == HAND)
        return c->hand_rate / c->surface_rate;
    int system = s->mode[surface] == NORMAL ? MAIN : VITAL;
    if (system == MAIN ? s->isolated[MAIN_VALVE] > 0.0 || s->isolated[surface] > 0.0
                       : s->isolated[VITAL_VALVE] > 0.0)
        return 0.0;
    double pressure = oil_pressure(c, system, s), share = 1.0;
    if (pressure <= c->oil_dead)
        share = 0.0;
    else if (pressure < c->oil_rated)
        share = sqrt((pressure - c->oil_dead) / (c->oil_rated - c->oil_dead));
    return system == VITAL ? share * c->emergency_share : share;
}

static void run_pump(const struct vessel *c, int pump, double h, struct state *s)
{
    int system = pump < MAIN_PUMP_COUNT ? MAIN : VITAL;
    if (s->hydraulic_pump[pump] == STANDING_BY) {
        if (oil_pressure(c, system, s) < c->oil_start[pump])
            s->hydraulic_pump[pump] = RUNNING;
    } else if (s->hydraulic_pump[pump] == RUNNING && s->oil_spent[system] <= 0.0) {
        s->hydraulic_pump[pump] = STANDING_BY;
    }
    if (s->hydraulic_pump[pump] != RUNNING || is_dead(pump, s))
        return;
    double sound = 1.0 - clamped(s->plant_fault[system], 0.0, 1.0);
    double left = c->oil_reserve[system] + s->tank_gain[system];
    double given = least(least(c->oil_rate[pump] * sound * h, left), s->oil_spent[system]);
    s->oil_spent[system] -= given;
    s->tank_gain[system] -= given;
}

static void leak_oil(const struct vessel *c, double h, struct state *s)
{
    if (s->isolated[MAIN_VALVE] > 0.0)
        return;
    double leak = s->plant_fault[HEADER];
    for (int i = 0; i < 3; i++)
        if (s->isolated[i] == 0.0)
            leak += s->plant_fault[FIRST_LEG + i];
    if (leak > 0.0) {
        double flow = leak * sqrt(oil_pressure(c, MAIN, s) / c->oil_full[MAIN]);
        s->oil_spent[MAIN] += least(h * flow, oil_held(c, MAIN, s));
    }
}

static void shift_modes(const struct vessel *c, double h, struct state *s)
{
    for (int i = 0; i < 3; i++) {
        if (s->mode_ticks[i] < 0.0) {
            s->mode_ticks[i] = ceil(c->shift_time[(int)s->mode_ordered[i]] / h - 1e-9);
            if (s->mode_ordered[i] != NORMAL && s->by_hand[i] == 0.0) {
                s->by_hand[i] = 1.0;
                s->ordered[i] = s->surface[i];
            }
        }
        if (s->mode_ticks[i] > 0.0 && (s->mode_ticks[i] -= 1.0) == 0.0)
            s->mode[i] = s->mode_ordered[i];
    }
}

static void draw_oil(const struct vessel *c, double r, double stern, double b, struct state *s)
{
    double swept[3] = {c->x_tail != 0.0 ? 0.0 : r, c->x_tail != 0.0 ? most(r, stern) : stern, b};
    for (int i = 0; i < 3; i++) {
        if (s->mode[i] == HAND || fed_share(c, i, s) == 0.0)
            continue;
        int system = s->mode[i] == NORMAL ? MAIN : VITAL;
        double drawn = least(c->oil_angle[i] * swept[i], oil_held(c, system, s));
        s->oil_spent[system] += drawn;
        s->tank_gain[system] += drawn;
    }
}

static void advance_plant(const struct vessel *c, double h, struct state *s)
{
    if (s->plant_touched == 0.0) {
        if (s->tick == CALM_TICKS * floor(s->tick * (1.0 / CALM_TICKS)))
            drain_battery(c, CALM_TICKS * h, s);
        return;
    }
    lose_cells(c, s);
    feed_buses(c, h, s);
    cut_off_consumers(c, h, s);
    stop_gauges(s);
    drain_battery(c, h, s);
    for (int pump = 0; pump < 3; pump++)
        run_pump(c, pump, h, s);
    leak_oil(c, h, s);
    shift_modes(c, h, s);
}
