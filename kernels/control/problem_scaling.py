"""Native code: a contact problem in units of its own, as ``ScaledContactQPCC`` has them.

A member of the local class of ``contact_search``.
"""

SCALING = """
    // Units of the problem, and all of it in these units, as ScaledContactQPCC has them.
    APART void scale_problem() {
        speed = 0.0;
        for (int j = 0; j < nu; ++j) {
            const double half = 0.5 * (upper[j] - lower[j]);
            const bool ranged = half > 0.0 && half < 1e300;
            control_scale[j] = ranged ? half : 1.0;
            low[j] = lower[j] / control_scale[j];
            high[j] = upper[j] / control_scale[j];
        }
        double mobility = 0.0;
        for (int i = 0; i < c; ++i) {
            double spread = 0.0;
            for (int j = 0; j < nu; ++j) {
                const double reach = by_controls[i * nu + j] * control_scale[j];
                spread += reach * reach;
            }
            speed = max_of(speed, size_of(offset[i]) + root_of(spread));
            mobility += by_forces[i * c + i];
        }
        if (speed == 0.0) speed = 1.0;
        impulse = mobility > 0.0 ? speed / (mobility / c) : 1.0;
        value_scale = 0.0;
        for (int j = 0; j < nu; ++j) {
            double curvature = diagonal[j];
            for (int k = 0; k < q; ++k)
                curvature += squares[k * (nu + c) + j] * squares[k * (nu + c) + j];
            value_scale = max_of(value_scale, curvature * control_scale[j] * control_scale[j]);
        }
        for (int j = 0; j < nu; ++j) {
            curve[j] = diagonal[j] * control_scale[j] * control_scale[j] / value_scale;
            slope[j] = gradient[j] * control_scale[j] / value_scale;
        }
        for (int j = nu; j < nu + c; ++j) slope[j] = gradient[j] * impulse / value_scale;
        const double unit = 1.0 / root_of(value_scale);
        for (int k = 0; k < q; ++k) {
            const double* from = squares + k * (nu + c);
            double* to = factor + k * (nu + c);
            for (int j = 0; j < nu; ++j) to[j] = from[j] * (control_scale[j] * unit);
            for (int j = nu; j < nu + c; ++j) to[j] = from[j] * (impulse * unit);
        }
        for (int i = 0; i < c; ++i) {
            free_velocity[i * w] = offset[i] / speed;
            const double* from = by_controls + i * nu;
            double* to = free_velocity + i * w + 1;
            for (int j = 0; j < nu; ++j) to[j] = from[j] * (control_scale[j] / speed);
            for (int j = 0; j < c; ++j)
                delassus[i * c + j] = by_forces[i * c + j] * (impulse / speed);
        }
    }
"""
