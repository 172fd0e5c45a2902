/* Minus the log-likelihood of a record, as one writes it in plain C.

   The same content as the trainer's: the continuous system sampled by power series and doublings,
   the filter with covariances, readings taken one by one and left out where they are missing, a
   constant gain once the covariance has settled. Sizes are known when it runs. Equation numbers
   are those of the model document. */

#include <math.h>
#include <stdint.h>
#include <string.h>

enum { MOST = 12, WIDEST = 2 * MOST };

typedef double Square[MOST][MOST];
typedef double Wide[MOST][WIDEST];

struct sizes {
    int states, inputs, readings;
};

struct sampled {
    Wide mean;    /* rows (next state, reading), columns (state, old input, input, 1) */
    Square noise; /* of the same rows */
};

/* out = [Phi Gamma] over a short h, the series of exp([A B; 0 0] h) (7.1) */
static void mean_series(int rows, int columns, const Wide drift, double h, Wide out)
{
    Wide term, product;
    for (int i = 0; i < rows; i++) {
        for (int j = 0; j < columns; j++)
            out[i][j] = term[i][j] = drift[i][j] * h;
        out[i][i] += 1.0;
    }
    for (int order = 2; order < 17; order++) {
        for (int i = 0; i < rows; i++)
            for (int j = 0; j < columns; j++) {
                double total = 0.0;
                for (int k = 0; k < rows; k++)
                    total += drift[i][k] * term[k][j];
                product[i][j] = total * (h / order);
            }
        for (int i = 0; i < rows; i++)
            for (int j = 0; j < columns; j++)
                out[i][j] += term[i][j] = product[i][j];
    }
}

/* out = the integral of exp(A s) R exp(A' s) over a short h (7.3) */
static void noise_series(int rows, const Wide drift, const Square noise, double h, Square out)
{
    Square term, product;
    for (int i = 0; i < rows; i++)
        for (int j = 0; j < rows; j++)
            out[i][j] = term[i][j] = noise[i][j] * h;
    for (int order = 2; order < 20; order++) {
        for (int i = 0; i < rows; i++)
            for (int j = 0; j < rows; j++) {
                double total = 0.0;
                for (int k = 0; k < rows; k++)
                    total += drift[i][k] * term[k][j];
                product[i][j] = total;
            }
        for (int i = 0; i < rows; i++)
            for (int j = 0; j <= i; j++) {
                term[i][j] = term[j][i] = (product[i][j] + product[j][i]) * (h / order);
                out[i][j] += term[i][j];
                out[j][i] = out[i][j];
            }
    }
}

/* later += Phi covariance Phi' */
static void carry(int rows, const Wide phi, const Square covariance, Square later)
{
    Square half;
    for (int i = 0; i < rows; i++)
        for (int j = 0; j < rows; j++) {
            half[i][j] = 0.0;
            for (int k = 0; k < rows; k++)
                half[i][j] += phi[i][k] * covariance[k][j];
        }
    for (int i = 0; i < rows; i++)
        for (int j = 0; j <= i; j++) {
            double total = later[i][j];
            for (int k = 0; k < rows; k++)
                total += half[i][k] * phi[j][k];
            later[i][j] = later[j][i] = total;
        }
}

/* mean and covariance over any h: the series over h / 2^n, doubled n times */
static void propagate(int rows, int columns, const Wide drift, const Square noise, double h,
                      Wide mean, Square covariance)
{
    double largest = 0.0;
    int doublings = 0;
    for (int i = 0; i < rows; i++) {
        double total = 0.0;
        for (int j = 0; j < rows; j++)
            total += fabs(drift[i][j]);
        largest = fmax(largest, total * h);
    }
    for (; largest > 0.5 && doublings < 60; doublings++)
        largest *= 0.5;
    h = ldexp(h, -doublings);
    mean_series(rows, columns, drift, h, mean);
    noise_series(rows, drift, noise, h, covariance);
    for (; doublings > 0; doublings--) {
        Wide once;
        Square early;
        memcpy(once, mean, sizeof once);
        memcpy(early, covariance, sizeof early);
        carry(rows, once, early, covariance);
        for (int i = 0; i < rows; i++)
            for (int j = 0; j < columns; j++) {
                mean[i][j] = j < rows ? 0.0 : once[i][j];
                for (int k = 0; k < rows; k++)
                    mean[i][j] += once[i][k] * once[k][j];
            }
    }
}

/* the system over one interval, in which the old input acts until the lag is over (7.2) */
static void sample(const struct sizes *n, const Wide drift, const Square noise, double lag,
                   double interval, struct sampled *out)
{
    int rows = n->states, columns = n->states + n->inputs + 1, all = n->states + n->readings;
    Wide before, after;
    Square early;
    lag = fmin(fmax(lag, 0.0), interval);
    memset(out, 0, sizeof *out);
    propagate(rows, columns, drift, noise, lag, before, early);
    propagate(rows, columns, drift, noise, interval - lag, after, out->noise);
    carry(rows, after, early, out->noise);
    for (int i = 0; i < rows; i++) {
        for (int j = 0; j < columns; j++) {
            double total = 0.0;
            for (int k = 0; k < rows; k++)
                total += after[i][k] * before[k][j];
            out->mean[i][j < columns - 1 ? j : j + n->inputs] = total;
        }
        for (int j = rows; j < columns; j++)
            out->mean[i][j + n->inputs] += after[i][j];
    }
    for (int i = rows; i < all; i++) {
        for (int j = 0; j < columns; j++)
            out->mean[i][j < rows ? j : j + n->inputs] = drift[i][j];
        for (int j = rows; j < all; j++)
            out->noise[i][j] = noise[i][j];
    }
}

/* J = W P W' + Q, its lower half */
static void joint(int rows, int states, const struct sampled *s, const Square P, Square J)
{
    for (int i = 0; i < rows; i++) {
        double half[MOST];
        for (int j = 0; j < states; j++) {
            half[j] = 0.0;
            for (int k = 0; k < states; k++)
                half[j] += s->mean[i][k] * P[k][j];
        }
        for (int j = 0; j <= i; j++) {
            double total = s->noise[i][j];
            for (int k = 0; k < states; k++)
                total += half[k] * s->mean[j][k];
            J[i][j] = total;
        }
    }
}

/* whether P is what J has in its place, to 1e-13 */
static int settled(int states, const Square J, const Square P)
{
    for (int i = 0; i < states; i++)
        for (int j = 0; j <= i; j++) {
            double change = J[i][j] - P[i][j];
            if (change * change > 1e-26 * fabs(P[i][i] * P[j][j]))
                return 0;
        }
    return 1;
}

/* The settled filter as one matrix: rows (next state, error), columns (state, inputs, 1, reading).
   J has been reduced: row c holds what reading c was worth, given those after it. */
static void close_loop(int rows, int states, int columns, const struct sampled *s, const Square J,
                       Wide out)
{
    for (int i = 0; i < rows; i++) {
        for (int j = 0; j < columns; j++)
            out[i][j] = i < states ? s->mean[i][j] : -s->mean[i][j];
        for (int j = states; j < rows; j++)
            out[i][columns + j - states] = i == j ? 1.0 : 0.0;
    }
    for (int c = rows - 1; c >= states; c--)
        for (int i = 0; i < c; i++) {
            double gain = i < states ? J[c][i] / J[c][c] : -J[c][i] / J[c][c];
            for (int j = 0; j < columns + rows - states; j++)
                out[i][j] += gain * out[c][j];
        }
    for (int c = states; c < rows; c++)
        for (int j = 0; j < columns + rows - states; j++)
            out[c][j] /= sqrt(J[c][c]);
}

/* how many samples the settled filter takes, until a reading is missing or the interval changes */
static int64_t run_settled(int rows, int states, int columns, const Wide closed, const double *table,
                        const int64_t *which, int64_t left, double *z, double *squares)
{
    int readings = rows - states, width = columns - 1 - states + readings;
    double w[WIDEST], out[MOST];
    memcpy(w, z, (size_t)columns * sizeof *w);
    for (int64_t k = 0; k < left; k++, table += width) {
        double size = 0.0;
        if (which[k] != which[-1])
            return k;
        memcpy(w + columns, table, (size_t)readings * sizeof *w);
        memcpy(w + states, table + readings, (size_t)(columns - 1 - states) * sizeof *w);
        for (int i = 0; i < rows; i++) {
            double total = 0.0;
            for (int j = states; j < columns + readings; j++)
                total += closed[i][j] * w[j];
            for (int j = 0; j < states; j++)
                total += closed[i][j] * w[j];
            out[i] = total;
        }
        for (int i = states; i < rows; i++)
            size += out[i] * out[i];
        if (isnan(size))
            return k;
        *squares += size;
        for (int i = 0; i < states; i++)
            w[i] = z[i] = out[i];
    }
    return left;
}

/* Minus the log-likelihood of n samples; not a number where a covariance is not positive.

   drift is [A B f; C D d] by rows, noise [R1 0; 0 R2], start [x0 P0], table (n, readings, old and
   new inputs), which the interval that follows each sample, out room for the m sampled systems. */
double minus_log_likelihood(const struct sizes *sizes, const double *drift, const double *noise,
                            const double *start, double lag, const double *intervals, int64_t m,
                            const double *table, const int64_t *which, int64_t n, struct sampled *out)
{
    int states = sizes->states, readings = sizes->readings, rows = states + readings;
    int given = states + sizes->inputs + 1, columns = given + sizes->inputs;
    int width = readings + 2 * sizes->inputs;
    Wide A = {{0.0}}, closed;
    Square R = {{0.0}}, P, J;
    double z[WIDEST], v[MOST], logs = 0.0, squares = 0.0, counted = 0.0;

    for (int i = 0; i < rows; i++) {
        memcpy(A[i], drift + i * given, (size_t)given * sizeof *drift);
        memcpy(R[i], noise + i * rows, (size_t)rows * sizeof *noise);
    }
    for (int64_t i = 0; i < m; i++)
        sample(sizes, A, R, lag, intervals[i], &out[i]);
    for (int i = 0; i < states; i++) {
        z[i] = start[i * (1 + states)];
        memcpy(P[i], start + i * (1 + states) + 1, (size_t)states * sizeof *start);
    }
    z[columns - 1] = 1.0;

    for (int64_t k = 0; k < n; k++) {
        const double *row = table + k * width;
        const struct sampled *s = &out[which[k]];
        double product = 1.0;
        int there = 0;
        memcpy(z + states, row + readings, (size_t)(columns - 1 - states) * sizeof *z);
        for (int i = 0; i < rows; i++) {
            v[i] = 0.0;
            for (int j = 0; j < columns; j++)
                v[i] += s->mean[i][j] * z[j];
        }
        joint(rows, states, s, P, J);
        for (int c = rows - 1; c >= states; c--) { /* the readings, one given the others */
            double error = row[c - states] - v[c];
            if (isnan(error))
                continue;
            if (!(J[c][c] > 0.0))
                return NAN;
            product *= J[c][c];
            squares += error * error / J[c][c];
            there++;
            for (int i = 0; i < c; i++) {
                double gain = J[c][i] / J[c][c];
                v[i] += gain * error;
                for (int j = 0; j <= i; j++)
                    J[i][j] -= gain * J[c][j];
            }
        }
        logs += log(product);
        counted += there;
        int constant = there == readings && settled(states, J, P);
        for (int i = 0; i < states; i++) {
            z[i] = v[i];
            for (int j = 0; j <= i; j++)
                P[i][j] = P[j][i] = J[i][j];
        }
        if (constant && k + 1 < n) {
            int64_t taken;
            close_loop(rows, states, columns, s, J, closed);
            taken = run_settled(rows, states, columns, closed, row + width, which + k + 1,
                                n - k - 1, z, &squares);
            logs += (double)taken * log(product);
            counted += (double)(taken * readings);
            k += taken;
        }
    }
    return 0.5 * (logs + squares + counted * log(2.0 * acos(-1.0)));
}
