/* The compact set, kinematics, holds, surfaces: trainer/core/compact.py, kinematics.py, update.py,
   actuators.py. */

enum { PAST = sizeof(((struct state *)0)->past_rates) / (12 * sizeof(double)) };

static double pitch_roll_sine(int64_t trig, double angle)
{
    if (trig == POLYNOMIAL_TRIGONOMETRY)
        return angle - angle * angle * angle / 6.0;
    return trig == LINEAR_TRIGONOMETRY ? 0.971 * angle : sine(angle);
}

static double pitch_roll_cosine(int64_t trig, double angle)
{
    double square = angle * angle;
    if (trig == POLYNOMIAL_TRIGONOMETRY)
        return 1.0 - square / 2.0 + square * square / 24.0;
    return trig == LINEAR_TRIGONOMETRY ? 1.02 - 0.281 * fabs(angle) : cosine(angle);
}

static void forces(const struct compact *c, int64_t trig, const struct state *s, double *force)
{
    double u = s->u, v = s->v, w = s->w, p = s->p, q = s->q, r = s->r;
    double dr = s->delta_r, ds = s->delta_s, db = s->delta_b;
    double m = c->mass + (s->weight - c->weight) / c->g;
    double m_x = m * s->x_g, m_z = m * s->z_g;
    double cross = sqrt(v * v + w * w), v_cross = v * cross, u_dr = u * dr;
    double sin_th = pitch_roll_sine(trig, s->theta), cos_th = pitch_roll_cosine(trig, s->theta);
    double sin_phi = pitch_roll_sine(trig, s->phi), cos_phi = pitch_roll_cosine(trig, s->phi);
    double athwart = cos_th * sin_phi, below = cos_th * cos_phi;
    double heavy = s->weight - c->buoyancy;
    double righting = s->z_g * s->weight - c->ZB, tilting = s->x_g * s->weight;
    double ahead = v * r - w * q, aside = w * p - u * r, down = u * q - v * p;

    force[0] = m * ahead + m_x * (q * q + r * r) - m_z * r * p
        + u * u * (c->X_drdr * dr * dr + c->X_dsds * ds * ds + c->X_dbdb * db * db)
        + compact_thrust(c, s)
        - heavy * sin_th;
    force[1] = m * aside - q * (m_z * r + m_x * p)
        + u * (c->Y_r * r + c->Y_p * p + c->Y_v * v + c->Y_dr * u_dr)
        + c->Y_vav * v_cross
        + heavy * athwart;
    force[2] = m * down + m_z * (p * p + q * q) - m_x * r * p
        + u * (c->Z_q * q + c->Z_w * w)
        + u * u * (c->Z_star + c->Z_ds * ds + c->Z_db * db)
        + r * (c->Z_rr * r + c->Z_vr * v)
        + c->Z_vv * v * v
        + c->Z_waw * w * cross
        + heavy * below;
    force[3] = u * (c->K_p * p + c->K_v * v)
        + c->K_vav * v_cross
        - c->T4 * (m_z * aside + righting * athwart);
    force[4] = u * (c->M_q * q + c->M_w * w)
        + u * u * (c->M_star + c->M_ds * ds + c->M_db * db)
        + r * (c->M_rp * p + c->M_rr * r + c->M_vr * v)
        + c->M_vv * v * v
        + cross * (c->M_awq * q + c->M_waw * w)
        + c->T5 * (m_z * ahead - m_x * down - tilting * below - righting * sin_th);
    force[5] = u * (c->N_p * p + c->N_r * r + c->N_v * v + c->N_dr * u_dr)
        + c->N_pq * p * q
        + c->N_vav * v_cross
        + c->T6 * (m_x * aside + tilting * athwart);
}

static void further_forces(const struct compact *c, const struct state *s, double *force)
{
    double u = s->u, v = s->v, w = s->w, p = s->p, q = s->q, r = s->r;
    double cross = sqrt(v * v + w * w);
    force[0] += v * (c->X_vr * r + c->X_vv * v)
        + w * (c->X_wq * q + c->X_ww * w)
        + r * (c->X_rr * r + c->X_rp * p)
        + c->X_qq * q * q;
    force[1] += q * (c->Y_pq * p + c->Y_qr * r + c->Y_vq * v)
        + w * (c->Y_wp * p + c->Y_wr * r + c->Y_vw * v);
    force[2] += p * (c->Z_pp * p + c->Z_rp * r + c->Z_vp * v);
    force[3] += q * (c->K_pq * p + c->K_qr * r + c->K_vq * v)
        + w * (c->K_wp * p + c->K_wr * r + c->K_vw * v)
        + u * (c->K_r * r + c->K_star * u)
        + c->K_pap * p * fabs(p);
    force[4] += p * (c->M_pp * p + c->M_vp * v) + c->M_qaq * q * fabs(q);
    force[5] += q * (c->N_qr * r + c->N_vq * v)
        + w * (c->N_wp * p + c->N_wr * r + c->N_vw * v)
        + r * (c->N_rar * fabs(r) + c->N_avr * cross);
}

static void slip_forces(const struct compact *c, const struct state *s, double *force)
{
    double u = s->u, dr = s->delta_r, ds = s->delta_s, slip = s->u_c - u;
    if (c->eta_whole != 0.0) {
        double speed = sqrt(u * u + s->v * s->v + s->w * s->w);
        slip = speed > 0.0 ? u * (s->u_c / speed - 1.0) : 0.0;
    }
    force[0] += slip * u * (c->X_drdr_eta * dr * dr + c->X_dsds_eta * ds * ds);
    force[1] += slip * (c->Y_r_eta * s->r + c->Y_v_eta * s->v + c->Y_dr_eta * u * dr);
    force[2] += slip * (c->Z_q_eta * s->q + c->Z_w_eta * s->w + c->Z_ds_eta * u * ds);
    force[3] += slip * u * c->K_star_eta;
    force[4] += slip * (c->M_q_eta * s->q + c->M_w_eta * s->w + c->M_ds_eta * u * ds);
    force[5] += slip * (c->N_r_eta * s->r + c->N_v_eta * s->v + c->N_dr_eta * u * dr);
}

static int is_off_centre(const struct compact *c, const struct state *s)
{
    return c->off_centre != 0.0 || s->y_g != 0.0;
}

static void off_centre_forces(
    const struct compact *c, int64_t trig, const struct state *s, double *force)
{
    double p = s->p, q = s->q, r = s->r;
    double m_y = (c->mass + (s->weight - c->weight) / c->g) * s->y_g;
    double cos_th = pitch_roll_cosine(trig, s->theta);
    double athwart = cos_th * pitch_roll_sine(trig, s->phi);
    double below = cos_th * pitch_roll_cosine(trig, s->phi);
    double heeling = s->y_g * s->weight - c->YB;
    force[0] -= m_y * p * q;
    force[1] += m_y * (r * r + p * p);
    force[2] -= m_y * r * q;
    force[3] += c->T4
        * (c->I_xz * p * q - c->I_yz * (r * r - q * q) - c->I_xy * p * r
           + m_y * (s->u * q - s->v * p) + heeling * below);
    force[4] += c->T5
        * (c->I_xy * q * r - c->I_xz * (p * p - r * r) - c->I_yz * q * p + c->XB * below);
    force[5] += c->T6
        * (c->I_yz * r * p - c->I_xy * (q * q - p * p) - c->I_xz * r * q
           - m_y * (s->v * r - s->w * q) - c->XB * athwart
           + heeling * pitch_roll_sine(trig, s->theta));
}

static void add_external(const struct compact *c, const double *external, double *force)
{
    force[0] += external[0];
    force[1] += external[1];
    force[2] += external[2];
    force[3] += external[3] * c->T4;
    force[4] += external[4] * c->T5;
    force[5] += external[5] * c->T6;
}

static void lagged(const struct compact *c, const double *force, struct state *s)
{
    double m = c->mass + (s->weight - c->weight) / c->g;
    double m_x = m * s->x_g, m_z = m * s->z_g;
    s->udot = (force[0] - m_z * s->qdot) / (m - c->X_udot);
    s->vdot = (force[1] + (m_z + c->Y_pdot) * s->pdot + (c->Y_rdot - m_x) * s->rdot)
        / (m - c->Y_vdot);
    s->wdot = (force[2] + (m_x + c->Z_qdot) * s->qdot) / (m - c->Z_wdot);
    s->pdot = force[3] + (m_z * c->T4 + c->K_vdot) * s->vdot + c->K_rdot * s->rdot;
    s->qdot = force[4] + (m_x * c->T5 + c->M_wdot) * s->wdot - m_z * c->T5 * s->udot;
    s->rdot = force[5] + (c->N_vdot - m_x * c->T6) * s->vdot + c->N_pdot * s->pdot;
}

static void compact_inertia(const struct compact *c, const struct state *s, double (*out)[6])
{
    double m = c->mass + (s->weight - c->weight) / c->g;
    double m_x = m * s->x_g, m_z = m * s->z_g;
    for (int i = 0; i < 6; i++) {
        for (int j = 0; j < 6; j++)
            out[i][j] = 0.0;
        out[i][i] = 1.0;
    }
    out[0][0] = m - c->X_udot;
    out[0][4] = m_z;
    out[1][1] = m - c->Y_vdot;
    out[1][3] = -(m_z + c->Y_pdot);
    out[1][5] = m_x - c->Y_rdot;
    out[2][2] = m - c->Z_wdot;
    out[2][4] = -(m_x + c->Z_qdot);
    out[3][1] = -(m_z * c->T4 + c->K_vdot);
    out[3][5] = -c->K_rdot;
    out[4][0] = m_z * c->T5;
    out[4][2] = -(m_x * c->T5 + c->M_wdot);
    out[5][1] = m_x * c->T6 - c->N_vdot;
    out[5][3] = -c->N_pdot;
}

static void off_centre_inertia(const struct compact *c, const struct state *s, double (*out)[6])
{
    double m_y = (c->mass + (s->weight - c->weight) / c->g) * s->y_g;
    out[0][5] -= m_y;
    out[2][3] += m_y;
    out[3][2] += m_y * c->T4;
    out[3][4] -= c->I_xy * c->T4;
    out[3][5] -= c->I_xz * c->T4;
    out[4][3] -= c->I_xy * c->T5;
    out[4][5] -= c->I_yz * c->T5;
    out[5][0] -= m_y * c->T6;
    out[5][3] -= c->I_xz * c->T6;
    out[5][4] -= c->I_yz * c->T6;
}

static double guarded(double cos_theta)
{
    if (fabs(cos_theta) >= MIN_PITCH_COSINE)
        return cos_theta;
    return cos_theta >= 0.0 ? MIN_PITCH_COSINE : -MIN_PITCH_COSINE;
}

static void kinematics(int64_t trig, struct state *s)
{
    double sin_phi = pitch_roll_sine(trig, s->phi), cos_phi = pitch_roll_cosine(trig, s->phi);
    double sin_th = pitch_roll_sine(trig, s->theta), cos_th = pitch_roll_cosine(trig, s->theta);
    double cos_psi, sin_psi;
    cosine_and_sine(s->psi, &cos_psi, &sin_psi);
    s->thetadot = s->q * cos_phi - s->r * sin_phi;
    s->psidot = (s->q * sin_phi + s->r * cos_phi) / guarded(cos_th);
    s->phidot = s->p + s->psidot * sin_th;
    double across = s->v * cos_phi - s->w * sin_phi, down = s->v * sin_phi + s->w * cos_phi;
    double along = s->u * cos_th + down * sin_th;
    s->through_north = s->xdot = along * cos_psi - across * sin_psi;
    s->through_east = s->ydot = along * sin_psi + across * cos_psi;
    s->zdot = down * cos_th - s->u * sin_th;
}

static void cast_off(struct state *s)
{
    double *place[2] = {&s->x, &s->y};
    for (int i = 0; i < 2; i++) {
        double jump = *place[i] - s->sailed[i];
        if (s->held_position != 0.0)
            *place[i] = s->sailed[i];
        else if (jump != 0.0)
            for (int back = 0; back < PAST; back++)
                s->past_motion[back][9 + i] += jump;
    }
}

static void make_fast(double x, double y, double z, struct state *s)
{
    s->sailed_x = s->x;
    s->sailed_y = s->y;
    if (s->held_position != 0.0) {
        s->x = x;
        s->y = y;
    }
    if (s->held_depth != 0.0) {
        double descent = s->z - z;
        s->z = z;
        for (int back = 0; back < PAST; back++)
            s->past_motion[back][11] -= descent;
    }
}

static double moved(double angle, double ordered, double limit, double furthest, double share)
{
    double target = ordered > limit ? limit : ordered < -limit ? -limit : ordered;
    double travel = share * (target - angle);
    if (travel > furthest)
        travel = furthest;
    else if (travel < -furthest)
        travel = -furthest;
    return angle + travel;
}

static double told(
    const struct vessel *c, double furthest, int surface, int slot, const struct state *s)
{
    double angle = s->surface[surface], command = s->command[surface];
    if (slot < 0)
        return command;
    double amount = s->casualty_amount[slot];
    int fault = KIND_FAULTS[(int)s->casualty[slot]];
    if (fault == SURFACE_SLOW)
        command = within(command, angle, furthest * (1.0 - amount));
    else if (fault == FOLLOW_UP_LOST)
        command = fabs(command) < AMIDSHIPS_ANGLE ? angle : copysign(c->limit[surface], command);
    else if (fault == SURFACE_FREE)
        command = within(0.0, angle, amount * furthest);
    else
        command = amount;
    return within(command, 0.0, c->limit[surface]);
}

static int servo_of(int surface, const struct state *s)
{
    return s->mode[surface] == NORMAL ? slot_of(SERVO_CODE[surface], s) : -1;
}

static double fed_target(
    const struct vessel *c, double furthest, int surface, double share, const struct state *s)
{
    if (share == 0.0 && c->trail_share > 0.0)
        return 0.0;
    int slot = servo_of(surface, s);
    if (slot >= 0)
        return within(s->casualty_amount[slot], 0.0, c->limit[surface]);
    return told(c, furthest, surface, fault_of(surface, s), s);
}

static void move_fed_surfaces(const struct vessel *c, double h, double share, struct state *s)
{
    double was[3], target[3], furthest[3];
    for (int i = 0; i < 3; i++) {
        double fed = fed_share(c, i, s);
        was[i] = s->surface[i];
        target[i] = fed_target(c, c->surface_rate * h / share, i, fed, s);
        furthest[i] = c->surface_rate * h * (fed > 0.0 ? fed : c->trail_share);
    }
    if (c->x_tail != 0.0) {
        double slower = least(furthest[RUDDER], furthest[STERN]);
        if (fault_of(RUDDER, s) >= 0 || servo_of(RUDDER, s) >= 0)
            target[STERN] = within(target[STERN], 0.0, most(c->limit_s - fabs(target[RUDDER]), 0.0));
        else if (fault_of(STERN, s) >= 0 || servo_of(STERN, s) >= 0)
            target[RUDDER] = within(target[RUDDER], 0.0, most(c->limit_s - fabs(target[STERN]), 0.0));
        double one = s->delta_s + s->delta_r, other = s->delta_s - s->delta_r;
        one = moved(one, target[STERN] + target[RUDDER], c->limit_s, slower, share);
        other = moved(other, target[STERN] - target[RUDDER], c->limit_s, slower, share);
        s->delta_s = 0.5 * (one + other);
        s->delta_r = 0.5 * (one - other);
    } else {
        s->delta_s = moved(s->delta_s, target[STERN], c->limit_s, furthest[STERN], share);
        s->delta_r = moved(s->delta_r, target[RUDDER], c->limit_r, furthest[RUDDER], share);
    }
    s->delta_b = moved(s->delta_b, target[BOW], c->limit_b, furthest[BOW], share);
    draw_oil(
        c, fabs(s->delta_r - was[RUDDER]), fabs(s->delta_s - was[STERN]), fabs(s->delta_b - was[BOW]),
        s);
}

static void move_surfaces(const struct vessel *c, double h, struct state *s)
{
    double share = c->surface_lag > 0.0 ? 1.0 - exponential(-h / c->surface_lag) : 1.0;
    if (s->plant_touched != 0.0) {
        move_fed_surfaces(c, h, share, s);
        return;
    }
    double furthest = c->surface_rate * h;
    int rudder_fault = fault_of(RUDDER, s), stern_fault = fault_of(STERN, s);
    double rudder = told(c, furthest / share, RUDDER, rudder_fault, s);
    double stern = told(c, furthest / share, STERN, stern_fault, s);
    if (c->x_tail != 0.0) {
        if (rudder_fault >= 0)
            stern = within(stern, 0.0, most(c->limit_s - fabs(rudder), 0.0));
        else if (stern_fault >= 0)
            rudder = within(rudder, 0.0, most(c->limit_s - fabs(stern), 0.0));
        double one = s->delta_s + s->delta_r, other = s->delta_s - s->delta_r;
        one = moved(one, stern + rudder, c->limit_s, furthest, share);
        other = moved(other, stern - rudder, c->limit_s, furthest, share);
        s->delta_s = 0.5 * (one + other);
        s->delta_r = 0.5 * (one - other);
    } else {
        s->delta_s = moved(s->delta_s, stern, c->limit_s, furthest, share);
        s->delta_r = moved(s->delta_r, rudder, c->limit_r, furthest, share);
    }
    double bow = told(c, furthest / share, BOW, fault_of(BOW, s), s);
    s->delta_b = moved(s->delta_b, bow, c->limit_b, furthest, share);
}
