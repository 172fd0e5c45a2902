/* Sine, cosine, arctangent, exponential and logarithm of trainer/core/elementary.py, the same bits. */

#include <math.h>
#include <stdint.h>

static double least(double a, double b) { return b < a ? b : a; }
static double most(double a, double b) { return b > a ? b : a; }
static double clamped(double x, double low, double high) { return least(most(x, low), high); }

static double sine_series(double r)
{
    double s = r * r;
    double p = 2.8114572543455206e-15;
    p = p * s - 7.6471637318198164e-13;
    p = p * s + 1.6059043836821613e-10;
    p = p * s - 2.5052108385441720e-08;
    p = p * s + 2.7557319223985893e-06;
    p = p * s - 1.9841269841269841e-04;
    p = p * s + 8.3333333333333332e-03;
    p = p * s - 1.6666666666666666e-01;
    return r + r * s * p;
}

static double cosine_series(double r)
{
    double s = r * r;
    double p = 4.7794773323873853e-14;
    p = p * s - 1.1470745597729725e-11;
    p = p * s + 2.0876756987868099e-09;
    p = p * s - 2.7557319223985888e-07;
    p = p * s + 2.4801587301587302e-05;
    p = p * s - 1.3888888888888889e-03;
    p = p * s + 4.1666666666666664e-02;
    double half = 0.5 * s;
    double whole = 1.0 - half;
    return whole + (((1.0 - whole) - half) + s * s * p);
}

static double remainder_of(double x, int64_t turns)
{
    double k = (double)turns;
    double r = x - k * 1.5707963267341256;
    return (r - k * 6.077100506303966e-11) - k * 2.0222662487959506e-21;
}

static int64_t quarter_turns(double x) { return (int64_t)floor(x * 0.6366197723675814 + 0.5); }

static double sine(double x)
{
    double size = fabs(x);
    if (!(size < 1e9))
        return x - x;
    int64_t turns = quarter_turns(size);
    double r = remainder_of(size, turns);
    int quadrant = turns & 3;
    double value = quadrant & 1 ? cosine_series(r) : sine_series(r);
    if (quadrant >= 2)
        value = -value;
    return x >= 0.0 ? value : -value;
}

static double cosine(double x)
{
    double size = fabs(x);
    if (!(size < 1e9))
        return 1.0 + (x - x);
    int64_t turns = quarter_turns(size);
    double r = remainder_of(size, turns);
    int quadrant = turns & 3;
    double value = quadrant & 1 ? sine_series(r) : cosine_series(r);
    return quadrant == 1 || quadrant == 2 ? -value : value;
}

static void cosine_and_sine(double x, double *c, double *s)
{
    double size = fabs(x);
    if (!(size < 1e9)) {
        *c = 1.0 + (x - x);
        *s = x - x;
        return;
    }
    int64_t turns = quarter_turns(size);
    double r = remainder_of(size, turns);
    int quadrant = turns & 3;
    double even = cosine_series(r), odd = sine_series(r);
    *c = quadrant & 1 ? odd : even;
    *s = quadrant & 1 ? even : odd;
    if (quadrant == 1 || quadrant == 2)
        *c = -*c;
    if ((quadrant >= 2) != (x < 0.0))
        *s = -*s;
}

static double exponential(double x)
{
    double bounded = clamped(x, -700.0, 700.0);
    int k = (int)floor(bounded * 1.4426950408889634 + 0.5);
    double r = (bounded - k * 0.6931471803691238) - k * 1.9082149292705877e-10;
    double p = 1.6059043836821613e-10;
    p = p * r + 2.0876756987868100e-09;
    p = p * r + 2.5052108385441720e-08;
    p = p * r + 2.7557319223985888e-07;
    p = p * r + 2.7557319223985893e-06;
    p = p * r + 2.4801587301587302e-05;
    p = p * r + 1.9841269841269841e-04;
    p = p * r + 1.3888888888888889e-03;
    p = p * r + 8.3333333333333332e-03;
    p = p * r + 4.1666666666666664e-02;
    p = p * r + 1.6666666666666666e-01;
    p = p * r + 0.5;
    return ldexp(1.0 + (r + r * r * p), k);
}

static double logarithm(double x)
{
    if (!(0.0 < x && x < INFINITY))
        return x == 0.0 ? -INFINITY : x > 0.0 ? x : NAN;
    int k;
    double m = frexp(x, &k);
    if (m < 0.7071067811865476) {
        m = 2.0 * m;
        k -= 1;
    }
    double f = m - 1.0;
    double s = f / (2.0 + f);
    double half = 0.5 * f * f;
    double z = s * s;
    double p = 4.7619047619047616e-02;
    p = p * z + 5.2631578947368418e-02;
    p = p * z + 5.8823529411764705e-02;
    p = p * z + 6.6666666666666666e-02;
    p = p * z + 7.6923076923076927e-02;
    p = p * z + 9.0909090909090912e-02;
    p = p * z + 1.1111111111111111e-01;
    p = p * z + 1.4285714285714285e-01;
    p = p * z + 2.0000000000000001e-01;
    p = p * z + 3.3333333333333331e-01;
    double small = s * (half + 2.0 * z * p) + k * 1.9082149292705877e-10;
    return k * 0.6931471803691238 - ((half - small) - f);
}

static double arctangent_of_share(double t)
{
    int64_t eighth = (int64_t)floor(8.0 * t + 0.5);
    double c = 0.125 * eighth;
    double z = (t - c) / (1.0 + t * c);
    double s = z * z;
    double p = ARCTANGENT[0];
    for (int i = 1; i < (int)(sizeof ARCTANGENT / sizeof *ARCTANGENT); i++)
        p = p * s + ARCTANGENT[i];
    return EIGHTHS[eighth] + (z + z * s * p);
}

static double arctangent(double y, double x)
{
    double across = fabs(y), along = fabs(x), angle;
    if (across == 0.0 && along == 0.0)
        return 0.0;
    if (across <= along)
        angle = arctangent_of_share(across / along);
    else
        angle = (1.5707963267948966 - arctangent_of_share(along / across)) + 6.123233995736766e-17;
    if (x < 0.0)
        angle = (3.141592653589793 - angle) + 1.2246467991473532e-16;
    return y >= 0.0 ? angle : -angle;
}
