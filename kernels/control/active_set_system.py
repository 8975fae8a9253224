"""Native code: the point of an active set of the QP of a choice of modes, and its multipliers.

With B = [N; -G of the active rows] and F the controls off their bounds, whose curvatures are D_F,
the multipliers y of B solve

    S y = B x_0 + (0, h),   S = B_F D_F^-1 B_F' + diag(I, 0),   x_F = -D_F^-1 (c + B' y)_F

where x_0 has the controls at their bounds, and -c / D elsewhere. Members of the local class of
``contact_search``.
"""

KKT = """
    // Row j of B, (nu,), and its sign.
    const double* row_of(int j) const {
        return j < q ? outputs + j * w + 1 : rows + active[j - q] * w + 1;
    }

    // to = B' y over all controls.
    APART void combine(const double* y, double* to) const {
        for (int i = 0; i < nu; ++i) to[i] = 0.0;
        for (int j = 0; j < size; ++j) add(nu, j < q ? y[j] : -y[j], row_of(j), to);
    }

    // Entries of S in row j, up to the diagonal.
    APART void fill_row(int j) {
        const double* own = row_of(j);
        for (int i = 0; i < nu; ++i) line[i] = at_bound[i] ? 0.0 : own[i] * inverse[i];
        for (int k = 0; k <= j; ++k) {
            const double sum = dot(nu, line, row_of(k));
            normal[j * wide + k] = (j < q) == (k < q) ? sum : -sum;
        }
        if (j < q) normal[j * wide + j] += 1.0;
    }

    // U with U'U = S, by rows, whose diagonal holds inverses; false where a row depends on others.
    APART bool factorise_set() {
        for (int j = 0; j < size; ++j)
            if (!append_column(j, normal + j * wide)) return false;
        return true;
    }

    // The column of U that a further row of S makes, which is used up; false where it depends on
    // the others.
    APART bool append_column(int n, double* row) {
        double rest = row[n];
        for (int k = 0; k < n; ++k) {
            const double* own = upper_factor + k * wide;
            const double share = row[k] * own[k];
            for (int i = k + 1; i < n; ++i) row[i] -= share * own[i];
            upper_factor[k * wide + n] = share;
            rest -= share * share;
        }
        if (!(rest > 0.01 * DEPENDENT * row[n])) return false;
        upper_factor[n * wide + n] = 1.0 / root_of(rest);
        return true;
    }

    // U of U'U + sign v v' from a row on, using v up; false where much would cancel (Gill, Golub,
    // Murray and Saunders 1974).
    APART bool change_factor(int from, double sign, double* v) {
        for (int k = from; k < size; ++k) {
            double* own = upper_factor + k * wide;
            const double share = v[k] * own[k], squared_ratio = 1.0 + sign * share * share;
            if (!(squared_ratio > CANCELS)) return false;
            const double ratio = root_of(squared_ratio), inverse_ratio = 1.0 / ratio;
            const double along = sign * share;
            own[k] *= inverse_ratio;
            for (int i = k + 1; i < size; ++i) {
                own[i] = (own[i] + along * v[i]) * inverse_ratio;
                v[i] = ratio * v[i] - share * own[i];
            }
        }
        return true;
    }

    // A control leaves the free ones (sign -1) or joins them (1).
    APART bool shift_control(int i, double sign) {
        const double root = root_of(inverse[i]);
        for (int j = 0; j < size; ++j) line[j] = (j < q ? root : -root) * row_of(j)[i];
        return change_factor(0, sign, line) || renew();
    }

    // S and U anew, where rounding has spoilt them.
    APART bool renew() {
        for (int j = 0; j < size; ++j) fill_row(j);
        return factorise_set();
    }

    APART void solve_normal(double* y) const {
        for (int k = 0; k < size; ++k) {
            const double* own = upper_factor + k * wide;
            const double known = y[k] *= own[k];
            for (int i = k + 1; i < size; ++i) y[i] -= known * own[i];
        }
        for (int k = size - 1; k >= 0; --k) {
            const double* own = upper_factor + k * wide;
            double sum = y[k];
            for (int i = k + 1; i < size; ++i) sum -= own[i] * y[i];
            y[k] = sum * own[k];
        }
    }

    // The point of the present active set and its multipliers; false where rows depend.
    APART bool solve_set() {
        if (!renew()) return false;
        for (int i = 0; i < nu; ++i) {
            x[i] = at_bound[i] ? (at_bound[i] < 0 ? low[i] : high[i]) : -linear[i] * inverse[i];
            force[i] = 0.0;
        }
        for (int j = 0; j < size; ++j) {
            const double along = dot(nu, row_of(j), x);
            weights[j] = j < q ? along : -rows[active[j - q] * w] - along;
        }
        solve_normal(weights);
        combine(weights, force);
        for (int i = 0; i < nu; ++i) {
            if (!at_bound[i]) x[i] -= force[i] * inverse[i];
            const double pull = curve[i] * x[i] + linear[i] + force[i];
            bound_weight[i] = at_bound[i] < 0 ? pull : -pull;
        }
        return true;
    }
"""
