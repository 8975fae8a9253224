"""Native code: the contact problem of a step out of its linear maps, as ``build_qpcc`` has it.

A member of the local class of ``contact_search``.
"""

ASSEMBLY = """
    // The problem's arrays; false where these are not finite, or not what the search knows.
    APART bool assemble() {
        const int r = q + c;
        const double own = costs[0] + costs[1];
        double all = own, square = 0.0;
        for (int j = 0; j < nu; ++j) {
            const double most = reaches[j] / rest_lengths[j];
            lower[j] = min_of(SHORTEST, most);
            upper[j] = min_of(1.0, most);
            if (resting[j]) lower[j] = upper[j];
            diagonal[j] = own;
            gradient[j] = -costs[0] - costs[1] * activations[j];
            square += activations[j] * activations[j];
            all += lower[j] + gradient[j];
        }
        for (int j = nu; j < nu + c; ++j) gradient[j] = 0.0;
        scalars[0] = 0.5 * (costs[0] * nu + costs[1] * square);
        for (int i = 0; i < r; ++i) {
            const double* from = muscle_map + i * nu;
            const double* answers = compliance + i * r + q;
            const double known = step_velocity[i] - dot(nu, from, lengths);
            all += known;
            if (i >= q) {
                double* to = by_controls + (i - q) * nu;
                for (int j = 0; j < nu; ++j) to[j] = from[j] * rest_lengths[j], all += to[j];
                copy(c, answers, by_forces + (i - q) * c);
                offset[i - q] = known + ((i - q) % 3 ? 0.0 : gaps[(i - q) / 3]);
                for (int j = 0; j < c; ++j) all += answers[j];
                continue;
            }
            const double root = root_of(2.0 * goal_weights[i]), miss = known - targets[i];
            double* to = squares + i * (nu + c);
            for (int j = 0; j < nu; ++j) to[j] = root * (from[j] * rest_lengths[j]);
            for (int j = 0; j < c; ++j) to[nu + j] = root * answers[j];
            add(nu + c, root * miss, to, gradient);
            scalars[0] += goal_weights[i] * miss * miss;
        }
        double largest = 0.0;
        for (int j = 0; j < nu + c; ++j) {
            double curvature = j < nu ? own : 0.0;
            for (int i = 0; i < q; ++i)
                curvature += squares[i * (nu + c) + j] * squares[i * (nu + c) + j];
            largest = max_of(largest, curvature);
            all += gradient[j] + curvature;
        }
        for (int i = 0; i < K; ++i) all += offset[3 * i] + friction[i];
        for (int i = 0; i < K * m; ++i)
            if (!(factors[i] > 0.0 && factors[i] < FAR)) return false;
        return size_of(all) < FAR && size_of(scalars[0]) < FAR && own > CLEAR * largest;
    }
"""
