/* The inputs of an initial circle, sought for one lane: substitution, then Newton's
   method, with the bits of orchestrator/master/initialise.py and newton.py.

   The caller evaluates what is `asked` and calls circle_next with what came `given`
   back, until `phase` is DONE or FAILED; `found` are the inputs. CIRCLE says how many
   numbers there are, SUBSTITUTIONS how often one goes round. */
#ifndef CIRCLE_H
#define CIRCLE_H

enum { SUBSTITUTING, BEGINNING, COLUMN_BY_COLUMN, STEPPING_THERE, DONE, FAILED };
enum { NEWTON_ROUNDS = 50, HALVINGS = 20 };
static const double circle_tolerance = 1e-12, circle_shift = 0x1p-26;
static const double circle_noise = 0x1p-20;

typedef struct {
    int phase, round, column, halvings;
    double asked[CIRCLE], given[CIRCLE], found[CIRCLE];
    double start[CIRCLE], z[CIRCLE], off[CIRCLE], step[CIRCLE], rows[CIRCLE][CIRCLE + 1];
    double share;
} Circle;

static int circle_settled(const Circle *c) {
    for (int i = 0; i < CIRCLE; i++) {
        double size = fabs(c->asked[i]) > 1 ? fabs(c->asked[i]) : 1;
        if (!(fabs(c->given[i] - c->asked[i]) <= circle_tolerance * size))
            return 0;
    }
    return 1;
}

static double circle_largest(const double *values) {
    double most = fabs(values[0]);
    for (int i = 1; i < CIRCLE; i++)
        most = fabs(values[i]) > most ? fabs(values[i]) : most;
    return most;
}

static void circle_ask_column(Circle *c) {
    int j = c->column;
    double size = fabs(c->z[j]) > 1 ? fabs(c->z[j]) : 1;
    memcpy(c->asked, c->z, sizeof c->z);
    c->asked[j] = c->z[j] + circle_shift * size;
}

static void circle_ask_step(Circle *c) {
    for (int i = 0; i < CIRCLE; i++)
        c->asked[i] = c->z[i] + c->share * c->step[i];
    c->share = c->share / 2;
}

static void circle_turn(double (*rows)[CIRCLE + 1], int a, int b) {
    for (int j = 0; j <= CIRCLE; j++) {
        double kept = rows[a][j];
        rows[a][j] = rows[b][j];
        rows[b][j] = kept;
    }
}

/* Returns 0 if the equations are singular: what is left of larger numbers that cancel
   is noise, and no pivot. */
static int circle_solve(Circle *c) {
    double(*a)[CIRCLE + 1] = c->rows, sizes[CIRCLE][CIRCLE + 1];
    for (int i = 0; i < CIRCLE; i++) {
        a[i][CIRCLE] = -c->off[i];
        for (int j = 0; j <= CIRCLE; j++)
            sizes[i][j] = i == j && fabs(a[i][j]) < 1 ? 1 : fabs(a[i][j]);
    }
    for (int k = 0; k < CIRCLE; k++) {
        int pivot = k;
        for (int i = k + 1; i < CIRCLE; i++)
            if (fabs(a[i][k]) > fabs(a[pivot][k]))
                pivot = i;
        circle_turn(a, k, pivot);
        circle_turn(sizes, k, pivot);
        if (!(fabs(a[k][k]) > circle_noise * sizes[k][k] && fabs(a[k][k]) < INFINITY))
            return 0;
        for (int i = k + 1; i < CIRCLE; i++) {
            double share = a[i][k] / a[k][k];
            for (int j = k; j <= CIRCLE; j++) {
                double taken = share * a[k][j];
                a[i][j] = a[i][j] - taken;
                if (fabs(taken) > sizes[i][j])
                    sizes[i][j] = fabs(taken);
            }
        }
    }
    for (int i = CIRCLE - 1; i >= 0; i--) {
        double rest = a[i][CIRCLE];
        for (int j = i + 1; j < CIRCLE; j++)
            rest = rest - a[i][j] * c->step[j];
        c->step[i] = rest / a[i][i];
    }
    return 1;
}

/* What was asked is the next iterate. */
static void circle_iterate(Circle *c) {
    if (c->round++ == NEWTON_ROUNDS) {
        c->phase = FAILED;
    } else if (circle_settled(c)) {
        memcpy(c->found, c->asked, sizeof c->found);
        c->phase = DONE;
    } else {
        for (int i = 0; i < CIRCLE; i++)
            c->off[i] = c->given[i] - c->asked[i];
        memcpy(c->z, c->asked, sizeof c->z);
        c->column = 0;
        circle_ask_column(c);
        c->phase = COLUMN_BY_COLUMN;
    }
}

static void circle_column(Circle *c) {
    int j = c->column;
    double width = c->asked[j] - c->z[j];
    for (int i = 0; i < CIRCLE; i++)
        c->rows[i][j] = ((c->given[i] - c->asked[i]) - c->off[i]) / width;
    if (++c->column < CIRCLE) {
        circle_ask_column(c);
    } else if (circle_solve(c)) {
        c->phase = STEPPING_THERE;
        c->halvings = 0;
        c->share = 1;
        circle_ask_step(c);
    } else {
        c->phase = FAILED;
    }
}

static int circle_nearer(const Circle *c) {
    double off[CIRCLE];
    for (int i = 0; i < CIRCLE; i++)
        off[i] = c->given[i] - c->asked[i];
    return circle_largest(off) < circle_largest(c->off) || circle_settled(c);
}

static void circle_begin(Circle *c) {
    memcpy(c->start, c->asked, sizeof c->start);
    c->phase = SUBSTITUTING;
    c->round = 0;
}

/* `bad`: what was asked cannot be evaluated; `real`: Newton's method may be tried. */
static void circle_next(Circle *c, int bad, int real) {
    int finite = !bad;
    for (int i = 0; i < CIRCLE; i++)
        finite = finite && c->given[i] - c->given[i] == 0;
    if (c->phase == SUBSTITUTING) {
        if (finite && circle_settled(c)) {
            memcpy(c->found, c->given, sizeof c->found);
            c->phase = DONE;
        } else if (!finite || ++c->round == SUBSTITUTIONS) {
            memcpy(c->asked, c->start, sizeof c->asked);
            c->phase = real ? BEGINNING : FAILED;
            c->round = 0;
        } else {
            memcpy(c->asked, c->given, sizeof c->asked);
        }
    } else if (finite && c->phase == COLUMN_BY_COLUMN) {
        circle_column(c);
    } else if (finite && (c->phase == BEGINNING || circle_nearer(c))) {
        circle_iterate(c);
    } else if (c->phase == STEPPING_THERE && ++c->halvings < HALVINGS) {
        circle_ask_step(c);
    } else {
        c->phase = FAILED;
    }
}

/* All lanes at once: those that are done are asked what they were last. */

static void circles_begin(Circle *c, const V *asked) {
    for (int i = 0; i < W; i++) {
        for (int j = 0; j < CIRCLE; j++)
            c[i].asked[j] = lane(asked[j], i);
        circle_begin(c + i);
    }
}

/* Returns whether a lane goes on; a bad lane gave NaN somewhere. */
static int circles_next(Circle *c, V *asked, const V *given, V bad, int real) {
    int going = 0;
    for (int i = 0; i < W; i++) {
        if (c[i].phase >= DONE)
            continue;
        for (int j = 0; j < CIRCLE; j++)
            c[i].given[j] = lane(given[j], i);
        circle_next(c + i, lane(bad, i) != 0, real);
        for (int j = 0; j < CIRCLE && c[i].phase < DONE; j++)
            asked[j] = with_lane(asked[j], i, c[i].asked[j]);
        going |= c[i].phase < DONE;
    }
    return going;
}

static int circles_failed(const Circle *c) {
    for (int i = 0; i < W; i++)
        if (c[i].phase == FAILED)
            return 1;
    return 0;
}

static void circles_found(const Circle *c, V *found) {
    for (int i = 0; i < W; i++)
        for (int j = 0; j < CIRCLE; j++)
            found[j] = with_lane(found[j], i, c[i].found[j]);
}

#endif
