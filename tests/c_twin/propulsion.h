/* Thrust less drag, and the engine room that answers: trainer/core/propulsion.py. */

/* The thrust of both sets: each record has the same rows. */
#define DEFINE_THRUST(name, record)                                              \
    static double name(const struct record *c, const struct state *s)            \
    {                                                                            \
        double u = s->u, u_c = s->u_c;                                           \
        double speed = u;                                                        \
        if (c->eta_whole != 0.0)                                                 \
            speed = sqrt(u * u + s->v * s->v + s->w * s->w);                     \
        int first = speed > 0.0 ? u_c >= c->eta_1 * speed : u_c >= 0.0;          \
        int second = speed > 0.0 && u_c >= c->eta_2 * speed;                     \
        double a = first ? c->a1 : second ? c->a2 : c->a3;                       \
        double b = first ? c->b1 : second ? c->b2 : c->b3;                       \
        double k = first ? c->c1 : second ? c->c2 : c->c3;                       \
        return u * (a * fabs(u) + b * u_c) + k * u_c * u_c;                      \
    }

DEFINE_THRUST(compact_thrust, compact)
DEFINE_THRUST(wide_thrust, vessel)

static double thrust_astern(const struct vessel *c, const struct state *s)
{
    const double *row = c->thrust_astern[s->u_c < 0.0 ? 0 : 1];
    return s->u * (row[0] * s->u + row[1] * s->u_c) + row[2] * s->u_c * s->u_c;
}

static double propulsion_target(const struct state *s)
{
    if (is_dead(FED_PROPULSION, s))
        return 0.0;
    int stuck = slot_of(PROPULSION_STUCK, s), lost = slot_of(PROPULSION_LOST, s);
    double wanted = stuck >= 0 ? s->casualty_amount[stuck] : s->telegraph_answer;
    return lost >= 0 ? wanted * (1.0 - s->casualty_amount[lost]) : wanted;
}

static double within_power(const struct vessel *c, int way, double flow, double n)
{
    const double *q = c->torque[way];
    double square = q[0], linear = q[1] * flow, fixed = q[2] * flow * flow;
    for (int i = 0; i < POWER_ROOT_STEPS; i++) {
        double over = n * (n * (square * n + linear) + fixed) - c->power_limit;
        double slope = n * (3.0 * square * n + 2.0 * linear) + fixed;
        if (over <= 0.0 || slope <= 0.0)
            break;
        n -= over / slope;
    }
    return n;
}

static double most_revolutions(const struct vessel *c, int way, double flow)
{
    const double *q = c->torque[way];
    double half = 0.5 * q[1] * flow, rest = q[2] * flow * flow - c->torque_limit;
    double square = half * half - q[0] * rest;
    double n = square > 0.0 ? most((sqrt(square) - half) / q[0], 0.0) : 0.0;
    return c->power_limit > 0.0 ? within_power(c, way, flow, n) : n;
}

static double within_engine(const struct vessel *c, double wanted, const struct state *s)
{
    double u = s->u;
    if (wanted > most(u, 0.0)) {
        double possible = most_revolutions(c, 0, most(u, 0.0) / c->screw) / c->turns;
        return least(wanted, most(possible, u));
    }
    if (wanted < least(u, 0.0)) {
        int way = u >= 0.0 ? 1 : 2;
        return most(wanted, -most_revolutions(c, way, fabs(u) / c->screw) / c->turns);
    }
    return wanted;
}

static void answer_telegraph(const struct vessel *c, double h, struct state *s)
{
    if (!is_dead(FED_TELEGRAPH, s)) {
        double standing = s->speed_by_hand != 0.0 ? s->ordered_u_c : s->ordered_speed;
        if (standing != s->telegraph_order) {
            s->telegraph_order = standing;
            s->telegraph_ticks = floor(c->telegraph_dead_time / h + 0.5);
        }
        if (s->telegraph_ticks > 0.0)
            s->telegraph_ticks -= 1.0;
        else
            s->telegraph_answer = s->command_u_c;
    }
    double share = c->propulsion_lag > 0.0 ? 1.0 - exponential(-h / c->propulsion_lag) : 1.0;
    double target = propulsion_target(s);
    if (c->torque_limit > 0.0)
        target = within_engine(c, target, s);
    s->u_c += share * (target - s->u_c);
}
