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

    // A control leaves the free ones (sign -1) or joins them (1).
    APART void shift_normal(int i, double sign) {
        for (int j = 0; j < size; ++j) line[j] = j < q ? row_of(j)[i] : -row_of(j)[i];
        for (int j = 0; j < size; ++j)
            add(j + 1, sign * inverse[i] * line[j], line, normal + j * wide);
    }

    // L with L L' = S; false where a row depends on others.
    APART bool cholesky() {
        for (int j = 0; j < size; ++j) {
            double* own = lower_factor + j * wide;
            for (int k = 0; k < j; ++k) {
                const double* other = lower_factor + k * wide;
                own[k] = (normal[j * wide + k] - dot(k, own, other)) * other[k];
            }
            const double pivot = normal[j * wide + j] - dot(j, own, own);
            if (!(pivot > 0.01 * DEPENDENT * normal[j * wide + j])) return false;
            // the diagonal holds its inverse
            own[j] = 1.0 / root_of(pivot);
        }
        return true;
    }

    // The same after a change of ``normal``, which is summed up anew where rounding has spoilt it.
    APART bool renew() {
        if (cholesky()) return true;
        for (int j = 0; j < size; ++j) fill_row(j);
        return cholesky();
    }

    APART void solve_normal(double* y) const {
        for (int j = 0; j < size; ++j) {
            const double* own = lower_factor + j * wide;
            y[j] = (y[j] - dot(j, own, y)) * own[j];
        }
        for (int j = size - 1; j >= 0; --j) {
            const double* own = lower_factor + j * wide;
            y[j] *= own[j];
            add(j, -y[j], own, y);
        }
    }

    // The point of the present active set and its multipliers; false where rows depend.
    APART bool solve_set() {
        for (int j = 0; j < size; ++j) fill_row(j);
        if (!cholesky()) return false;
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
