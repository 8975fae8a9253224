"""Native code: the point found in the problem's own units, with residuals computed anew.

What ``complementarity_form``, ``kkt_residual`` and the end of a solve do. Members of the local
class of ``contact_search``.
"""

POINT = """
    APART void finish(int v) {
        const double *scaled = visit_controls + nu * v, *points = point + 6 * K * v;
        feasibility = 0.0;
        for (int j = 0; j < nu; ++j) {
            controls[j] = min_of(max_of(scaled[j] * control_scale[j], lower[j]), upper[j]);
            feasibility = max_of(feasibility, lower[j] - controls[j]);
            feasibility = max_of(feasibility, controls[j] - upper[j]);
        }
        for (int j = 0; j < c; ++j) impulses[j] = points[6 * (j / 3) + j % 3] * impulse;
        for (int i = 0; i < c; ++i)
            speeds[i] = offset[i] + dot(nu, by_controls + i * nu, controls)
                + dot(c, by_forces + i * c, impulses);
        objective = constant;
        for (int j = 0; j < nu; ++j)
            objective += (0.5 * diagonal[j] * controls[j] + gradient[j]) * controls[j];
        objective += dot(c, gradient + nu, impulses);
        for (int k = 0; k < q; ++k) {
            const double* N = squares + k * (nu + c);
            const double along = dot(nu, N, controls) + dot(c, N + nu, impulses);
            objective += 0.5 * along * along;
        }
        complementarity = 0.0;
        for (int k = 0; k < K; ++k) split(k);
        measure_stationarity(v);
    }

    // Shares of a contact's tangent force along directions, and the pairs' residual.
    APART void split(int k) {
        const double *f = impulses + 3 * k, *u = speeds + 3 * k, *S = factors + m * k;
        double against = 0.0;
        for (int j = 0; j < m; ++j)
            against = max_of(against, -(u[1] * directions[2 * j] + u[2] * directions[2 * j + 1]));
        double* share = shares + (m + 2) * k;
        for (int j = 0; j < m + 2; ++j) share[j] = 0.0;
        share[0] = f[0];
        share[m + 1] = against;
        const bool slides = against > 1e-9 * speed;
        const double slack = 1e-12 * (1.0 + size_of(f[1]) + size_of(f[2]));
        double best = 1e300, share0 = 0.0, share1 = 0.0;
        int one = 0, other = 0;
        for (int i = 0; i < m; ++i)
            for (int j = i + 1; j < m; ++j) {
                if (slides && j - i != 1 && j - i != m - 1) continue;
                const double *a = directions + 2 * i, *b = directions + 2 * j;
                const double area = a[0] * b[1] - a[1] * b[0];
                if (!(size_of(area) > 1e-12)) continue;
                const double x0 = (b[1] * f[1] - b[0] * f[2]) / area / S[i];
                const double x1 = (a[0] * f[2] - a[1] * f[1]) / area / S[j];
                const double lack = max_of(max_of(-x0, -x1), 0.0);
                const double cost = (lack <= slack ? 0.0 : 1e6 * lack) + size_of(x0) + size_of(x1);
                if (cost < best) best = cost, one = i, other = j, share0 = x0, share1 = x1;
            }
        share[1 + one] = share0;
        share[1 + other] = share1;
        double spare = friction[k] * f[0];
        for (int j = 1; j <= m; ++j) spare -= share[j];
        pair(f[0] / impulse, u[0] / speed);
        pair(against / speed, spare / impulse);
        for (int j = 0; j < m; ++j) {
            const double along = u[1] * directions[2 * j] + u[2] * directions[2 * j + 1] + against;
            pair(share[1 + j] / impulse, along / speed);
        }
    }

    void pair(double left, double right) {
        complementarity = max_of(complementarity, size_of(min_of(left, right)));
    }

    // The KKT residual, and the multipliers of contacts and bounds, in scaled units.
    APART void measure_stationarity(int v) {
        const double* points = point + 6 * K * v;
        const double* u = visit_controls + nu * v;
        const int* modes = visit_modes + K * v;
        scaled_value(v);
        double worst = 0.0;
        for (int j = 0; j < nu; ++j) rest[j] = curve[j] * u[j] + slope[j];
        for (int k = 0; k < q; ++k) add(nu, squared[k], factor + k * (nu + c), rest);
        for (int i = 0; i < c; ++i) {
            const double weight = multiplier[6 * K * v + 6 * (i / 3) + 3 + i % 3];
            add(nu, -weight, free_velocity + i * w + 1, rest);
            add(c, -weight, delassus + i * c, spread);
        }
        for (int j = 0; j < nu; ++j) {
            double off = rest[j];
            if (u[j] <= low[j] + AT_BOUND) off = min_of(off, 0.0);
            if (u[j] >= high[j] - AT_BOUND) off = max_of(off, 0.0);
            worst = max_of(worst, size_of(off));
        }
        for (int k = 0; k < K; ++k) {
            double* to = weighed_contacts + 6 * k;
            double product = 0.0;
            for (int a = 0; a < 3; ++a) {
                to[a] = spread[3 * k + a];
                to[3 + a] = multiplier[6 * K * v + 6 * k + 3 + a];
                product += to[a] * points[6 * k + a] + to[3 + a] * points[6 * k + 3 + a];
            }
            worst = max_of(worst, size_of(product));
            const double* own = rays + 6 * s * (k * M + modes[k]);
            for (int i = 0; i < s; ++i, own += 6) worst = max_of(worst, -dot(6, own, to));
        }
        kkt = worst;
    }
"""
