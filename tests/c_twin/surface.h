/* The calm surface above the boat, compression and layers: trainer/core/sea/free_surface.py,
   ballast/buoyancy.py. */

static int cell(const double *grid, int count, double value, double *where)
{
    int low = 0;
    while (low < count - 2 && value >= grid[low + 1])
        low++;
    *where = clamped((value - grid[low]) / (grid[low + 1] - grid[low]), 0.0, 1.0);
    return low;
}

static double between(const double *row, const double *next, double along, double across)
{
    double first = row[0] + across * (row[1] - row[0]);
    double second = next[0] + across * (next[1] - next[0]);
    return first + along * (second - first);
}

static void surface_forces(const struct vessel *c, const struct state *s, double *force)
{
    int speeds = (int)c->surface_speeds, depths = (int)c->surface_depths;
    if (depths == 0 || s->z >= c->surface_depth[depths - 1])
        return;
    double along, across;
    int row = cell(c->surface_speed, speeds, fabs(s->u), &along);
    int column = cell(c->surface_depth, depths, s->z, &across);
    double square = s->u * s->u;
    const double(*Z)[SURFACE_DEPTHS] = c->surface_Z, (*M)[SURFACE_DEPTHS] = c->surface_M;
    force[2] += square * between(&Z[row][column], &Z[row + 1][column], along, across);
    force[4] += square * between(&M[row][column], &M[row + 1][column], along, across);
    const double *Z_w = c->surface_Z_w + column, *M_w = c->surface_M_w + column;
    double slant = s->u * s->w;
    force[2] += slant * (Z_w[0] + across * (Z_w[1] - Z_w[0]));
    force[4] += slant * (M_w[0] + across * (M_w[1] - M_w[0]));
}

static double segment(double height)
{
    double t = clamped(height, 0.0, 1.0);
    double part = least(t, 1.0 - t);
    double share = SMALL_SEGMENT * part * sqrt(part) * (1.0 - SEGMENT_SLOPE * part);
    return t <= 0.5 ? share : 1.0 - share;
}

static double excess_density(const struct vessel *c, double depth)
{
    int last = (int)c->layers - 1;
    if (last < 0)
        return 0.0;
    const double *at = c->layer_depth, *density = c->layer_density;
    if (depth <= at[0])
        return density[0];
    for (int i = 0; i < last; i++)
        if (depth < at[i + 1]) {
            double share = (depth - at[i]) / (at[i + 1] - at[i]);
            return density[i] + share * (density[i + 1] - density[i]);
        }
    return density[last];
}

static double submerged_change(const struct vessel *c, double depth)
{
    double squeezed = c->g * c->compressibility * (most(depth, 0.0) - c->reference_depth);
    return c->buoyancy * excess_density(c, depth) / c->rho - squeezed;
}

static void add_compression(const struct vessel *c, const struct state *s, double *force)
{
    if (c->compressibility == 0.0 && c->layers == 0.0)
        return;
    double cos_th, sin_th, cos_phi, sin_phi;
    cosine_and_sine(s->theta, &cos_th, &sin_th);
    cosine_and_sine(s->phi, &cos_phi, &sin_phi);
    double down_x = -sin_th, down_y = cos_th * sin_phi, down_z = cos_th * cos_phi;
    double heavy = -submerged_change(c, s->z);
    double x = heavy * c->x_b, z = heavy * c->z_b;
    force[0] += heavy * down_x;
    force[1] += heavy * down_y;
    force[2] += heavy * down_z;
    force[3] -= z * down_y;
    force[4] += z * down_x - x * down_z;
    force[5] += x * down_y;
    if (c->y_b != 0.0) {
        force[3] += heavy * c->y_b * down_z;
        force[5] -= heavy * c->y_b * down_x;
    }
}
