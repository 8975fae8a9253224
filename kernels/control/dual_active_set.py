"""Native code: a dual active set method for the QP of one choice of contact modes.

    minimise 1/2 u'(D + N'N) u + c'u   subject to   G u >= h,  low <= u <= high

by Goldfarb and Idnani (1983). What is known of D + N'N is put to use: controls at a bound are left
out, so that a step factorises a matrix of the size of N's rows and the active rows of G alone
(``active_set_system``). It begins with the bounds that were active in the QP before, less those
whose multipliers have the wrong sign. Members of the local class of ``contact_search``.
"""

ACTIVE_SET = """
    // Row j leaves the active ones: its column leaves U, and the rows below carry its own row.
    APART void drop_row(int j) {
        const double* gone = upper_factor + j * wide;
        for (int i = j + 1; i < size; ++i) line[i - 1] = gone[i];
        for (int k = 0; k + 1 < size; ++k) {
            const double* from = upper_factor + (k < j ? k : k + 1) * wide + 1;
            double* to = upper_factor + k * wide;
            for (int i = k < j ? j : k; i + 1 < size; ++i) to[i] = from[i];
        }
        for (int k = j; k + 1 < size; ++k) {
            weights[k] = weights[k + 1];
            active[k - q] = active[k - q + 1];
        }
        --size;
        change_factor(j, 1.0, line);
    }

    // The active set of a visit, in the rows of another one: those of contacts of other modes are
    // left out.
    APART void recall_set(int v, int origin) {
        copy_whole(nu, visit_bounds + origin * nu, at_bound);
        for (int i = 0; i < count && size < wide; ++i) {
            const int k = row_place[i] / r;
            if (visit_modes[K * v + k] != visit_modes[K * origin + k]) continue;
            bool was_active = false;
            for (int j = 0; j < row_count[origin]; ++j)
                was_active = was_active || visit_rows[origin * wide + j] == row_place[i];
            if (was_active) active[size++ - q] = i;
        }
    }

    APART void keep_set(int v) {
        copy_whole(nu, at_bound, visit_bounds + v * nu);
        row_count[v] = size - q;
        for (int j = q; j < size; ++j) visit_rows[v * wide + j - q] = row_place[active[j - q]];
    }

    // A set whose multipliers have the right sign, out of that of an earlier QP.
    APART bool begin_set(int v, int origin) {
        size = q;
        if (origin >= 0) recall_set(v, origin);
        for (int round = 0; round < 8; ++round) {
            if (!solve_set()) {
                if (size == q) break;
                size = q;
                continue;
            }
            int wrong = 0;
            for (int i = 0; i < nu; ++i)
                if (at_bound[i] && !(bound_weight[i] >= 0.0)) at_bound[i] = 0, ++wrong;
            int kept = q;
            for (int j = q; j < size; ++j)
                if (weights[j] >= 0.0) active[kept++ - q] = active[j - q];
            wrong += size - kept;
            size = kept;
            if (!wrong) return true;
        }
        size = q;
        for (int i = 0; i < nu; ++i) at_bound[i] = 0;
        return solve_set();
    }

    // The objective at the point of the active set, which no point that obeys all falls below.
    double dual_value() const {
        double sum = 0.0;
        for (int i = 0; i < nu; ++i) sum += (0.5 * curve[i] * x[i] + linear[i]) * x[i];
        for (int j = 0; j < q; ++j) {
            const double along = dot(nu, outputs + j * w + 1, x);
            sum += 0.5 * along * along;
        }
        return base_value + sum;
    }

    // The condition that is violated most: a control (and its side) or a row; 0 where none is.
    APART int worst_violation(double& most) {
        int found = 0;
        most = VIOLATED;
        for (int i = 0; i < nu; ++i) {
            if (at_bound[i]) continue;
            if (low[i] - x[i] > most) most = low[i] - x[i], found = -(i + 1);
            if (x[i] - high[i] > most) most = x[i] - high[i], found = i + 1;
        }
        for (int i = 0; i < count; ++i) {
            const double miss = -rows[i * w] - dot(nu, rows + i * w + 1, x);
            if (miss > most) {
                bool held = false;
                for (int j = q; j < size; ++j) held = held || active[j - q] == i;
                if (!held) most = miss, found = nu + 1 + i;
            }
        }
        return found;
    }

    // z, the way of x per unit of the condition's multiplier, and the change of all multipliers.
    // Returns the way's component along the condition's normal.
    APART double direction(int condition) {
        const bool is_row = condition > nu;
        const double* row = is_row ? rows + (condition - nu - 1) * w + 1 : 0;
        const int own = is_row ? -1 : (condition < 0 ? -condition : condition) - 1;
        const double sign = condition < 0 ? 1.0 : -1.0;
        double whole;
        if (is_row) {
            for (int i = 0; i < nu; ++i) line[i] = at_bound[i] ? 0.0 : row[i] * inverse[i];
            whole = dot(nu, line, row);
            for (int j = 0; j < size; ++j)
                change[j] = j < q ? dot(nu, line, row_of(j)) : -dot(nu, line, row_of(j));
        } else {
            whole = inverse[own];
            for (int j = 0; j < size; ++j)
                change[j] = (j < q ? sign : -sign) * row_of(j)[own] * inverse[own];
        }
        for (int j = 0; j < size; ++j) line[j] = change[j];
        solve_normal(change);
        const double along = whole - dot(size, line, change);
        combine(change, force);
        for (int i = 0; i < nu; ++i) {
            const double rest = (is_row ? row[i] : (i == own ? sign : 0.0)) - force[i];
            way[i] = at_bound[i] ? 0.0 : rest * inverse[i];
            bound_change[i] = at_bound[i] < 0 ? -rest : rest;
        }
        return along > DEPENDENT * whole ? along : 0.0;
    }

    // Adds one violated condition, dropping what stands in its way: 1, or 0 where no point obeys
    // it and -1 where rounding or the budget ends the method.
    APART int add_condition(int condition, double miss) {
        double own = 0.0;
        for (;;) {
            if (++rounds > MOST_ROUNDS) return -1;
            const double along = direction(condition);
            double most = 1e300;
            int blocking = -1;
            for (int i = 0; i < nu; ++i)
                if (at_bound[i] && bound_change[i] < -TINY
                    && bound_weight[i] < -most * bound_change[i])
                    most = bound_weight[i] / -bound_change[i], blocking = i;
            for (int j = q; j < size; ++j)
                if (change[j] < -TINY && weights[j] < -most * change[j])
                    most = weights[j] / -change[j], blocking = nu + j;
            const double whole = along > 0.0 ? miss / along : 1e300;
            if (most >= 1e300 && whole >= 1e300) return 0;
            const bool arrives = whole <= most;
            const double step = arrives ? whole : most;
            for (int j = 0; j < size; ++j) weights[j] += step * change[j];
            for (int i = 0; i < nu; ++i)
                if (at_bound[i]) bound_weight[i] += step * bound_change[i];
            own += step;
            if (along > 0.0) {
                dual += step * along * (own - 0.5 * step);
                add(nu, step, way, x);
                miss -= step * along;
            }
            if (arrives) return take_up(condition, own);
            if (blocking < nu) {
                at_bound[blocking] = 0;
                if (!shift_control(blocking, 1.0)) return -1;
            } else {
                drop_row(blocking - nu);
            }
        }
    }

    APART int take_up(int condition, double own) {
        if (condition > nu) {
            if (size == wide) return -1;
            active[size - q] = condition - nu - 1;
            weights[size] = own;
            fill_row(size++);
            return append_column(size - 1, normal + (size - 1) * wide) || renew() ? 1 : -1;
        }
        const int i = (condition < 0 ? -condition : condition) - 1;
        at_bound[i] = condition < 0 ? -1 : 1;
        bound_weight[i] = own;
        x[i] = condition < 0 ? low[i] : high[i];
        return shift_control(i, -1.0) ? 1 : -1;
    }

    // 1 with the minimiser in x and the multipliers of its set, 0 without a point or with one above
    // a limit, -1 on failure.
    APART int minimise(double highest, int v, int origin) {
        rounds = 0;
        if (!begin_set(v, origin)) return -1;
        dual = dual_value();
        for (;;) {
            if (dual > highest) return 0;
            double miss;
            const int condition = worst_violation(miss);
            if (!condition) break;
            const int done = add_condition(condition, miss);
            if (done < 1) return done;
        }
        // once more without the rounding of the way here
        if (!solve_set()) return -1;
        dual_residual = 0.0;
        for (int i = 0; i < nu; ++i) {
            const double pull = curve[i] * x[i] + linear[i] + force[i];
            const double off = !at_bound[i] ? size_of(pull) : -bound_weight[i];
            dual_residual = max_of(dual_residual, off);
        }
        for (int j = q; j < size; ++j) dual_residual = max_of(dual_residual, -weights[j]);
        double miss;
        worst_violation(miss);
        for (int i = 0; i < nu; ++i) x[i] = max_of(low[i], min_of(high[i], x[i]));
        return dual_residual <= ACCEPTED && miss <= ACCEPTED ? 1 : -1;
    }

    // The minimum of the QP without rows and bounds, in the scaled objective.
    APART double unconstrained_minimum() {
        for (int i = 0; i < nu; ++i) line[i] = linear[i] * inverse[i];
        double half = dot(nu, line, linear);
        for (int j = 0; j < q; ++j) change[j] = dot(nu, outputs + j * w + 1, line);
        for (int j = 0; j < q; ++j)
            for (int k = 0; k <= j; ++k) {
                const double *a = outputs + j * w + 1, *b = outputs + k * w + 1;
                double sum = 0.0;
                for (int i = 0; i < nu; ++i) sum += a[i] * b[i] * inverse[i];
                normal[j * wide + k] = sum + (j == k);
            }
        size = q;
        if (!factorise_set()) return -1e300;
        for (int j = 0; j < q; ++j) weights[j] = change[j];
        solve_normal(weights);
        return base_value - 0.5 * (half - dot(q, change, weights));
    }
"""
