/* The wide set, for any direction of the flow: trainer/core/wide.py, the mass of full.py. */

static void add_ideal_fluid(
    const struct vessel *c, double dry, const struct state *s, double *force)
{
    double u = s->u, v = s->v, w = s->w, p = s->p, q = s->q, r = s->r;
    double sail = dry * c->sail_mass;
    double m22 = c->m22 - sail, m24 = c->m24 + sail * c->strip_z;
    double m44 = c->m44 - sail * c->strip_z * c->strip_z, m26 = c->m26 - sail * c->strip_x;
    double along = c->m11 * u;
    double aside = m22 * v + m24 * p + m26 * r;
    double down = c->m33 * w + c->m35 * q;
    double roll = m24 * v + m44 * p + c->m46 * r;
    double pitch = c->m35 * w + c->m55 * q;
    double yaw = m26 * v + c->m46 * p + c->m66 * r;
    force[0] += r * aside - q * down;
    force[1] += p * down - r * along;
    force[2] += q * along - p * aside;
    force[3] += r * pitch - q * yaw + w * aside - v * down;
    force[4] += p * yaw - r * roll + u * down - w * along;
    force[5] += q * roll - p * pitch + v * along - u * aside;
}

static void add_viscous(const struct vessel *c, const struct state *s, double *force)
{
    double u = s->u, v = s->v, w = s->w, p = s->p, q = s->q, r = s->r;
    int way = u >= 0.0 ? 0 : 1;
    double size = fabs(u);
    for (int row = 0; row < 3; row++) {
        const double *d = c->lateral[way][row];
        force[1 + 2 * row] += size * (d[0] * v + d[1] * p + d[2] * r);
    }
    for (int row = 0; row < 2; row++) {
        const double *d = c->vertical[way][row];
        force[2 + 2 * row] += size * (d[0] * w + d[1] * q);
    }
    double speed = sqrt(u * u + v * v + w * w);
    force[2] += c->Z_star * u * u;
    force[3] += ((speed - size) * c->roll_damping + c->roll_drag * fabs(p)) * p;
    force[3] += c->K_star * s->u_c * fabs(s->u_c);
    force[4] += c->M_star * u * u;
}

static double surface_effect(const struct vessel *c, int surface, const struct state *s)
{
    double effect = 1.0, furthest = c->stall_ahead[surface];
    if (s->u < 0.0) {
        effect = c->astern_effect;
        furthest = c->stall_astern[surface];
    }
    return s->u * fabs(s->u) * effect * clamped(s->surface[surface], -furthest, furthest);
}

static void add_surfaces(const struct vessel *c, const struct state *s, double *force)
{
    double rudder = surface_effect(c, RUDDER, s);
    double stern = surface_effect(c, STERN, s), bow = surface_effect(c, BOW, s);
    double drag = 0.0;
    for (int i = 0; i < 3; i++)
        drag += c->plane_drag[i] * s->surface[i] * s->surface[i];
    force[0] += s->u * fabs(s->u) * drag;
    force[1] += c->Y_dr * rudder;
    force[2] += c->Z_ds * stern + c->Z_db * bow;
    force[3] += c->K_dr * rudder;
    force[4] += c->M_ds * stern + c->M_db * bow;
    force[5] += c->N_dr * rudder;
}

static void wide_forces(const struct vessel *c, const struct state *s, double *force)
{
    double dry = dry_sail(c, s);
    body_forces(c, s, force);
    add_weight(c, s, force);
    add_ideal_fluid(c, dry, s, force);
    add_viscous(c, s, force);
    add_hull_strips(c, s, force);
    add_tail_and_sail(c, s, force);
    add_surfaces(c, s, force);
    force[0] += s->u < 0.0 ? thrust_astern(c, s) : wide_thrust(c, s);
}

static void full_inertia(const struct vessel *c, const struct state *s, double (*out)[6])
{
    double m = c->mass + (s->weight - c->weight) / c->g;
    double m_x = m * s->x_g, m_y = m * s->y_g, m_z = m * s->z_g;
    double matrix[6][6] = {
        {m - c->X_udot, 0.0, 0.0, 0.0, m_z, -m * s->y_g},
        {0.0, m - c->Y_vdot, 0.0, -c->Y_pdot - m_z, 0.0, -c->Y_rdot + m_x},
        {0.0, 0.0, m - c->Z_wdot, m_y, -c->Z_qdot - m_x, 0.0},
        {0.0, -c->K_vdot - m_z, m_y, c->I_x - c->K_pdot, -c->I_xy, -c->I_xz - c->K_rdot},
        {m_z, 0.0, -c->M_wdot - m_x, -c->I_xy, c->I_y - c->M_qdot, -c->I_yz},
        {-m * s->y_g, -c->N_vdot + m_x, 0.0, -c->I_xz - c->N_pdot, -c->I_yz, c->I_z - c->N_rdot},
    };
    memcpy(out, matrix, sizeof matrix);
}

static void make_symmetric(double (*out)[6])
{
    for (int i = 0; i < 6; i++)
        for (int j = 0; j < i; j++)
            out[i][j] = out[j][i] = 0.5 * (out[i][j] + out[j][i]);
}

static void wide_accelerations(
    const struct vessel *c, const struct state *s, struct scratch *work, const double *outer)
{
    wide_forces(c, s, work->force);
    for (int i = 0; i < 6; i++)
        work->force[i] += outer[i];
    full_inertia(c, s, work->inertia);
    make_symmetric(work->inertia);
    exact(work->inertia, work->force, work->system, work->wide);
}

static void correct(
    const struct vessel *c, struct state *s, struct scratch *work, const double *outer)
{
    double share = wide_share(c, s);
    wide_accelerations(c, s, work, outer);
    for (int i = 0; i < 6; i++) {
        if (share < 1.0)
            s->rates[i] = (1.0 - share) * s->rates[i] + share * work->wide[i];
        else
            s->rates[i] = work->wide[i];
    }
}
