"""Native code: the QP of a choice of modes, its point and the multipliers there.

What ``mode_qp`` of the QPCC solver does. A choice that was tried is a visit; its numbers are kept.
Members of the local class of ``contact_search``.
"""

VISITS = """
    double margin(int v) const {
        return PROGRESS * size_of(value[v]) + ROUNDING * (value_scale + size_of(constant));
    }

    // The least product of each mode's rows, (rows, 6) each, with a contact's vector.
    APART void least_products(const double* matrices, int each, const double* vectors,
                              double* to) const {
        for (int k = 0; k < K; ++k) {
            const double* v = vectors + 6 * k;
            for (int j = 0; j < M; ++j) {
                const double* own = matrices + 6 * each * (k * M + j);
                double least = 1e300;
                for (int i = 0; i < each; ++i, own += 6) {
                    const double product = own[0] * v[0] + own[1] * v[1] + own[2] * v[2]
                        + own[3] * v[3] + own[4] * v[4] + own[5] * v[5];
                    least = min_of(least, product);
                }
                to[k * M + j] = least;
            }
        }
    }

    // Number of the visit to some modes, whose QP is solved the first time, from the active set of
    // an earlier visit (-1: of the last solve); -1 where that has no point, is above the limit, or
    // the budget is spent.
    APART int visit(const int* given, double limit, int origin) {
        if (failed) return -1;
        int* modes = visit_modes + K * visits;
        for (int k = 0; k < K; ++k) modes[k] = valid[k * M + given[k]] ? given[k] : SLIDE;
        for (int v = 0; v < visits; ++v) {
            bool same = true;
            for (int k = 0; k < K; ++k) same = same && visit_modes[K * v + k] == modes[k];
            if (same) return solved[v] ? v : -1;
        }
        if (spent()) return -1;
        if (visits == most_visits - 1) return leave(), -1;
        solved[visits] = weighed[visits] = reached[visits] = 0;
        solved[visits] = solve_modes(visits, limit, origin);
        return solved[visits++] ? visits - 1 : -1;
    }

    // What this code cannot solve ends the solve, or, once there is a minimum, is passed over.
    void leave() { failed = failed || !exploring; }

    bool spent() const { return qps >= most_qps; }

    APART int solve_modes(int v, double limit, int origin) {
        if (!eliminate(visit_modes + K * v)) {
            // redundant contacts: without a point where they disagree
            if (!disagree(visit_modes + K * v)) leave();
            return 0;
        }
        const double highest = limit < 1e300 ? (limit - constant) / value_scale : 1e300;
        if (limit < 1e300 && unconstrained_minimum() > highest) return 0;
        ++qps;
        const int done = minimise(highest, v, origin);
        if (done < 0) return leave(), 0;
        if (!done) return 0;
        keep(v);
        keep_set(v);
        return !(limit < 1e300 && value[v] > limit);
    }

    // The point of the QP just solved, its value and the multipliers of its contacts.
    APART void keep(int v) {
        double* controls = visit_controls + nu * v;
        copy(nu, x, controls);
        for (int k = 0; k < K; ++k)
            for (int a = 0; a < 3; ++a) {
                const double *f = forces + (3 * k + a) * w, *u = velocities + (3 * k + a) * w;
                point[6 * K * v + 6 * k + a] = f[0] + dot(nu, f + 1, x);
                point[6 * K * v + 6 * k + 3 + a] = u[0] + dot(nu, u + 1, x);
            }
        stationarity[v] = dual_residual;
        value[v] = scaled_value(v) * value_scale + constant;
        weigh(v);
    }

    // 1/2 z'Hz + c'z at a visit; ``spread`` keeps H z + c in the forces.
    APART double scaled_value(int v) {
        const double *u = visit_controls + nu * v, *f = point + 6 * K * v;
        double sum = 0.0;
        for (int j = 0; j < nu; ++j) sum += (0.5 * curve[j] * u[j] + slope[j]) * u[j];
        for (int j = 0; j < c; ++j) {
            spread[j] = slope[nu + j];
            sum += slope[nu + j] * f[6 * (j / 3) + j % 3];
        }
        for (int k = 0; k < q; ++k) {
            const double* N = factor + k * (nu + c);
            double along = dot(nu, N, u);
            for (int j = 0; j < c; ++j) along += N[nu + j] * f[6 * (j / 3) + j % 3];
            squared[k] = along;
            sum += 0.5 * along * along;
            add(c, along, N + nu, spread);
        }
        return sum;
    }

    // Derivatives of the objective as each contact's (f, w) is shifted, (K, 6).
    APART void weigh(int v) {
        const int* modes = visit_modes + K * v;
        double *by_force = line, *by_velocity = line + c;
        for (int j = 0; j < c; ++j) by_force[j] = spread[j], by_velocity[j] = 0.0;
        for (int j = 0; j < c; ++j) own_force[j] = 0.0;
        for (int j = q; j < size; ++j) {
            const int place = row_place[active[j - q]], k = place / r;
            const double* cone = inequalities + 6 * ((k * M + modes[k]) * r + place % r);
            for (int a = 0; a < 3; ++a) {
                own_force[3 * k + a] += weights[j] * cone[a];
                by_velocity[3 * k + a] += weights[j] * cone[3 + a];
            }
        }
        for (int j = 0; j < c; ++j) add(c, -by_velocity[j], delassus + j * c, by_force);
        for (int k = 0; k < K; ++k)
            for (int i = first[k]; i < first[k + 1]; ++i) {
                const double* E = basis + 9 * (k * M + modes[k]) + (i - first[k]);
                tension[i] = 0.0;
                for (int a = 0; a < 3; ++a)
                    tension[i] += E[3 * a] * (by_force[3 * k + a] - own_force[3 * k + a]);
            }
        solve_transposed(tension);
        for (int k = 0; k < K; ++k)
            for (int i = first[k]; i < first[k + 1]; ++i) {
                const double* T = constraints + 9 * (k * M + modes[k]) + 3 * (i - first[k]);
                for (int a = 0; a < 3; ++a) {
                    by_velocity[3 * k + a] += tension[i] * T[a];
                    add(c, -tension[i] * T[a], delassus + (3 * k + a) * c, by_force);
                }
            }
        double* to = multiplier + 6 * K * v;
        for (int k = 0; k < K; ++k)
            for (int a = 0; a < 3; ++a) {
                to[6 * k + a] = by_force[3 * k + a];
                to[6 * k + 3 + a] = by_velocity[3 * k + a];
            }
    }

    // What a visit's point misses of every mode, and what each mode's rays offer.
    APART void compare(int v) {
        if (weighed[v]) return;
        weighed[v] = 1;
        double *miss = violation + K * M * v, *along = descent + K * M * v;
        least_products(halfspaces, r + 6, point + 6 * K * v, miss);
        least_products(rays, s, multiplier + 6 * K * v, along);
        for (int i = 0; i < K * M; ++i) miss[i] = valid[i] ? -miss[i] : 1e300;
    }
"""
