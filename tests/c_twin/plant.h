/* The plant that is well: its battery alone, as trainer/core/plant/plant.py drains it. */

static int is_running(int consumer, const struct state *s)
{
    if (consumer < HYDRAULIC_END)
        return 0;
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
    double load = c->hotel[bus];
    for (int i = 0; i < CONSUMER_COUNT; i++) {
        int feeders = (int)c->feeders[i], fed = 0;
        while (fed < 3 && !((feeders >> fed) & 1))
            fed++;
        if (fed == bus && is_running(i, s))
            load += c->power_drawn[i];
    }
    return load;
}

static void advance_plant(const struct vessel *c, double h, struct state *s)
{
    if (c->battery_full == 0.0 || s->tick != CALM_TICKS * floor(s->tick * (1.0 / CALM_TICKS)))
        return;
    h *= CALM_TICKS;
    double speed = s->u_c / c->screw_speed;
    double load = bus_load(c, 0, s) + bus_load(c, 1, s);
    double power = c->screw_power * fabs(speed * speed * speed) + load + bus_load(c, 2, s);
    double spent = s->battery_spent + h * power * (1.0 + power / c->cell_power);
    s->battery_spent = spent < c->battery_full ? spent : c->battery_full;
}
