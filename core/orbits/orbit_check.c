#include "core/orbits/orbit_check.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>

#include "core/orbits/orbit_constants.h"

/* number of instants in a period, a multiple of every tested divisor, for driven pendulums and free
 * orbits */
enum { ALL = 840, PARTS = 8 };

static size_t check_rows(int all) { return all ? ALL + 1 : PARTS + 1; }

static size_t check_numbers(size_t n, size_t rows) { return n + rows * (2 * n + 2); }

double pend_orbit_check_bytes(int n, int all) {
    return sizeof(double) * (double)check_numbers((size_t)n, check_rows(all)) + 65536 + 20000.0 * n;
}

enum pend_status pend_orbit_check_init(struct orbit_check *check, int n, int all) {
    size_t rows = check_rows(all), arms = (size_t)n;
    assert(n >= 1);
    *check = (struct orbit_check){.n = n, .rows = (int)rows};
    double *at = check->block = calloc(check_numbers(arms, rows), sizeof *at);
    if (!at) return PEND_NO_MEMORY;
    check->amplitude = at, at += arms;
    check->t = at, at += rows;
    check->seen = at, at += rows;
    check->phi = at, at += rows * arms;
    check->rate = at;
    return PEND_OK;
}

void pend_orbit_check_clear(struct orbit_check *check) {
    pend_run_free(&check->run);
    free(check->block);
    *check = (struct orbit_check){.n = 0};
}

enum pend_status pend_orbit_check_begin(struct orbit_check *check, const struct orbit_form *form,
                                        const struct pend_problem *motion,
                                        struct pend_error *error) {
    double period = pend_orbit_form_period(form);
    struct pend_problem over = *motion;
    if (check->run) check->steps += pend_run_stats(check->run).steps;
    pend_run_free(&check->run);
    for (int i = 0; i < check->rows; i++) {
        if (check->rows > PARTS + 1)
            check->t[i] = period * i / ALL;
        else
            check->t[i] = i ? period / (PARTS + 1 - i) : 0;
    }
    over.times = (struct pend_times){.count = check->rows, .list = check->t};
    check->done = 0;
    return pend_run_new(&check->run, &pend_method_taylor, &over, error);
}

static double check_away(const struct orbit_check *check, const struct orbit_form *form, int i) {
    double most = 0;
    for (int k = 0; k < check->n; k++) {
        double way = check->phi[i * check->n + k] - check->phi[k];
        double speed = check->rate[i * check->n + k] - check->rate[k];
        if (form->turns && form->kind == ORBIT_DRIVEN) way = remainder(way, 2 * M_PI);
        most = fmax(most, fmax(fabs(way), fabs(speed) / form->omega));
    }
    return most;
}

static void check_finish(struct orbit_check *check, const struct orbit_form *form) {
    int driven = form->kind == ORBIT_DRIVEN, all = check->rows > PARTS + 1, n = check->n;
    check->closure = check_away(check, form, check->rows - 1);
    check->divisor = 1;
    for (int part = 2; part <= PARTS; part++) {
        if (driven && form->times % part) continue;
        int row = all ? ALL / part : PARTS + 1 - part;
        if (check_away(check, form, row) <= orbits_alike) check->divisor = part;
    }
    for (int k = 0; all && k < n; k++) {
        double low = INFINITY, high = -INFINITY;
        for (int i = 0; i < check->rows; i++) {
            low = fmin(low, check->phi[i * n + k]);
            high = fmax(high, check->phi[i * n + k]);
        }
        check->amplitude[form->problem->tree->place[k]] = (high - low) / 2;
    }
}

enum pend_status pend_orbit_check_next(struct orbit_check *check, const struct orbit_form *form,
                                       double work, int *done, struct pend_error *error) {
    size_t from = (size_t)check->done, n = (size_t)check->n;
    struct pend_samples samples = {.cap = check->rows - check->done,
                                   .t = check->seen + from,
                                   .phi = check->phi + from * n,
                                   .rate = check->rate + from * n};
    assert(check->run && samples.cap > 0);
    *done = 0;
    PEND_TRY(pend_run_next(check->run, &samples, work, done, error));
    check->done += (int)samples.count;
    if (*done) check_finish(check, form);
    return PEND_OK;
}
