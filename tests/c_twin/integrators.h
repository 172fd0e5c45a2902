/* A step by a method of Adams' kind, in parts where it must be: trainer/core/integrators.py. */

static void remember(struct state *s)
{
    if (s->history != 0.0)
        return;
    for (int back = 0; back < PAST; back++)
        for (int i = 0; i < 12; i++)
            s->past_rates[back][i] = s->rates[i];
    s->history = PAST;
}

static void shift(int i, struct state *s)
{
    for (int back = PAST - 1; back > 0; back--)
        s->past_rates[back][i] = s->past_rates[back - 1][i];
    s->past_rates[0][i] = s->rates[i];
}

static void adams(const struct scheme *how, struct state *s)
{
    remember(s);
    for (int i = 0; i < 12; i++) {
        double slope = how->b[0] * s->rates[i];
        for (int back = 0; back < how->depth - 1; back++)
            slope += how->b[back + 1] * s->past_rates[back][i];
        shift(i, s);
        s->motion[i] += how->h * slope;
    }
}

static double past_share(double h, const struct state *s)
{
    return s->last_step > 0.0 ? 0.5 * h / s->last_step : 0.5;
}

static void adams_unequal(double h, struct state *s)
{
    remember(s);
    double share = past_share(h, s);
    for (int i = 0; i < 12; i++) {
        double slope = (1.0 + share) * s->rates[i] - share * s->past_rates[0][i];
        shift(i, s);
        s->motion[i] += h * slope;
    }
}

static struct turn turn_of(double h, const struct state *s)
{
    double share = s->history != 0.0 ? past_share(h, s) : 0.0;
    double ahead = (1.0 + share) * h, behind = share * h;
    return (struct turn){
        ahead * s->p - behind * s->last_p,
        ahead * s->q - behind * s->last_q,
        ahead * s->r - behind * s->last_r,
    };
}

static void adams_step(const struct scheme *how, double h, struct state *s)
{
    int polar = how->envelope && is_polar(s);
    if (s->polar != 0.0 && !polar)
        forget_rates(s);
    struct angles at = {s->phi, s->theta, s->psi};
    struct turn turn = {0.0, 0.0, 0.0};
    double p = s->p, q = s->q, r = s->r;
    if (polar)
        turn = turn_of(h, s);
    if (h != how->h || (s->last_step != h && s->last_step != 0.0))
        adams_unequal(h, s);
    else
        adams(how, s);
    if (polar)
        take_attitude(turned(at, turn), s);
    else if (how->envelope && is_beyond(s))
        bring_within(s);
    s->last_p = p;
    s->last_q = q;
    s->last_r = r;
    s->last_step = h;
    s->polar = polar ? 1.0 : 0.0;
}

static void advance(
    const struct vessel *vessel, const struct compact *compact, const struct scheme *how,
    struct state *s, struct scratch *work)
{
    int count = how->envelope ? substeps(vessel, how->h, work->cut != 0.0, s) : 1;
    for (int i = 0; i < count; i++) {
        rates(vessel, compact, how, s, work);
        adams_step(how, how->h / count, s);
    }
    int adams_2 = how->depth == 2 && how->b[0] == 1.5;
    if (count > 1 && !adams_2)
        s->history = 0.0;
}
