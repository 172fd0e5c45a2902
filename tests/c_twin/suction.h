/* The mean suction of a sea and its gradient: trainer/core/sea/forces.py. */

static double fading(int row, double kappa)
{
    double root = sqrt(kappa);
    double value = FADING[row][0] + FADING[row][1] * logarithm(kappa) + FADING[row][2] * root;
    return value + kappa * (FADING[row][3] + FADING[row][4] * kappa);
}

static void suction(
    double g, double omega, double height, double depth, double *lift, double *gradient)
{
    double number = omega * omega / g;
    double kappa = clamped(number * depth, MIN_KAPPA, MAX_KAPPA);
    double force = 0.125 * g * number * number * height * height;
    *lift = force * exponential(fading(0, kappa));
    *gradient = 2.0 * number * force * exponential(fading(1, kappa));
}
