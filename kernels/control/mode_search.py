"""Native code: the local search over modes, descent and kicks.

What ``local_search`` and ``warm_start`` of the QPCC solver do, in the same order. Members of the
local class of ``contact_search``.
"""

SEARCH = """
    // Slope of a mode that offers descent and contains the point, else 0.
    double offer(int v, int k, int mode, double noise) const {
        if (mode == visit_modes[K * v + k]) return 0.0;
        const double along = descent[K * M * v + k * M + mode];
        return along < -noise && violation[K * M * v + k * M + mode] <= TOUCHING ? along : 0.0;
    }

    APART double noise_of(int v) const {
        const double* own = multiplier + 6 * K * v;
        double largest = 0.0;
        for (int i = 0; i < 6 * K; ++i) largest = max_of(largest, size_of(own[i]));
        return SLOPE_NOISE * (1e-3 + largest);
    }

    int improved(int v, const int* modes) {
        const int found = visit(modes, 1e300, v);
        return found < 0 || value[found] >= value[v] - margin(v) ? -1 : found;
    }

    // The first change of one mode that improves, the steepest tried first.
    APART int single_flip(int v, double noise) {
        double last = -1e300;
        int from = -1;
        for (;;) {
            double least = 0.0;
            int next = -1;
            for (int i = 0; i < K * M; ++i) {
                const double own = offer(v, i / M, i % M, noise);
                if ((own > last || (own == last && i > from)) && own < least) least = own, next = i;
            }
            if (next < 0 || spent() || failed) return -1;
            last = least;
            from = next;
            for (int k = 0; k < K; ++k) trial[k] = visit_modes[K * v + k];
            trial[next / M] = next % M;
            const int found = improved(v, trial);
            if (found >= 0) return found;
        }
    }

    // Moves to adjacent modes while the objective falls; the visit where that ends.
    APART int descend(int v) {
        for (;;) {
            compare(v);
            const double noise = noise_of(v);
            bool any = false;
            for (int k = 0; k < K; ++k) {
                trial[k] = visit_modes[K * v + k];
                double least = 0.0;
                for (int mode = 0; mode < M; ++mode) {
                    const double own = offer(v, k, mode, noise);
                    if (own < least) least = own, trial[k] = mode, any = true;
                }
            }
            stationary[v] = !any;
            complete[v] = 1;
            if (!any) return v;
            int following = improved(v, trial);
            if (following < 0) following = single_flip(v, noise);
            if (following < 0) {
                complete[v] = !spent();
                return v;
            }
            v = following;
        }
    }

    // The next kick of a minimum: a change of one mode and of all that bear, in turn.
    APART bool next_kick(int v) {
        int bear = 0;
        for (int k = 0; k < K; ++k) bear += visit_modes[K * v + k] != 0;
        const int common = bear < 2 ? 0 : M - SLIDE < COMMON ? M - SLIDE : COMMON;
        for (;;) {
            const int place = tried[v]++;
            if (place < 2 * common && place % 2) {
                slide_together(v, place / 2);
            } else if (!next_single(v)) {
                if (place < 2 * common) continue;
                return false;
            }
            if (!known(trial)) return true;
        }
    }

    // Slope of all contacts that bear if they slide one way.
    double slope_of(int v, int way) const {
        double sum = 0.0;
        for (int k = 0; k < K; ++k)
            if (visit_modes[K * v + k])
                sum += min_of(descent[K * M * v + k * M + SLIDE + way], 0.0);
        return sum;
    }

    // All contacts that bear slide in the mode whose slope has a rank, the steepest first.
    APART void slide_together(int v, int rank) {
        double last = -1e300;
        int from = -1;
        for (int i = 0; i <= rank; ++i) {
            double least = 1e300;
            int next = 0;
            for (int way = 0; way < M - SLIDE; ++way) {
                const double own = slope_of(v, way);
                if ((own > last || (own == last && way > from)) && own < least)
                    least = own, next = way;
            }
            last = least;
            from = next;
        }
        for (int k = 0; k < K; ++k) trial[k] = visit_modes[K * v + k] ? SLIDE + from : 0;
    }

    // The next change of one mode to a cone without the point, by slope, violation and place.
    APART bool next_single(int v) {
        const double *miss = violation + K * M * v, *along = descent + K * M * v;
        int best = -1;
        const int last = kicked[v];
        for (int i = 0; i < K * M; ++i) {
            if (!(miss[i] > TOUCHING) || miss[i] >= 1e300) continue;
            if (last >= 0 && !before(along, miss, last, i)) continue;
            if (best < 0 || before(along, miss, i, best)) best = i;
        }
        if (best < 0) return false;
        kicked[v] = best;
        for (int k = 0; k < K; ++k) trial[k] = visit_modes[K * v + k];
        trial[best / M] = best % M;
        return true;
    }

    static bool before(const double* along, const double* miss, int i, int j) {
        if (along[i] != along[j]) return along[i] < along[j];
        return miss[i] != miss[j] ? miss[i] < miss[j] : i < j;
    }

    APART bool known(const int* modes) const {
        for (int v = 0; v < visits; ++v) {
            bool same = true;
            for (int k = 0; k < K; ++k) same = same && visit_modes[K * v + k] == modes[k];
            if (same) return true;
        }
        return false;
    }

    int lowest(const int* minima, int number) const {
        double least = 1e300;
        for (int i = 0; i < number; ++i) least = min_of(least, value[minima[i]]);
        for (int i = 0; i < number; ++i)
            if (value[minima[i]] <= least + margin(minima[i])) return minima[i];
        return minima[0];
    }

    // Descends from a visit; the minimum, or -1 where that is known.
    int add_minimum(int v) {
        const int found = descend(v);
        if (reached[found]) return -1;
        reached[found] = 1;
        kicked[found] = -1;
        tried[found] = 0;
        return found;
    }

    // How far above the best value another start or a kick may end.
    double limit(int best) const {
        return reach < 1e300 ? value[best] + reach * size_of(value[best]) : 1e300;
    }

    // Leaves minima by kicks, the lowest first; the lowest one found.
    APART int perturb(int* queue, int number) {
        int best = lowest(queue, number), left = kicks, misses = 0, order = 0;
        for (int i = 0; i < number; ++i) turn[queue[i]] = order++;
        while (number && left > 0 && misses < patience && !spent() && !failed) {
            int place = 0;
            for (int i = 1; i < number; ++i) {
                const int a = queue[i], b = queue[place];
                if (value[a] < value[b] || (value[a] == value[b] && turn[a] < turn[b])) place = i;
            }
            const int v = queue[place];
            compare(v);
            if (!next_kick(v)) {
                queue[place] = queue[--number];
                continue;
            }
            turn[v] = order++;
            --left;
            ++misses;
            const int there = visit(trial, limit(best), v);
            const int found = there < 0 ? -1 : add_minimum(there);
            if (found < 0) continue;
            turn[found] = order++;
            queue[number++] = found;
            if (value[found] < value[best] - margin(best)) best = found, misses = 0;
        }
        return best;
    }

    double worth(int v) const { return value[v] + WORTH * size_of(value[v]); }

    // The best visit from the start, static contacts and others; -1 without any point.
    int search() {
        int number = 0;
        const int root = has_start ? visit(start, 1e300, -1) : -1;
        if (failed) return -1;
        const int still = visit(still_modes, root < 0 ? 1e300 : worth(root), root);
        if (root >= 0) minima[number++] = add_minimum(root);
        if (still >= 0 && (root < 0 || value[still] <= worth(minima[0])))
            number = added(number, still);
        if (!number) return -1;
        exploring = 1;
        for (int i = 0; i < given_others; ++i) {
            const int least = lowest(minima, number);
            const int other = visit(others + K * i, limit(least), least);
            if (other >= 0) number = added(number, other);
        }
        int best = lowest(minima, number);
        bool held = has_start;
        for (int k = 0; k < K; ++k) held = held && visit_modes[K * best + k] == start[k];
        if (!failed && kicks && (kick_held || !held)) best = perturb(minima, number);
        return best;
    }

    int added(int number, int v) {
        const int found = add_minimum(v);
        if (found >= 0) minima[number++] = found;
        return number;
    }

    // Keeps the modes of the minima next to the best one, the lowest first; how many there are.
    APART int keep_next(int best) {
        for (int i = 0; i < MOST_OTHERS; ++i) {
            int next = -1;
            for (int v = 0; v < visits; ++v)
                if (reached[v] && v != best && (next < 0 || value[v] < value[next])) next = v;
            if (next < 0) return i;
            reached[next] = 0;
            for (int k = 0; k < K; ++k) next_modes[K * i + k] = visit_modes[K * next + k];
        }
        return MOST_OTHERS;
    }
"""
