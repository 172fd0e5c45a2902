/* The exact solve of six equations, and the lagged sweep: trainer/core/solve.py. */

static void eliminate(double (*system)[7])
{
    for (int k = 0; k < 6; k++) {
        int pivot = k;
        for (int i = k + 1; i < 6; i++)
            if (fabs(system[i][k]) > fabs(system[pivot][k]))
                pivot = i;
        for (int j = k; j < 7; j++) {
            double upper = system[k][j];
            system[k][j] = system[pivot][j];
            system[pivot][j] = upper;
        }
        for (int i = k + 1; i < 6; i++) {
            double factor = system[i][k] / system[k][k];
            for (int j = k + 1; j < 7; j++)
                system[i][j] -= factor * system[k][j];
        }
    }
}

static void exact(
    double (*inertia)[6], const double *force, double (*system)[7], double *out)
{
    for (int i = 0; i < 6; i++) {
        for (int j = 0; j < 6; j++)
            system[i][j] = inertia[i][j];
        system[i][6] = force[i];
    }
    eliminate(system);
    for (int k = 5; k >= 0; k--) {
        double total = system[k][6];
        for (int j = k + 1; j < 6; j++)
            total -= system[k][j] * out[j];
        out[k] = total / system[k][k];
    }
}

static void sweep(double (*inertia)[6], const double *force, double *out)
{
    for (int i = 0; i < 6; i++) {
        double total = force[i];
        for (int j = 0; j < 6; j++)
            if (j != i)
                total -= inertia[i][j] * out[j];
        out[i] = total / inertia[i][i];
    }
}
