/* Slots, ramps and triggers: trainer/core/casualties.py. */

enum { SLOTS = sizeof(((struct state *)0)->casualty) / sizeof(double) };
enum { TRIGGER_COUNT = sizeof(((struct scheme *)0)->trigger_kind) / sizeof(double) };

static int is_dead(int consumer, const struct state *s)
{
    return s->unpowered != 0.0 && (((int)s->unpowered >> consumer) & 1);
}

static int slot_of(int kind, const struct state *s)
{
    for (int i = 0; i < SLOTS; i++) {
        if (s->casualty[i] == kind)
            return i;
        if (s->casualty[i] == 0.0)
            return -1;
    }
    return -1;
}

static int fault_of(int surface, const struct state *s)
{
    int slot = -1, latest = -1;
    for (int i = 0; i < SLOTS; i++) {
        int kind = (int)s->casualty[i];
        if (kind == 0)
            return slot;
        if (KIND_SURFACES[kind] == surface && KIND_FAULTS[kind] > latest) {
            slot = i;
            latest = KIND_FAULTS[kind];
        }
    }
    return slot;
}

static void write_fault(int kind, double amount, struct state *s)
{
    if (KIND_OFFSETS[kind] >= 0)
        s->whole[KIND_OFFSETS[kind]] = KIND_SENSES[kind] * amount;
}

static void leave(int slot, struct state *s)
{
    int last = SLOTS - 1;
    write_fault((int)s->casualty[slot], 0.0, s);
    for (int i = slot; i < last; i++) {
        s->casualty[i] = s->casualty[i + 1];
        s->casualty_amount[i] = s->casualty_amount[i + 1];
        s->casualty_target[i] = s->casualty_target[i + 1];
        s->casualty_ticks[i] = s->casualty_ticks[i + 1];
    }
    s->casualty[last] = s->casualty_amount[last] = 0.0;
    s->casualty_target[last] = s->casualty_ticks[last] = 0.0;
}

static void ramp(int slot, struct state *s)
{
    double ticks = s->casualty_ticks[slot];
    if (ticks == 1.0)
        s->casualty_amount[slot] = s->casualty_target[slot];
    else if (ticks > 1.0)
        s->casualty_amount[slot] += (s->casualty_target[slot] - s->casualty_amount[slot]) / ticks;
    else if (ticks < -1.0)
        s->casualty_amount[slot] += s->casualty_amount[slot] / ticks;
    if (ticks > 0.0)
        s->casualty_ticks[slot] = ticks - 1.0;
    else if (ticks < 0.0)
        s->casualty_ticks[slot] = ticks + 1.0;
}

static void advance_casualties(struct state *s)
{
    if (s->casualty[0] == 0.0)
        return;
    for (int i = SLOTS - 1; i >= 0; i--) {
        if (s->casualty_ticks[i] == -1.0)
            leave(i, s);
        else if (s->casualty_ticks[i] != 0.0)
            ramp(i, s);
    }
    for (int i = 0; i < SLOTS; i++)
        if (s->casualty[i] != 0.0)
            write_fault((int)s->casualty[i], s->casualty_amount[i], s);
}

static double shown(int gauge, const struct state *s)
{
    double value = gauge == GYRO ? s->psi : gauge == LOG ? s->u : s->z;
    int slot = slot_of(GAUGE_CODE[gauge][GAUGE_BIASED], s);
    return slot >= 0 ? value + s->casualty_amount[slot] : value;
}

static double onset(int kind, const struct state *s)
{
    if (KIND_SURFACES[kind] >= 0 && KIND_FAULTS[kind] >= HARD_OVER)
        return s->surface[KIND_SURFACES[kind]];
    if (kind == PROPULSION_STUCK)
        return s->u_c;
    if (KIND_GAUGES[kind] >= 0 && KIND_HOLDS[kind])
        return shown(KIND_GAUGES[kind], s);
    return 0.0;
}

static int begin(int kind, double amount, double ticks, struct state *s)
{
    int slot = slot_of(kind, s);
    if (slot < 0) {
        slot = slot_of(0, s);
        if (slot < 0)
            return 0;
        if (KIND_IN_PLANT[kind])
            s->plant_touched = 1.0;
        s->casualty[slot] = kind;
        s->casualty_amount[slot] = onset(kind, s);
    }
    s->casualty_ticks[slot] = ticks;
    s->casualty_target[slot] = amount;
    if (KIND_HOLDS[kind]) {
        s->casualty_ticks[slot] = 0.0;
        s->casualty_target[slot] = s->casualty_amount[slot];
    } else if (ticks == 0.0) {
        s->casualty_amount[slot] = amount;
    }
    return 1;
}

static int holds(const struct scheme *m, int trigger, const struct state *s)
{
    double value = s->whole[(int)m->trigger_place[trigger]];
    double excess = m->trigger_sense[trigger] * (value - m->trigger_threshold[trigger]);
    return excess > 0.0 || (excess == 0.0 && m->trigger_strict[trigger] == 0.0);
}

static void fire_triggers(const struct scheme *m, struct state *s)
{
    for (int i = 0; i < TRIGGER_COUNT; i++) {
        if (m->trigger_kind[i] == 0.0)
            return;
        int bit = 1 << i;
        int spent = (int)s->triggers_spent & bit;
        int met = holds(m, i, s);
        if (met && !spent) {
            int kind = (int)m->trigger_kind[i];
            s->triggers_spent += bit * begin(kind, m->trigger_amount[i], m->trigger_ticks[i], s);
        } else if (spent && !met && m->trigger_again[i] != 0.0) {
            s->triggers_spent -= bit;
        }
    }
}
