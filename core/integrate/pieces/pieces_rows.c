#include "core/integrate/pieces/pieces.h"

#include <assert.h>
#include <string.h>

#include "core/integrate/pieces/balance.h"
#include "core/integrate/pieces/pieces_work.h"
#include "core/taylor/jets/jets.h"

/* fills in up to PIECES_ROWS rows of the whole pendulum; forces by the balance of accelerations */
static void pieces_rows(struct pieces *p, const double t[], int count,
                        const struct pend_points *to) {
    const struct pend_stuck *stuck = p->stuck;
    size_t n = (size_t)p->problem.tree->n, part = PIECES_ROWS * n, left = n;
    struct pend_points rows = {.phi = to->phi, .rate = to->rate, .theta = to->theta};
    if (stuck) {
        left = (size_t)stuck->tree->n;
        rows = (struct pend_points){.phi = p->room, .rate = p->room + part};
        if (to->theta) rows.theta = p->room + 3 * part;
    }
    if (to->acc || to->force) rows.acc = p->room + 2 * part;
    p->inner->at(p->stepper, t, count, &rows);
    for (size_t i = 0; i < (size_t)count; i++) {
        double *phi = to->phi + i * n, *rate = to->rate + i * n,
               *acc = rows.acc ? rows.acc + i * left : NULL;
        if (stuck) pend_stuck_turn(stuck, rows.phi + i * left, NULL, phi, NULL);
        if (stuck) pend_stuck_spread(stuck, rows.rate + i * left, rate);
        if (stuck && to->theta)
            pend_stuck_turn(stuck, rows.theta + i * left, NULL, to->theta + i * n, NULL);
        if (stuck && rows.acc) acc = pend_stuck_spread(stuck, acc, p->joints->acc);
        if (to->acc) memcpy(to->acc + i * n, acc, n * sizeof(double));
        if (!to->force) continue;
        const struct bodies_forces forces = {.tip_along = to->force + i * n};
        const struct pend_moving moving = {p->piece.start + t[i], phi, rate, acc};
        pend_balance(p->problem.tree, &p->problem.loads, &moving, p->joints->room, NULL, &forces);
    }
}

void pend_pieces_at(void *stepper, const double t[], int count, const struct pend_points *points) {
    struct pieces *p = stepper;
    size_t n = (size_t)p->problem.tree->n;
    if (!p->joints) {
        p->inner->at(p->stepper, t, count, points);
        return;
    }
    for (int i = 0; i < count; i += PIECES_ROWS) {
        size_t at = (size_t)i * n;
        const struct pend_points rows = {
            points->phi + at, points->rate + at, points->acc ? points->acc + at : NULL,
            points->force ? points->force + at : NULL, points->theta ? points->theta + at : NULL};
        pieces_rows(p, t + i, count - i < PIECES_ROWS ? count - i : PIECES_ROWS, &rows);
    }
}

void pend_pieces_forces(void *stepper, double time, const double phi[], const double rate[],
                        double acc[], const struct bodies_forces *forces) {
    struct pieces *p = stepper;
    const struct pend_moving moving = {time, phi, rate, acc};
    assert(p->joints);
    pend_joints_accelerations(p->joints, p->stuck, time, phi, rate, acc);
    pend_balance(p->problem.tree, &p->problem.loads, &moving, p->joints->room, NULL, forces);
}

void pend_pieces_series(const void *stepper, const struct pend_series *series, double rate[],
                        double phi[], double phi_low[]) {
    const struct pieces *p = stepper;
    const struct pend_stuck *stuck = p->stuck;
    size_t n = (size_t)p->problem.tree->n;
    for (int k = 0; k < (int)n; k++)
        for (int j = 0; j <= series->order; j++)
            rate[(size_t)j * n + (size_t)k] =
                stuck && stuck->still[k]
                    ? 0
                    : series->jets
                          ->rate[pend_jets_place(series->jets, stuck ? stuck->rep[k] : k, j)];
    if (stuck) {
        pend_stuck_turn(stuck, series->begin->phi, series->begin->phi_low, phi, phi_low);
        return;
    }
    memcpy(phi, series->begin->phi, n * sizeof(double));
    memcpy(phi_low, series->begin->phi_low, n * sizeof(double));
}
