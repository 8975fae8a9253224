"""Native code: the cones of the contact modes, as ``mode_cones`` builds them.

They are built anew for contacts whose friction has changed, as directional friction does in every
step. Members of the local class of ``contact_search``.
"""

CONES = """
    static void unit_of(const double* from, double* to) {
        const double size = root_of(from[0] * from[0] + from[1] * from[1] + from[2] * from[2]);
        for (int a = 0; a < 3; ++a) to[a] = from[a] / size;
    }
    static void cross(const double* a, const double* b, double* to) {
        to[0] = a[1] * b[2] - a[2] * b[1];
        to[1] = a[2] * b[0] - a[0] * b[2];
        to[2] = a[0] * b[1] - a[1] * b[0];
    }
    // A unit vector along the ground, in place of a velocity.
    static void tangent(double x, double y, double* to) {
        const double size = root_of(x * x + y * y);
        to[0] = 0.0;
        to[1] = x / size;
        to[2] = y / size;
    }
    double* basis_of(int cone) { return basis + 9 * cone; }
    double* constraint_of(int cone, int i) { return constraints + 9 * cone + 3 * i; }
    double* row_at(int cone, int i) { return inequalities + 6 * (cone * r + i); }
    double* equality_at(int cone, int i) { return halfspaces + 6 * (cone * (r + 6) + r + i); }
    double* ray_at(int cone, int i) { return rays + 6 * (cone * s + i); }

    // Builds the cones of contacts whose friction or directions are not those known.
    APART void build_cones() {
        bool turned = false;
        for (int i = 0; i < 2 * m; ++i) {
            turned = turned || known_directions[i] != directions[i];
            known_directions[i] = directions[i];
        }
        for (int k = 0; k < K; ++k) {
            bool known = !turned && valid[k * M], rough = false;
            for (int j = 0; j < m; ++j) {
                const double own = friction[k] * factors[k * m + j];
                known = known && radius[k * m + j] == own;
                rough = rough || own > FRICTIONLESS;
                radius[k * m + j] = own;
            }
            if (!known) build(k, rough);
        }
    }

    APART void build(int k, bool rough) {
        const int begin = k * M;
        for (int i = 0; i < 9 * M; ++i) basis_of(begin)[i] = constraint_of(begin, 0)[i] = 0.0;
        for (int i = 0; i < 6 * r * M; ++i) row_at(begin, 0)[i] = 0.0;
        for (int i = 0; i < 6 * (r + 6) * M; ++i) halfspaces[6 * (r + 6) * begin + i] = 0.0;
        for (int i = 0; i < 6 * s * M; ++i) ray_at(begin, 0)[i] = 0.0;
        for (int i = 0; i < r * M; ++i) used[r * begin + i] = 0;
        for (int mode = 0; mode < M; ++mode) {
            valid[begin + mode] = rough || mode == 0 || mode == SLIDE;
            dimensions[begin + mode] = 0;
        }
        build_free(begin, 3);
        for (int a = 0; a < 3; ++a) equality_at(begin, a)[a] = 1.0;
        if (rough) {
            build_stick(begin + 1, radius + k * m);
            for (int j = 0; j < m; ++j) build_slide(begin + SLIDE + j, j, radius + k * m);
            for (int j = 0; j < m; ++j) build_edge(begin + SLIDE + m + j, j, radius + k * m);
        } else {
            const int cone = begin + SLIDE;
            build_free(cone, 0);
            basis_of(cone)[0] = constraint_of(cone, 0)[0] = 1.0;
            dimensions[cone] = 1;
            for (int a = 0; a < 3; ++a) equality_at(cone, a)[1 + a] = 1.0;
        }
        for (int cone = begin; cone < begin + M; ++cone) {
            copy(6 * r, row_at(cone, 0), halfspaces + 6 * (r + 6) * cone);
            for (int i = 0; i < 18; ++i) equality_at(cone, 3)[i] = -equality_at(cone, 0)[i];
        }
    }

    // One condition and ray along an axis, and all velocities along the ground.
    void build_free(int cone, int axis) {
        row_at(cone, 0)[axis] = ray_at(cone, 0)[axis] = 1.0;
        used[r * cone] = 1;
        for (int i = 0; i < 4; ++i) ray_at(cone, 1 + i)[4 + i % 2] = i < 2 ? 1.0 : -1.0;
    }

    void corner_at(int j, const double* radii, double* to) const {
        to[0] = 1.0;
        to[1] = radii[j] * directions[2 * j];
        to[2] = radii[j] * directions[2 * j + 1];
    }

    // Opposite to direction j and the next.
    void away_from(int j, double* to) const {
        const double *a = directions + 2 * j, *b = directions + 2 * ((j + 1) % m);
        tangent(-(a[0] + b[0]), -(a[1] + b[1]), to);
    }

    APART void build_stick(int cone, const double* radii) {
        dimensions[cone] = 3;
        for (int a = 0; a < 3; ++a) {
            basis_of(cone)[4 * a] = constraint_of(cone, a)[a] = 1.0;
            equality_at(cone, a)[3 + a] = 1.0;
        }
        double corner[3], other[3], normal[3];
        for (int j = 0; j < m; ++j) {
            corner_at(j, radii, corner);
            unit_of(corner, ray_at(cone, j));
        }
        const int edges = hull(radii);
        for (int i = 0; i < edges; ++i) {
            corner_at(hull_edges[2 * i], radii, corner);
            corner_at(hull_edges[2 * i + 1], radii, other);
            cross(corner, other, normal);
            double* row = row_at(cone, i);
            unit_of(normal, row);
            if (row[0] < 0.0)
                for (int a = 0; a < 3; ++a) row[a] = -row[a];
            used[r * cone + i] = 1;
        }
    }

    // Ends of the edges of the hull of the corners along the ground, in order; their number.
    APART int hull(const double* radii) {
        double largest = -1.0;
        int start = 0, length = 1;
        for (int j = 0; j < m; ++j) {
            double corner[3];
            corner_at(j, radii, corner);
            const double square = corner[1] * corner[1] + corner[2] * corner[2];
            if (square > largest) largest = square, start = j;
        }
        hull_nodes[0] = start;
        for (int step = 1; step <= m; ++step) {
            const int following = (start + step) % m;
            double a[3], b[3], next[3];
            corner_at(following, radii, next);
            while (length > 1) {
                corner_at(hull_nodes[length - 2], radii, a);
                corner_at(hull_nodes[length - 1], radii, b);
                const double turn = (b[1] - a[1]) * (next[2] - a[2])
                    - (b[2] - a[2]) * (next[1] - a[1]);
                if (turn > COLLINEAR * largest) break;
                --length;
            }
            hull_nodes[length++] = following;
        }
        for (int i = 0; i + 1 < length; ++i) {
            int low_end = hull_nodes[i], high_end = hull_nodes[i + 1], place = i;
            if (low_end > high_end) {
                low_end = high_end;
                high_end = hull_nodes[i];
            }
            for (; place > 0; --place) {
                const int* before = hull_edges + 2 * (place - 1);
                if (before[0] < low_end || (before[0] == low_end && before[1] <= high_end)) break;
                hull_edges[2 * place] = before[0];
                hull_edges[2 * place + 1] = before[1];
            }
            hull_edges[2 * place] = low_end;
            hull_edges[2 * place + 1] = high_end;
        }
        return length - 1;
    }

    APART void build_slide(int cone, int j, const double* radii) {
        const double* way = directions + 2 * j;
        double corner[3];
        corner_at(j, radii, corner);
        for (int a = 0; a < 3; ++a) basis_of(cone)[3 * a] = corner[a];
        constraint_of(cone, 0)[0] = 1.0;
        dimensions[cone] = 1;
        row_at(cone, 0)[0] = 1.0;
        for (int i = 0; i < 2; ++i) {
            const double* beside = directions + 2 * ((j + (i ? 1 : m - 1)) % m);
            tangent(beside[0] - way[0], beside[1] - way[1], row_at(cone, 1 + i) + 3);
            away_from((j + (i ? 0 : m - 1)) % m, ray_at(cone, 1 + i) + 3);
        }
        for (int i = 0; i < 3; ++i) used[r * cone + i] = 1;
        double* ray = ray_at(cone, 0);
        unit_of(corner, ray);
        // the ray turned by a quarter in its vertical plane
        double* across = equality_at(cone, 0);
        across[0] = -radii[j] * ray[0];
        across[1] = way[0] * ray[0];
        across[2] = way[1] * ray[0];
        equality_at(cone, 1)[1] = -way[1];
        equality_at(cone, 1)[2] = way[0];
        equality_at(cone, 2)[3] = 1.0;
    }

    APART void build_edge(int cone, int j, const double* radii) {
        const int next = (j + 1) % m;
        const double *way = directions + 2 * j, *beside = directions + 2 * next;
        double corner[3], other[3], normal[3], share[3];
        corner_at(j, radii, corner);
        corner_at(next, radii, other);
        for (int a = 0; a < 3; ++a) {
            basis_of(cone)[3 * a] = corner[a];
            basis_of(cone)[3 * a + 1] = other[a];
        }
        constraint_of(cone, 0)[0] = 1.0;
        tangent(way[0] - beside[0], way[1] - beside[1], constraint_of(cone, 1));
        dimensions[cone] = 2;
        cross(corner, other, normal);
        unit_of(normal, equality_at(cone, 0));
        for (int i = 0; i < 2; ++i) copy(3, constraint_of(cone, i), equality_at(cone, 1 + i) + 3);
        // the share of either corner in a force between the two, zero at the other corner
        cross(other, normal, share);
        unit_of(share, row_at(cone, 0));
        cross(normal, corner, share);
        unit_of(share, row_at(cone, 1));
        away_from(j, row_at(cone, 2) + 3);
        away_from(j, ray_at(cone, 2) + 3);
        unit_of(corner, ray_at(cone, 0));
        unit_of(other, ray_at(cone, 1));
        for (int i = 0; i < 3; ++i) used[r * cone + i] = 1;
    }
"""
