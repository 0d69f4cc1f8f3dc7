#include "core/ensemble/lyapunov.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/base/rng.h"
#include "core/ensemble/ensemble.h"
#include "core/integrate/run/run_check.h"
#include "core/tree/turns.h"

/* rad, distance of the neighbours on both sides: the linear law neglects its square, and rounding
 * errors are 1e-11 of it */
static const double lyapunov_distance = 1e-5;

/* limits of the largest neglected component, relative to the shortest remaining direction: above
 * the first the piece is repeated in halves, below the second pieces become longer */
static const double lyapunov_error = 1e-6, lyapunov_little = 1e-9;

enum {
    LYAPUNOV_PIECES = 1 << 20,
    LYAPUNOV_SEED = 1,
    LYAPUNOV_MARKS = 32,
    LYAPUNOV_MARKS_LEAST = 4
};

struct pend_lyapunov {
    const struct pend_tree *tree;
    struct pend_loads loads;
    double rtol, frequency, interval;
    double start; /* s, the start of the first interval that counts, in the time of the drives */
    int whole;    /* whether whole turns do not matter, because there are no springs */
    int n, count;
    double unit;                    /* m, divisor of a cart's position; 1 without a cart */
    struct pend_ensemble *ensemble; /* workspace for pieces of the current length */
    long pieces, piece;             /* number of pieces in an interval, and of finished pieces */
    int under_way;                  /* whether a piece has started */
    double neglected;               /* the largest neglected component in this interval, relative to
                                     * the remaining length of a direction */
    enum pend_status status;        /* failure of a motion, or PEND_OK */
    double failed_at;
    long steps, intervals;
    double *base;      /* 2 n numbers: angles, and rates divided by the frequency */
    double *direction; /* count x 2 n, orthonormal */
    double *end;       /* (2 count + 1) x 2 n: final states of the motion and its neighbours */
    double *growth;    /* log of the growth of each of `count` directions */
    long a_mark;       /* intervals between two marks */
    int marks;         /* number of marks in use */
    double *mark;      /* count x LYAPUNOV_MARKS: the logarithmic growth at equidistant instants */
    double *length;    /* count: the factor by which a piece has stretched each direction, without
                        * its components along earlier directions */
};

/* --- the members: the motion, and two neighbours in each direction, one ahead and one behind
 * --- */

static int lyapunov_fetch(void *context, long i, struct pend_member *member) {
    const struct pend_lyapunov *lyapunov = context;
    const double *base = lyapunov->base,
                 *beside = lyapunov->direction + (i - 1) / 2 * 2 * lyapunov->n;
    double distance = i % 2 ? lyapunov_distance : -lyapunov_distance;
    double parts = (double)lyapunov->intervals + (double)lyapunov->piece / (double)lyapunov->pieces;
    member->start = lyapunov->start + parts * lyapunov->interval;
    for (int k = 0; k < lyapunov->n; k++) {
        double phi = i ? distance * beside[k] : 0,
               rate = i ? distance * beside[lyapunov->n + k] : 0;
        member->phi[k] = base[k] + phi;
        member->rate[k] = lyapunov->frequency * (base[lyapunov->n + k] + rate);
    }
    member->phi[0] *= lyapunov->unit;
    member->rate[0] *= lyapunov->unit;
    return 0;
}

static int lyapunov_deliver(void *context, long i, const struct pend_outcome *outcome) {
    struct pend_lyapunov *lyapunov = context;
    double *end = lyapunov->end + i * 2 * lyapunov->n;
    lyapunov->steps += outcome->steps;
    if (outcome->stop == PEND_STOP_FAILED && lyapunov->status == PEND_OK) {
        lyapunov->status = outcome->status;
        lyapunov->failed_at = outcome->time;
    }
    memcpy(end, outcome->phi, (size_t)lyapunov->n * sizeof *end);
    for (int k = 0; k < lyapunov->n; k++)
        end[lyapunov->n + k] = outcome->rate[k] / lyapunov->frequency;
    end[0] /= lyapunov->unit;
    end[lyapunov->n] /= lyapunov->unit;
    return 0;
}

static enum pend_status lyapunov_open(struct pend_lyapunov *lyapunov, struct pend_error *error) {
    struct pend_ensemble_problem problem = {.tree = lyapunov->tree,
                                            .loads = lyapunov->loads,
                                            .duration =
                                                lyapunov->interval / (double)lyapunov->pieces,
                                            .rtol = lyapunov->rtol,
                                            .step_cap = 1 << 20,
                                            .fetch = lyapunov_fetch,
                                            .deliver = lyapunov_deliver,
                                            .context = lyapunov};
    pend_ensemble_free(&lyapunov->ensemble);
    return pend_ensemble_new(&lyapunov->ensemble, &problem, pend_isa_best(), error);
}

/* --- directions --- */

static double lyapunov_dot(int count, const double a[], const double b[]) {
    double sum = 0;
    for (int k = 0; k < count; k++) sum += a[k] * b[k];
    return sum;
}

/* Makes directions orthonormal, starting with the first (Gram and Schmidt, twice); stores the
 * remaining length of each direction in `length`. Returns 0 if a direction vanishes. */
static int lyapunov_straighten(int count, int size, double direction[], double length[]) {
    for (int i = 0; i < count; i++) {
        double *own = direction + (size_t)i * (size_t)size;
        for (int again = 0; again < 2; again++)
            for (int j = 0; j < i; j++) {
                const double *other = direction + (size_t)j * (size_t)size;
                double along = lyapunov_dot(size, own, other);
                for (int k = 0; k < size; k++) own[k] -= along * other[k];
            }
        length[i] = sqrt(lyapunov_dot(size, own, own));
        if (!(length[i] > 0 && isfinite(length[i]))) return 0;
        for (int k = 0; k < size; k++) own[k] /= length[i];
    }
    return 1;
}

/* sets initial directions that are not symmetries of any tree */
static void lyapunov_aim(struct pend_lyapunov *lyapunov) {
    int size = 2 * lyapunov->n;
    for (int i = 0; i < lyapunov->count; i++)
        for (int k = 0; k < size; k++)
            lyapunov->direction[(size_t)i * (size_t)size + (size_t)k] =
                pend_rng_normal(LYAPUNOV_SEED, (uint64_t)i, (uint32_t)k);
    (void)lyapunov_straighten(lyapunov->count, size, lyapunov->direction, lyapunov->length);
}

/* --- an interval --- */

/* Turns the ends of the neighbours into directions, in the first rows after the motion's own.
 * Returns 0 if the deviation from linearity is too large. With two opposite neighbours this error
 * grows as the third power of their distance. */
static int lyapunov_turn(struct pend_lyapunov *lyapunov) {
    size_t size = 2 * (size_t)lyapunov->n;
    double longest = 0, shortest = INFINITY;
    for (size_t i = 0; i < (size_t)lyapunov->count; i++) {
        const double *ahead = lyapunov->end + (2 * i + 1) * size, *behind = ahead + size;
        double *own = lyapunov->end + (i + 1) * size;
        for (size_t k = 0; k < size; k++) own[k] = (ahead[k] - behind[k]) / (2 * lyapunov_distance);
        longest = fmax(longest, sqrt(lyapunov_dot((int)size, own, own)));
    }
    if (!lyapunov_straighten(lyapunov->count, (int)size, lyapunov->end + size, lyapunov->length))
        return 0;
    for (int i = 0; i < lyapunov->count; i++) shortest = fmin(shortest, lyapunov->length[i]);
    double neglected =
        longest * longest * longest * lyapunov_distance * lyapunov_distance / shortest;
    lyapunov->neglected = fmax(lyapunov->neglected, neglected);
    return neglected <= lyapunov_error;
}

/* starts the next piece at the end of this piece; removes whole turns, which would cost digits */
static void lyapunov_follow(struct pend_lyapunov *lyapunov) {
    size_t size = 2 * (size_t)lyapunov->n;
    memcpy(lyapunov->base, lyapunov->end, size * sizeof *lyapunov->base);
    memcpy(lyapunov->direction, lyapunov->end + size,
           (size_t)lyapunov->count * size * sizeof *lyapunov->direction);
    for (int k = 0; k < lyapunov->n && lyapunov->whole; k++)
        lyapunov->base[k] = remainder(lyapunov->base[k], 2 * M_PI);
    for (int i = 0; i < lyapunov->count; i++) lyapunov->growth[i] += log(lyapunov->length[i]);
    lyapunov->piece++;
}

static enum pend_status lyapunov_fail(const struct pend_lyapunov *lyapunov,
                                      struct pend_error *error) {
    double time = (double)lyapunov->intervals * lyapunov->interval + lyapunov->failed_at;
    return pend_fail(error, lyapunov->status, -1, time, "at t = %.6g s: %s", time,
                     pend_status_text(lyapunov->status));
}

/* completes a piece; if the piece was too long, computes it again in halves */
static enum pend_status lyapunov_settle(struct pend_lyapunov *lyapunov, struct pend_error *error) {
    lyapunov->under_way = 0;
    if (lyapunov->status != PEND_OK) return lyapunov_fail(lyapunov, error);
    if (lyapunov_turn(lyapunov)) {
        lyapunov_follow(lyapunov);
        return PEND_OK;
    }
    if (lyapunov->pieces < LYAPUNOV_PIECES) {
        lyapunov->neglected = 0;
        lyapunov->pieces *= 2;
        lyapunov->piece *= 2;
        return lyapunov_open(lyapunov, error);
    }
    lyapunov->status = PEND_NOT_FINITE;
    return lyapunov_fail(lyapunov, error);
}

/* sets a mark if one is due; when all marks are used, keeps only every second one */
static void lyapunov_mark(struct pend_lyapunov *lyapunov) {
    if (lyapunov->intervals % lyapunov->a_mark) return;
    for (int i = 0; i < lyapunov->count; i++)
        lyapunov->mark[i * LYAPUNOV_MARKS + lyapunov->marks] = lyapunov->growth[i];
    if (++lyapunov->marks < LYAPUNOV_MARKS) return;
    for (int i = 0; i < lyapunov->count; i++) {
        double *mark = lyapunov->mark + i * LYAPUNOV_MARKS;
        for (int j = 0; j < LYAPUNOV_MARKS / 2; j++) mark[j] = mark[2 * j + 1];
    }
    lyapunov->marks /= 2;
    lyapunov->a_mark *= 2;
}

enum pend_status pend_lyapunov_go(struct pend_lyapunov *lyapunov, long steps, int *done,
                                  struct pend_error *error) {
    int over = 0;
    *done = 0;
    if (lyapunov->status != PEND_OK) return lyapunov_fail(lyapunov, error);
    if (!lyapunov->under_way) pend_ensemble_begin(lyapunov->ensemble, 0, 2L * lyapunov->count + 1);
    lyapunov->under_way = 1;
    PEND_TRY(pend_ensemble_go(lyapunov->ensemble, steps, &over));
    if (!over) return PEND_OK;
    PEND_TRY(lyapunov_settle(lyapunov, error));
    if (lyapunov->piece < lyapunov->pieces) return PEND_OK;
    lyapunov->intervals++;
    lyapunov_mark(lyapunov);
    *done = 1;
    // longer pieces if the last ones were shorter than necessary
    int longer = lyapunov->pieces > 1 && lyapunov->neglected < lyapunov_little;
    lyapunov->piece = 0;
    lyapunov->neglected = 0;
    if (!longer) return PEND_OK;
    lyapunov->pieces /= 2;
    return lyapunov_open(lyapunov, error);
}

/* --- the computation --- */

static enum pend_status lyapunov_check(const struct pend_lyapunov_problem *problem,
                                       struct pend_error *error) {
    if (problem->count < 1 || problem->count > 2 * problem->tree->n)
        return pend_fail(error, PEND_INVALID, -1, 0, "the count must be from 1 to %d, got %d",
                         2 * problem->tree->n, problem->count);
    if (!isfinite(problem->start))
        return pend_fail(error, PEND_INVALID, -1, 0, "the start must be a finite time");
    if (problem->interval > 0 && isfinite(problem->interval)) return PEND_OK;
    return pend_fail(error, PEND_INVALID, -1, 0, "the interval must be greater than 0, got %g",
                     problem->interval);
}

/* m, the length of the shortest arm; the first stored arm may be a cart */
static double lyapunov_shortest(const struct pend_lyapunov_problem *problem) {
    double shortest = INFINITY;
    for (int k = pend_terms_cart(problem->loads.terms); k < problem->tree->n; k++)
        shortest = fmin(shortest, problem->tree->len[k]);
    return shortest;
}

/* 1/s, approximate frequency of the fastest swing. An oscillation with its rate divided by it is
 * nearly a circle, along which directions are hardly stretched. Without gravity, it is the largest
 * rate of an arm, or 1 over the interval. */
static double lyapunov_fastest(const struct pend_lyapunov_problem *problem) {
    double shortest = lyapunov_shortest(problem);
    double frequency = sqrt(fabs(problem->loads.gravity) * sqrt(problem->tree->n) / shortest);
    const struct pend_loads *loads = &problem->loads;
    const struct pend_tree *tree = problem->tree;
    if (loads->terms)
        frequency +=
            pend_terms_rate(loads->terms, tree->parent, tree->len, tree->mass, loads->value, NULL);
    int swings = frequency > 0;
    for (int k = pend_terms_cart(loads->terms); !swings && k < tree->n; k++)
        frequency = fmax(frequency, fabs(problem->rate[k]));
    return frequency > 0 ? frequency : 1 / problem->interval;
}

enum pend_status pend_lyapunov_new(struct pend_lyapunov **lyapunov,
                                   const struct pend_lyapunov_problem *problem,
                                   struct pend_error *error) {
    *lyapunov = NULL;
    PEND_TRY(lyapunov_check(problem, error));
    PEND_TRY(pend_loads_check_series(&problem->loads, error));
    PEND_TRY(pend_run_check_tree(problem->tree, error));
    size_t n = (size_t)problem->tree->n, count = (size_t)problem->count;
    size_t numbers = 2 * n * (3 * count + 2) + (2 + LYAPUNOV_MARKS) * count;
    struct pend_lyapunov *made = calloc(1, sizeof *made + numbers * sizeof(double));
    if (!made)
        return pend_fail(error, PEND_NO_MEMORY, -1, 0, "no memory for %d directions",
                         problem->count);
    double *at = (double *)(made + 1);
    made->tree = problem->tree;
    made->loads = problem->loads;
    made->rtol = problem->rtol > 0 ? problem->rtol : 1e-14;
    made->interval = problem->interval;
    made->start = problem->start;
    made->whole = pend_terms_whole_turns(problem->loads.terms);
    made->n = problem->tree->n;
    made->count = problem->count;
    made->pieces = 1;
    made->frequency = lyapunov_fastest(problem);
    made->unit = pend_terms_cart(problem->loads.terms) ? lyapunov_shortest(problem) : 1;
    made->base = at;
    made->direction = at + 2 * n;
    made->end = made->direction + 2 * n * count;
    made->growth = made->end + 2 * n * (2 * count + 1);
    made->length = made->growth + count;
    made->mark = made->length + count;
    made->a_mark = 1;
    for (size_t k = 0; k < n; k++) {
        // neighbours are 1e-5 rad away, so that digits beyond those of a double do not matter
        double low = problem->phi_low ? problem->phi_low[k] : 0;
        made->base[k] =
            made->whole ? pend_turns_rest(problem->phi[k], low, NULL).high : problem->phi[k];
        made->base[n + k] = problem->rate[k] / made->frequency;
    }
    made->base[0] /= made->unit;
    made->base[n] /= made->unit;
    lyapunov_aim(made);
    enum pend_status status = lyapunov_open(made, error);
    if (status == PEND_OK)
        *lyapunov = made;
    else
        pend_lyapunov_free(&made);
    return status;
}

PEND_VALIDATOR lyapunov_valid(const struct pend_lyapunov *lyapunov) {
    return lyapunov->n == lyapunov->tree->n && lyapunov->count >= 1 &&
           lyapunov->count <= 2 * lyapunov->n && lyapunov->pieces >= 1 && lyapunov->piece >= 0 &&
           lyapunov->piece <= lyapunov->pieces && lyapunov->marks >= 0 &&
           lyapunov->marks <= LYAPUNOV_MARKS && lyapunov->a_mark >= 1 && lyapunov->frequency > 0 &&
           lyapunov->unit > 0;
}

void pend_lyapunov_free(struct pend_lyapunov **lyapunov) {
    if (!*lyapunov) return;
    assert(lyapunov_valid(*lyapunov));
    pend_ensemble_free(&(*lyapunov)->ensemble);
    free(*lyapunov);
    *lyapunov = NULL;
}

void pend_lyapunov_forget(struct pend_lyapunov *lyapunov) {
    assert(lyapunov_valid(lyapunov));
    lyapunov->start += (double)lyapunov->intervals * lyapunov->interval;
    lyapunov->intervals = lyapunov->marks = 0;
    lyapunov->a_mark = 1;
    for (int i = 0; i < lyapunov->count; i++) lyapunov->growth[i] = 0;
}

void pend_lyapunov_exponents(const struct pend_lyapunov *lyapunov, double exponent[]) {
    assert(lyapunov_valid(lyapunov));
    double time = (double)lyapunov->intervals * lyapunov->interval;
    for (int i = 0; i < lyapunov->count; i++)
        exponent[i] = time > 0 ? lyapunov->growth[i] / time : 0;
}

void pend_lyapunov_errors(const struct pend_lyapunov *lyapunov, double error[]) {
    assert(lyapunov_valid(lyapunov));
    double time = (double)lyapunov->intervals * lyapunov->interval,
           part = (double)lyapunov->a_mark * lyapunov->interval;
    int marks = lyapunov->marks;
    for (int i = 0; i < lyapunov->count; i++) {
        const double *mark = lyapunov->mark + i * LYAPUNOV_MARKS;
        double square = 0, mean = marks ? mark[marks - 1] / marks : 0;
        for (int j = 0; j < marks; j++) {
            double off = mark[j] - (j ? mark[j - 1] : 0) - mean;
            square += off * off;
        }
        double scatter = marks > 1 ? sqrt(square / (marks - 1) / marks) / part : 0;
        if (marks < LYAPUNOV_MARKS_LEAST && time > 0)
            scatter = fmax(scatter, fabs(lyapunov->growth[i]) / time);
        error[i] = time > 0 ? hypot(scatter, 1 / time) : 0;
    }
}

void pend_lyapunov_state(const struct pend_lyapunov *lyapunov, double phi[], double rate[]) {
    assert(lyapunov_valid(lyapunov) && phi != rate);
    for (int k = 0; k < lyapunov->n; k++) {
        phi[k] = lyapunov->base[k];
        rate[k] = lyapunov->base[lyapunov->n + k] * lyapunov->frequency;
    }
    phi[0] *= lyapunov->unit;
    rate[0] *= lyapunov->unit;
}

double pend_lyapunov_frequency(const struct pend_lyapunov *lyapunov) { return lyapunov->frequency; }

long pend_lyapunov_steps(const struct pend_lyapunov *lyapunov) { return lyapunov->steps; }
