/* The attitude near the vertical, turned instead of advanced: trainer/core/attitude.py. */

struct turn {
    double x, y, z;
};

struct angles {
    double phi, theta, psi;
};

static int is_polar(const struct state *s) { return fabs(s->theta) > POLAR_PITCH; }

static struct turn rotated(double a, double b, double c, struct turn t)
{
    double square = t.x * t.x + t.y * t.y + t.z * t.z;
    double size = sqrt(square), first = 1.0, second = 0.5;
    if (!(size < 1e-9)) {
        double cos_size, sin_size;
        cosine_and_sine(size, &cos_size, &sin_size);
        first = sin_size / size;
        second = (1.0 - cos_size) / square;
    }
    double a1 = b * t.z - c * t.y, b1 = c * t.x - a * t.z, c1 = a * t.y - b * t.x;
    double a2 = b1 * t.z - c1 * t.y, b2 = c1 * t.x - a1 * t.z, c2 = a1 * t.y - b1 * t.x;
    return (struct turn){
        a + first * a1 + second * a2,
        b + first * b1 + second * b2,
        c + first * c1 + second * c2,
    };
}

static double nearest_turn(double angle, double old)
{
    return angle + FULL_TURN * floor((old - angle) / FULL_TURN + 0.5);
}

static struct angles turned(struct angles at, struct turn turn)
{
    double cos_phi, sin_phi, cos_th, sin_th, cos_psi, sin_psi;
    cosine_and_sine(at.phi, &cos_phi, &sin_phi);
    cosine_and_sine(at.theta, &cos_th, &sin_th);
    cosine_and_sine(at.psi, &cos_psi, &sin_psi);
    double north = rotated(
        cos_psi * cos_th,
        cos_psi * sin_th * sin_phi - sin_psi * cos_phi,
        cos_psi * sin_th * cos_phi + sin_psi * sin_phi,
        turn).x;
    double east = rotated(
        sin_psi * cos_th,
        sin_psi * sin_th * sin_phi + cos_psi * cos_phi,
        sin_psi * sin_th * cos_phi - cos_psi * sin_phi,
        turn).x;
    struct turn down = rotated(-sin_th, cos_th * sin_phi, cos_th * cos_phi, turn);
    double level = down.y * down.y + down.z * down.z;
    double pitch = arctangent(-down.x, sqrt(level));
    double heel = level >= 1e-18 ? arctangent(down.y, down.z) : at.phi;
    return (struct angles){heel, pitch, nearest_turn(arctangent(east, north), at.psi)};
}

static void take_attitude(struct angles to, struct state *s)
{
    double jump_phi = to.phi - s->phi, jump_theta = to.theta - s->theta;
    double jump_psi = to.psi - s->psi;
    s->phi = to.phi;
    s->theta = to.theta;
    s->psi = to.psi;
    for (int back = 0; back < PAST; back++) {
        s->past_motion[back][PHI] += jump_phi;
        s->past_motion[back][THETA] += jump_theta;
        s->past_motion[back][PSI] += jump_psi;
    }
}

static int is_beyond(const struct state *s)
{
    return fabs(s->theta) > 0.5 * HALF_TURN || fabs(s->phi) > HALF_TURN;
}

static void bring_within(struct state *s)
{
    struct angles at = {s->phi, s->theta, s->psi};
    take_attitude(turned(at, (struct turn){0.0, 0.0, 0.0}), s);
}

static void forget_rates(struct state *s)
{
    for (int i = 0; i < 3; i++)
        for (int back = 0; back < PAST; back++)
            s->past_rates[back][PHI + i] = s->rates[PHI + i];
}
