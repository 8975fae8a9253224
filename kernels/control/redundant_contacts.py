"""Native code: choices of modes whose forces the velocities do not determine.

What ``is_definite`` and ``is_inconsistent`` of ``force_elimination`` decide. Members of the local
class of ``contact_search``.
"""

REDUNDANCE = """
    // Largest sum of a column of the inverse of ``system``, row by row from transposed solves.
    APART double norm_of_inverse() {
        for (int j = 0; j < p; ++j) line[j] = 0.0;
        for (int k = 0; k < p; ++k) {
            for (int j = 0; j < p; ++j) tension[j] = j == k;
            solve_transposed(tension);
            for (int j = 0; j < p; ++j) line[j] += size_of(tension[j]);
        }
        double norm = 0.0;
        for (int j = 0; j < p; ++j) norm = max_of(norm, line[j]);
        return norm;
    }

    // Whether the symmetric part of Wf has no eigenvalue below 1e-8 of the mean one.
    APART bool definite() {
        double mean = 0.0;
        for (int i = 0; i < c; ++i) mean += delassus[i * c + i] / c;
        for (int j = 0; j < c; ++j) {
            double* own = span + j * c;
            for (int k = 0; k <= j; ++k) {
                const double both = 0.5 * (delassus[j * c + k] + delassus[k * c + j]);
                own[k] = both - dot(k, own, span + k * c);
                if (k < j) own[k] /= span[k * c + k];
            }
            own[j] -= 1e-8 * mean;
            if (!(own[j] > 0.0)) return false;
            own[j] = root_of(own[j]);
        }
        return true;
    }

    // The longest of ``number`` vectors, (p,) each, made a unit vector at right angles to the first
    // ``known`` of them and exchanged with the next; false where what is left of it is too short.
    APART bool next_unit(double* vectors, int known, int number, double least) {
        int best = known;
        double longest = -1.0;
        for (int i = known; i < number; ++i) {
            double* own = vectors + i * p;
            for (int j = 0; j < 2 * known; ++j) {
                const double* unit = vectors + j % known * p;
                add(p, -dot(p, unit, own), unit, own);
            }
            const double square = dot(p, own, own);
            if (square > longest) longest = square, best = i;
        }
        if (!(longest > least * least)) return false;
        double *from = vectors + best * p, *to = vectors + known * p;
        const double inverse_length = 1.0 / root_of(longest);
        for (int a = 0; a < p; ++a) {
            exchange(from[a], to[a]);
            to[a] *= inverse_length;
        }
        return true;
    }

    // Whether redundant contacts ask of T w = 0 what no controls within their bounds give.
    APART bool disagree(const int* modes) {
        put_together(modes);
        double largest = 0.0, entries = 0.0;
        for (int j = 0; j < p; ++j) {
            double square = 0.0;
            for (int i = 0; i < p; ++i) {
                span[j * p + i] = system[i * p + j];
                square += system[i * p + j] * system[i * p + j];
            }
            largest = max_of(largest, root_of(square));
        }
        for (int i = 0; i < p * w; ++i) entries = max_of(entries, size_of(amplitudes[i]));
        int rank = 0;
        while (rank < p && next_unit(span, rank, p, SINGULAR * largest)) ++rank;
        // velocities that no force changes: what is left of the space
        for (int k = rank; k < p; ++k) {
            double* rest_of = span + k * p;
            for (int i = 0; i < p * (2 * p - k); ++i) rest_of[i] = 0.0;
            for (int i = 0; i < p; ++i) rest_of[i * p + i] = 1.0;
            if (!next_unit(span, k, k + p, 1e-6)) return false;
            for (int j = 0; j < w; ++j) line[j] = 0.0;
            for (int i = 0; i < p; ++i) add(w, rest_of[i], amplitudes + i * w, line);
            double reached_by = INCONSISTENT;
            for (int j = 0; j < nu; ++j) {
                const double own = size_of(line[1 + j]);
                if (own < NOISE * entries) continue;
                reached_by += own * min_of(max_of(size_of(low[j]), size_of(high[j])), FAR);
            }
            if (size_of(line[0]) > reached_by) return true;
        }
        return false;
    }
"""
