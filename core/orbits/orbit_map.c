#include "core/orbits/orbit_map.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

/* size of a row for n arms and q parameters: phi, rate, acc, the derivatives of phi and rate, and
 * both energies with their derivatives */
static size_t map_row(size_t n, size_t q) { return 3 * n + 2 * n * q + 2 * (1 + q); }

static size_t map_numbers(size_t n, size_t q) {
    return 2 + 2 * map_row(n, q); // the instants, a row in the caller's order, the results
}

double pend_orbit_map_bytes(int n, int most) {
    assert(n >= 1 && most >= 1);
    return sizeof(double) * (double)map_numbers((size_t)n, (size_t)most);
}

enum pend_status pend_orbit_map_init(struct orbit_map *map, int n, int most) {
    assert(n >= 1 && most >= 1);
    size_t rows = (size_t)n, q = (size_t)most;
    *map = (struct orbit_map){.n = n, .most = most};
    double *at = map->block = calloc(map_numbers(rows, q), sizeof *at);
    if (!at) return PEND_NO_MEMORY;
    map->instant = at, at += 2;
    map->phi = at, at += rows;
    map->rate = at, at += rows;
    map->acc = at, at += rows;
    map->phi_by = at, at += rows * q;
    map->rate_by = at, at += rows * q;
    map->energy_by = at, at += q;
    map->row = at;
    return PEND_OK;
}

void pend_orbit_map_clear(struct orbit_map *map) {
    pend_derivatives_free(&map->motion);
    free(map->block);
    *map = (struct orbit_map){.n = 0};
}

enum pend_status pend_orbit_map_begin(struct orbit_map *map, const struct pend_problem *problem,
                                      double span, int count,
                                      const struct pend_parameter parameter[],
                                      struct pend_error *error) {
    assert(span > 0 && count >= 1 && count <= map->most && problem->tree->n == map->n);
    struct pend_problem over = *problem;
    pend_derivatives_free(&map->motion);
    map->instant[0] = 0, map->instant[1] = span;
    over.times = (struct pend_times){.count = 2, .list = map->instant};
    map->count = count, map->row_next = 0;
    map->place = problem->tree->place;
    return pend_derivatives_new(&map->motion, &over, count, parameter, error);
}

static void map_take(struct orbit_map *map, const struct pend_derived_rows *rows) {
    size_t q = (size_t)map->count;
    for (size_t i = 0; i < (size_t)map->n; i++) {
        size_t k = (size_t)map->place[i];
        map->phi[k] = rows->value[PEND_DERIVED_PHI][i];
        map->rate[k] = rows->value[PEND_DERIVED_RATE][i];
        map->acc[k] = rows->value[PEND_DERIVED_ACC][i];
        memcpy(map->phi_by + k * q, rows->derivative[PEND_DERIVED_PHI] + i * q, q * sizeof(double));
        memcpy(map->rate_by + k * q, rows->derivative[PEND_DERIVED_RATE] + i * q,
               q * sizeof(double));
    }
}

enum pend_status pend_orbit_map_next(struct orbit_map *map, double work, int *done,
                                     struct pend_error *error) {
    size_t n = (size_t)map->n, q = (size_t)map->count;
    struct pend_derived_rows rows = {.value = {0}};
    long made;
    assert(map->motion && map->row_next < 2);
    *done = 0;
    rows.value[PEND_DERIVED_PHI] = map->row;
    rows.value[PEND_DERIVED_RATE] = map->row + n;
    rows.value[PEND_DERIVED_ACC] = map->row + 2 * n;
    rows.derivative[PEND_DERIVED_PHI] = map->row + 3 * n;
    rows.derivative[PEND_DERIVED_RATE] = map->row + 3 * n + n * q;
    rows.value[PEND_DERIVED_POTENTIAL] = map->row + 3 * n + 2 * n * q;
    double *potential = rows.value[PEND_DERIVED_POTENTIAL], *kinetic = potential + 1 + q;
    rows.derivative[PEND_DERIVED_POTENTIAL] = potential + 1;
    rows.value[PEND_DERIVED_KINETIC] = kinetic, rows.derivative[PEND_DERIVED_KINETIC] = kinetic + 1;
    PEND_TRY(pend_derivatives_next(map->motion, &rows, 1, work, &made, error));
    if (!made) return PEND_OK;
    if (!map->row_next++) {
        map->energy = *potential + *kinetic;
        for (size_t j = 0; j < q; j++) map->energy_by[j] = potential[1 + j] + kinetic[1 + j];
        return PEND_OK;
    }
    map_take(map, &rows);
    *done = 1;
    return PEND_OK;
}

long pend_orbit_map_steps(const struct orbit_map *map) {
    return map->motion ? pend_derivatives_steps(map->motion) : 0;
}
