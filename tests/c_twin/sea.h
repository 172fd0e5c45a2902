/* Noise, and the sea by its three generators: trainer/core/noise.py, sea/filter_1969.py,
   sea/wave_filter.py, sea/cosine_sum.py, sea/sea.py. */

static uint32_t word_turned(uint32_t word, int turn) { return (word << turn) | (word >> (32 - turn)); }

static void random_words(uint64_t seed, uint32_t stream, uint32_t tick, uint32_t *one, uint32_t *two)
{
    static const int turns[2][4] = {{13, 15, 26, 6}, {17, 29, 16, 24}};
    uint32_t key_0 = (uint32_t)(seed >> 32), key_1 = (uint32_t)seed;
    uint32_t keys[3] = {key_0, key_1, (uint32_t)(KEY_PARITY ^ key_0 ^ key_1)};
    uint32_t x = tick + key_0, y = stream + key_1;
    for (int block = 0; block < 5; block++) {
        for (int round = 0; round < 4; round++) {
            x += y;
            y = x ^ word_turned(y, turns[block & 1][round]);
        }
        x += keys[(block + 1) % 3];
        y += keys[(block + 2) % 3] + block + 1;
    }
    *one = x;
    *two = y;
}

static double uniform(uint64_t seed, uint32_t stream, uint32_t tick)
{
    uint32_t x, y;
    random_words(seed, stream, tick, &x, &y);
    return ((x >> 6) * 67108864.0 + (y >> 6) + 0.5) * 2.220446049250313e-16;
}

static double gaussian_pair(uint64_t seed, uint32_t stream, uint32_t tick, double *other)
{
    uint32_t x, y;
    random_words(seed, stream, tick, &x, &y);
    double radius = sqrt(-2.0 * logarithm((x + 0.5) * 2.3283064365386963e-10)), even, odd;
    cosine_and_sine(y * 1.4629180792671596e-09, &even, &odd);
    *other = radius * odd;
    return radius * even;
}

static double gaussian(uint64_t seed, uint32_t stream, uint32_t tick)
{
    uint32_t x, y;
    random_words(seed, stream, tick, &x, &y);
    double radius = sqrt(-2.0 * logarithm((x + 0.5) * 2.3283064365386963e-10));
    return radius * cosine(y * 1.4629180792671596e-09);
}

static double corner(double omega, double g, int which)
{
    double wind = PEAK_FACTOR * g / omega;
    double knots = wind / KNOT;
    double product = SIMILAR[which];
    for (int row = 0; row < 3; row++) {
        double share = 1.0 - fabs(knots - TABLE[row][0]);
        if (share > 0.0) {
            double tabled = TABLE[row][1 + which] * TABLE[row][0] * KNOT / G_OF_TABLE;
            product += share * (tabled - product);
        }
    }
    return product * g / wind;
}

static double warped(double omega, double h)
{
    double adjacent, opposite;
    cosine_and_sine(least(0.5 * omega * h, MAX_HALF_ANGLE), &adjacent, &opposite);
    return opposite / adjacent;
}

static double section(double c, double damping, double *a1, double *a2)
{
    double a0 = 1.0 + 2.0 * damping * c + c * c;
    *a1 = 2.0 * (c * c - 1.0) / a0;
    *a2 = (1.0 - 2.0 * damping * c + c * c) / a0;
    return a0;
}

static void times(struct scratch *work, double first, double second, double third)
{
    for (int i = FILTER_DEGREE; i >= 0; i--) {
        double value = first * work->a[i];
        if (i >= 1)
            value += second * work->a[i - 1];
        if (i >= 2)
            value += third * work->a[i - 2];
        work->a[i] = value;
    }
}

static void powers(struct scratch *work)
{
    work->elevation_power = work->quadrature_power = 0.0;
    for (int degree = FILTER_DEGREE; degree > 0; degree--) {
        double alpha = work->a[0] / work->a[1];
        double beta = work->b[1] / work->a[1], delta = work->d[1] / work->a[1];
        work->elevation_power += 0.5 * beta * beta / alpha;
        work->quadrature_power += 0.5 * delta * delta / alpha;
        for (int i = 0; i < degree; i++) {
            double other = i + 2 <= degree ? work->a[i + 2] : 0.0;
            if (i & 1) {
                work->a[i] = work->a[i + 1] - alpha * other;
                work->b[i] = work->b[i + 1];
                work->d[i] = work->d[i + 1];
            } else {
                if (i >= 1) {
                    work->b[i] = work->b[i + 1] - beta * work->a[i + 1];
                    work->d[i] = work->d[i + 1] - delta * work->a[i + 1];
                }
                work->a[i] = work->a[i + 1];
            }
        }
    }
}

static void prepare_filter(double g, double omega, double h, struct scratch *work)
{
    if (work->omega == omega && work->h == h)
        return;
    work->omega = omega;
    work->h = h;
    double low = warped(corner(omega, g, 0), h), high = warped(corner(omega, g, 1), h);
    double low_a0 = section(low, LOW_DAMPING, &work->low_a1, &work->low_a2);
    double high_a0 = section(high, HIGH_DAMPING, &work->high_a1, &work->high_a2);
    for (int i = 0; i <= FILTER_DEGREE; i++)
        work->a[i] = work->b[i] = work->d[i] = 0.0;
    work->a[0] = 1.0;
    double ratio = high / low;
    times(work, 1.0, 2.0 * LOW_DAMPING, 1.0);
    for (int i = 0; i < 3; i++)
        times(work, 1.0, 2.0 * HIGH_DAMPING * ratio, ratio * ratio);
    times(work, low, 1.0, 0.0);
    work->b[FILTER_DEGREE - 6] = 1.0;
    work->d[FILTER_DEGREE - 7] = 1.0;
    powers(work);
    work->elevation_power *= 2.0 * low;
    work->quadrature_power *= 2.0 * low;
    double gain = 1.0 / (low_a0 * high_a0 * high_a0 * high_a0);
    work->elevation_gain = gain * low * low / sqrt(work->elevation_power);
    work->quadrature_gain = gain * low / sqrt(work->quadrature_power);
}

static void filter_noise(const struct scratch *work, double x, struct state *s)
{
    for (int i = 0; i < 3; i++) {
        double one = s->sea_memory[2 * i], two = s->sea_memory[2 * i + 1];
        double w = x - work->high_a1 * one - work->high_a2 * two;
        x = w - 2.0 * one + two;
        s->sea_memory[2 * i + 1] = one;
        s->sea_memory[2 * i] = w;
    }
    double one = s->sea_memory[6], two = s->sea_memory[7];
    double w = x - work->low_a1 * one - work->low_a2 * two;
    s->sea_memory[7] = one;
    s->sea_memory[6] = w;
    s->sea_elevation = work->elevation_gain * (w + 2.0 * one + two);
    s->sea_quadrature = -work->quadrature_gain * (w - two);
}

static double wrapped(double angle)
{
    return angle - 6.283185307179586 * floor(angle * 0.15915494309189535 + 0.5);
}

static void advance_filter(
    const struct scratch *work, double turn_cos, double turn_sin, struct state *s)
{
    filter_noise(work, gaussian((uint64_t)s->seed, SEA_FILTER, (uint32_t)(int64_t)s->tick), s);
    double elevation = s->sea_elevation, quadrature = s->sea_quadrature;
    s->sea_elevation = elevation * turn_cos + quadrature * turn_sin;
    s->sea_quadrature = quadrature * turn_cos - elevation * turn_sin;
}

static void advance_modes(int bank, struct state *s)
{
    int64_t step = (int64_t)s->sea_steps;
    double x = s->sea_spare[bank], *mode = s->sea_modes[bank];
    if (!(step & 1))
        x = gaussian_pair(
            (uint64_t)s->seed, SEA_BANK + bank, (uint32_t)(step >> 1), &s->sea_spare[bank]);
    for (int i = 0; i < 4; i++) {
        double along = MODE_FACTORS[bank][0][i], across = MODE_FACTORS[bank][1][i];
        double a = mode[i], b = mode[4 + i];
        mode[i] = along * a - across * b + x;
        mode[4 + i] = across * a + along * b;
    }
}

static void choose_rows(int bank, int row, double inside, struct scratch *work)
{
    for (int i = 0; i < 8; i++)
        for (int j = 0; j < 2; j++) {
            double upper = FORCE_ROWS[bank][row][i][j], lower = FORCE_ROWS[bank][row + 1][i][j];
            work->force_rows[bank][i][j] = upper + inside * (lower - upper);
        }
}

static void add_outputs(
    int bank, double size, const struct scratch *work, const struct state *s, double *outputs)
{
    for (int i = 0; i < 8; i++) {
        double x = size * s->sea_modes[bank][i];
        for (int j = 0; j < 2; j++) {
            outputs[j] += WAVE_ROWS[bank][i][j] * x;
            outputs[2 + j] += work->force_rows[bank][i][j] * x;
        }
    }
}

static void note_outputs(const struct scratch *work, struct state *s)
{
    double *outputs = s->sea_past[(int64_t)s->sea_steps & 3];
    for (int j = 0; j < OUTPUT_COUNT; j++)
        outputs[j] = 0.0;
    if (s->sea_peaked < 1.0)
        add_outputs(0, sqrt(1.0 - s->sea_peaked), work, s, outputs);
    if (s->sea_peaked > 0.0)
        add_outputs(1, sqrt(s->sea_peaked), work, s, outputs);
}

static double left_length(int row, double inside, double peaked)
{
    const double *one = &LENGTH_TABLE[0][row], *other = &LENGTH_TABLE[1][row];
    double flat = one[0] + inside * (one[1] - one[0]);
    double raised = other[0] + inside * (other[1] - other[0]);
    return flat + peaked * (raised - flat);
}

static void advance_clock(
    double number, double run, double h, struct scratch *work, struct state *s)
{
    int depths = sizeof FORCE_DEPTHS / sizeof *FORCE_DEPTHS;
    double inside, turn = s->sea_omega * h;
    int row = cell(FORCE_DEPTHS, depths, number * most(s->z, 0.0), &inside);
    s->push_number = number * left_length(row, inside, s->sea_peaked);
    if (s->sea_peaked < 1.0)
        choose_rows(0, row, inside, work);
    if (s->sea_peaked > 0.0)
        choose_rows(1, row, inside, work);
    s->sea_clock += most(turn - 2.0 * number * run, SLOWEST_CLOCK * turn) / PHASE_STEP;
    for (int done = 0; s->sea_clock >= 1.0 && done < MOST_STEPS; done++) {
        if (s->sea_peaked < 1.0)
            advance_modes(0, s);
        if (s->sea_peaked > 0.0)
            advance_modes(1, s);
        note_outputs(work, s);
        s->sea_steps += 1.0;
        s->sea_clock -= 1.0;
    }
    s->sea_clock -= floor(s->sea_clock);
}

static void read_outputs(double turn_cos, double turn_sin, struct state *s)
{
    double f = s->sea_clock;
    double before = f + 1.0, after = f - 1.0, beyond = f - 2.0;
    double weight[4] = {
        -f * after * beyond * 0.16666666666666666, before * after * beyond * 0.5,
        -before * f * beyond * 0.5, before * f * after * 0.16666666666666666};
    double now[OUTPUT_COUNT], *past[4];
    for (int i = 0; i < 4; i++)
        past[i] = s->sea_past[((int64_t)s->sea_steps + i) & 3];
    for (int j = 0; j < OUTPUT_COUNT; j++) {
        double early = weight[0] * past[0][j] + weight[1] * past[1][j];
        now[j] = early + (weight[2] * past[2][j] + weight[3] * past[3][j]);
    }
    for (int j = 0; j < OUTPUT_COUNT; j += 2) {
        s->sea_waves[j] = now[j] * turn_cos - now[j + 1] * turn_sin;
        s->sea_waves[j + 1] = now[j + 1] * turn_cos + now[j] * turn_sin;
    }
}

static double peakedness(double gamma, double x)
{
    double off = (x - 1.0) / (x <= 1.0 ? 0.07 : 0.09);
    return exponential(logarithm(gamma) * exponential(-0.5 * off * off));
}

static void prepare_sum(double gamma, double seed, struct scratch *work)
{
    if (work->gamma == gamma && work->seed == seed)
        return;
    work->gamma = gamma;
    work->seed = seed;
    double total = 0.0;
    for (int i = 0; i < SEA_COMPONENTS; i++) {
        double inside = uniform((uint64_t)seed, SEA_FREQUENCY, i);
        double part = VARIANCE_SHARE * (i % BAND_COUNT + inside) / BAND_COUNT;
        work->relative[i] = sqrt(sqrt(-1.25 / logarithm(part)));
        work->phase_start[i] = 6.283185307179586 * (uniform((uint64_t)seed, SEA_PHASE, i) - 0.5);
        work->amplitude[i] = DIRECTION_WEIGHTS[i / BAND_COUNT];
        if (gamma != 1.0)
            work->amplitude[i] *= sqrt(peakedness(gamma, work->relative[i]));
        total += 0.5 * work->amplitude[i] * work->amplitude[i];
    }
    for (int i = 0; i < SEA_COMPONENTS; i++)
        work->amplitude[i] /= sqrt(total);
}

static void advance_sum(const struct vessel *c, double h, struct state *s)
{
    double cos_wind, sin_wind;
    cosine_and_sine(s->sea_direction, &cos_wind, &sin_wind);
    double number = s->sea_omega * s->sea_omega / c->g;
    s->sea_turned += s->sea_omega * h;
    s->sea_along += number * (s->through_north * cos_wind + s->through_east * sin_wind) * h;
    s->sea_across += number * (s->through_east * cos_wind - s->through_north * sin_wind) * h;
}

static double phase(const struct scratch *work, const struct state *s, int i)
{
    double q = work->relative[i];
    double met = s->sea_along * ANGLE_COS[i / BAND_COUNT] + s->sea_across * ANGLE_SIN[i / BAND_COUNT];
    return work->phase_start[i] + q * s->sea_turned - q * q * met;
}

static double sum_elevation(const struct scratch *work, const struct state *s)
{
    double elevation = 0.0;
    for (int i = 0; i < SEA_COMPONENTS; i++)
        elevation += work->amplitude[i] * cosine(phase(work, s, i));
    return elevation;
}

static void approach(double h, struct state *s)
{
    int quantities = sizeof s->sea / sizeof(double);
    if (s->sea_ramp <= 0.0)
        return;
    double omega = s->sea_target[OMEGA];
    if (s->sea_ramp <= h) {
        s->sea_ramp = 0.0;
        for (int i = 0; i < quantities; i++)
            s->sea[i] = s->sea_target[i];
        return;
    }
    double share = h / s->sea_ramp;
    s->sea_ramp -= h;
    if (omega != s->sea_omega)
        omega = s->sea_omega * exponential(share * logarithm(omega / s->sea_omega));
    for (int i = 0; i < quantities; i++)
        s->sea[i] += share * (s->sea_target[i] - s->sea[i]);
    s->sea_omega = omega;
}

static void advance_filters(double g, double h, struct scratch *work, struct state *s)
{
    double number = s->sea_omega * s->sea_omega / g;
    double north, east, turn_cos, turn_sin;
    cosine_and_sine(s->sea_direction, &north, &east);
    double run = h * (s->through_north * north + s->through_east * east);
    s->sea_drift = wrapped(s->sea_drift + number * run);
    cosine_and_sine(s->sea_drift, &turn_cos, &turn_sin);
    if (s->sea_1969 > 0.0) {
        prepare_filter(g, s->sea_omega, h, work);
        advance_filter(work, turn_cos, turn_sin, s);
    }
    if (s->sea_1969 < 1.0) {
        advance_clock(number, run, h, work, s);
        read_outputs(turn_cos, turn_sin, s);
    }
}

static double filtered(const struct state *s)
{
    double unit = 0.0;
    if (s->sea_1969 > 0.0)
        unit += sqrt(s->sea_1969) * s->sea_elevation;
    if (s->sea_1969 < 1.0)
        unit += sqrt(1.0 - s->sea_1969) * s->wave_cos;
    return unit;
}

static void advance_sea(const struct vessel *c, double h, struct scratch *work, struct state *s)
{
    approach(h, s);
    if (s->sea_height == 0.0) {
        s->eta_wave = 0.0;
        return;
    }
    double unit = 0.0;
    if (s->sea_cosines < 1.0) {
        advance_filters(c->g, h, work, s);
        unit += sqrt(1.0 - s->sea_cosines) * filtered(s);
    }
    if (s->sea_cosines > 0.0) {
        prepare_sum(s->sea_gamma, s->seed, work);
        advance_sum(c, h, s);
        unit += sqrt(s->sea_cosines) * sum_elevation(work, s);
    }
    s->eta_wave = 0.25 * s->sea_height * unit;
}
