"""Native code: the contact forces of a choice of modes as affine maps of the controls.

The arithmetic of ``force_elimination`` and ``objective`` of the QPCC solver, without an array made
on the way. Members of the local class of ``contact_search``.
"""

ELIMINATION = """
    // T Wf E and T (w0 + Wu u) of the modes, side by side in ``system`` and ``amplitudes``.
    APART void put_together(const int* modes) {
        p = 0;
        for (int k = 0; k < K; ++k) {
            first[k] = p;
            p += dimensions[k * M + modes[k]];
        }
        first[K] = p;
        for (int k = 0; k < K; ++k)
            for (int i = first[k]; i < first[k + 1]; ++i) {
                const double* T = constraints + 9 * (k * M + modes[k]) + 3 * (i - first[k]);
                const double *W = delassus + 3 * k * c, *v = free_velocity + 3 * k * w;
                for (int j = 0; j < c; ++j)
                    line[j] = T[0] * W[j] + T[1] * W[c + j] + T[2] * W[2 * c + j];
                double* to = amplitudes + i * w;
                for (int j = 0; j < w; ++j)
                    to[j] = T[0] * v[j] + T[1] * v[w + j] + T[2] * v[2 * w + j];
                for (int l = 0; l < K; ++l) {
                    const double* E = basis + 9 * (l * M + modes[l]);
                    for (int j = first[l]; j < first[l + 1]; ++j, ++E)
                        system[i * p + j] = line[3 * l] * E[0] + line[3 * l + 1] * E[3]
                            + line[3 * l + 2] * E[6];
                }
            }
    }

    // L and U of ``system`` by rows exchanged, which the amplitudes follow; false where it is
    // singular, or so close to it that the amplitudes mean nothing.
    APART bool factorise() {
        double largest = 0.0, least = 1e300, norm = 0.0;
        for (int j = 0; j < p; ++j) {
            double sum = 0.0;
            for (int i = 0; i < p; ++i) sum += size_of(system[i * p + j]);
            norm = max_of(norm, sum);
        }
        for (int k = 0; k < p; ++k) {
            int best = k;
            for (int i = k + 1; i < p; ++i)
                if (size_of(system[i * p + k]) > size_of(system[best * p + k])) best = i;
            pivots[k] = best;
            if (best != k) {
                for (int j = 0; j < p; ++j) exchange(system[k * p + j], system[best * p + j]);
                double *own = amplitudes + k * w, *other = amplitudes + best * w;
                for (int j = 0; j < w; ++j) exchange(own[j], other[j]);
            }
            const double pivot = system[k * p + k];
            largest = max_of(largest, size_of(pivot));
            least = min_of(least, size_of(pivot));
            if (!(least > 0.0)) return false;
            for (int i = k + 1; i < p; ++i) {
                const double share = system[i * p + k] / pivot;
                system[i * p + k] = share;
                if (share == 0.0) continue;
                for (int j = k + 1; j < p; ++j) system[i * p + j] -= share * system[k * p + j];
                add(w, -share, amplitudes + k * w, amplitudes + i * w);
            }
        }
        if (least < REGULAR * largest) {
            // one in a hundred: pivots so unequal that the size of the inverse has to tell
            const double inverse_norm = norm_of_inverse();
            if (!(inverse_norm <= GROWTH)) return false;
            if (norm * inverse_norm * SINGULAR > 1.0 && !definite()) return false;
        }
        for (int k = p - 1; k >= 0; --k) {
            double* own = amplitudes + k * w;
            for (int j = k + 1; j < p; ++j) add(w, -system[k * p + j], amplitudes + j * w, own);
            const double inverse = 1.0 / system[k * p + k];
            for (int j = 0; j < w; ++j) own[j] *= inverse;
        }
        return true;
    }

    // y with (T Wf E)' y = ``right``, in place.
    APART void solve_transposed(double* right) {
        for (int k = 0; k < p; ++k) {
            for (int j = 0; j < k; ++j) right[k] -= system[j * p + k] * right[j];
            right[k] /= system[k * p + k];
        }
        for (int k = p - 1; k >= 0; --k)
            for (int j = k + 1; j < p; ++j) right[k] -= system[j * p + k] * right[j];
        for (int k = p - 1; k >= 0; --k) exchange(right[k], right[pivots[k]]);
    }

    // Affine maps of forces, velocities, squares and inequalities; false as ``factorise`` is.
    APART bool eliminate(const int* modes) {
        put_together(modes);
        if (!factorise()) return false;
        for (int i = 0; i < p * w; ++i)
            if (!(size_of(amplitudes[i]) <= GROWTH)) return false;
        for (int i = 0; i < c * w; ++i) forces[i] = 0.0;
        for (int k = 0; k < K; ++k)
            for (int i = first[k]; i < first[k + 1]; ++i) {
                const double* E = basis + 9 * (k * M + modes[k]) + (i - first[k]);
                double* to = forces + 3 * k * w;
                for (int a = 0; a < 3; ++a)
                    if (E[3 * a] != 0.0) add(w, -E[3 * a], amplitudes + i * w, to + a * w);
            }
        copy(c * w, free_velocity, velocities);
        for (int k = 0; k < K; ++k) {
            if (first[k] == first[k + 1]) continue;
            for (int j = 3 * k; j < 3 * k + 3; ++j)
                for (int i = 0; i < c; ++i)
                    add(w, delassus[i * c + j], forces + j * w, velocities + i * w);
        }
        for (int k = 0; k < q; ++k) {
            const double* N = factor + k * (nu + c);
            double* to = outputs + k * w;
            to[0] = 0.0;
            copy(nu, N, to + 1);
            for (int j = 0; j < c; ++j) add(w, N[nu + j], forces + j * w, to);
        }
        count = 0;
        for (int k = 0; k < K; ++k) {
            const int cone = k * M + modes[k];
            for (int i = 0; i < r; ++i) {
                if (!used[cone * r + i]) continue;
                double* to = rows + count * w;
                const double* own = inequalities + 6 * (cone * r + i);
                for (int j = 0; j < w; ++j) to[j] = 0.0;
                for (int a = 0; a < 3; ++a) {
                    if (own[a] != 0.0) add(w, own[a], forces + (3 * k + a) * w, to);
                    if (own[3 + a] != 0.0) add(w, own[3 + a], velocities + (3 * k + a) * w, to);
                }
                row_place[count++] = k * r + i;
            }
        }
        copy(nu, slope, linear);
        base_value = 0.0;
        for (int j = 0; j < c; ++j) {
            add(nu, slope[nu + j], forces + j * w + 1, linear);
            base_value += slope[nu + j] * forces[j * w];
        }
        for (int k = 0; k < q; ++k) {
            add(nu, outputs[k * w], outputs + k * w + 1, linear);
            base_value += 0.5 * outputs[k * w] * outputs[k * w];
        }
        return true;
    }
"""
