#include "core/modes/modes.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>

#include "core/modes/modes_kernel.h"
#include "core/modes/modes_spectrum.h"
#include "core/modes/modes_vectors.h"

/* frequencies within this relative difference count as one repeated frequency: the relative error
 * of an eigenvalue is a few units in the last digit */
#define MODES_MULTIPLE 2e-15

/* at this ratio of eigenvalues, rounding errors of large terms exceed the squares of the smallest
 * frequencies */
#define MODES_FAR 1e30

/* the number of vectors that one step expands or scales */
enum { MODES_PIECE = 32 };

/* eigenvalue number `index` among the computed ones of a part, with all its occurrences */
struct mode {
    double value;
    int part, index;
    int row; /* row of the first occurrence in the result; negative if not selected */
};

/* the task of the next step; the phases follow each other in this order */
enum phase {
    PHASE_VALUES,
    PHASE_ROWS,
    PHASE_VECTORS,
    PHASE_SPREAD,
    PHASE_STAND,
    PHASE_BASES,
    PHASE_SCALE,
    PHASE_DONE
};

struct pend_modes_search {
    struct pend_modes_request request;
    const struct pend_tree *tree;
    struct pend_spectrum *spectrum;
    enum phase phase;
    int part;      /* the current part, in PHASE_VALUES */
    int *first;    /* for each part, where its eigenvalues begin in value[]; one more entry */
    int *number;   /* number of each part's first computed eigenvalue */
    double *value; /* the computed eigenvalues, signed, ascending within each part */
    struct mode *mode;
    int mode_count;
    int below;      /* number of modes below the computed ones */
    int drop, keep; /* the requested rows are drop .. keep - 1; the others only complete repeated
                     * frequencies */
    struct pend_modes *modes;
    int *lead;   /* for each row, the first moving arm, in the caller's numbering; -1: unknown */
    int at, end; /* in PHASE_VECTORS and PHASE_SPREAD, the modes of the current part */
    int low;     /* index of the first of these vectors */
    int row;     /* in PHASE_SPREAD, occurrences done; from PHASE_STAND on, index of the next row */
    struct pend_vectors *vectors;
    double **vector, *room;
};

PEND_VALIDATOR modes_search_valid(const struct pend_modes_search *s) {
    const struct pend_modes_request *r = &s->request;
    int parts = s->spectrum->symmetry->part_count;
    return s->phase <= PHASE_DONE && s->part >= 0 && s->part <= parts && r->first >= 0 &&
           r->count >= 0 && r->count <= s->tree->n - r->first && s->at <= s->end &&
           s->end <= s->mode_count && s->drop >= 0 && s->drop <= s->keep &&
           s->mode_count <= s->first[parts];
}

static enum pend_status modes_check(const struct pend_modes_request *r, int n,
                                    struct pend_error *error) {
    PEND_TRY(pend_loads_check_linear(&r->loads, error));
    int first = r->select == PEND_SELECT_NUMBERS ? r->first : 0,
        counted = r->select != PEND_SELECT_ALL;
    if (r->select == PEND_SELECT_BETWEEN) counted = 0;
    if (counted && !(first >= 0 && first < n && r->count >= 1 && r->count <= n - first))
        return pend_fail(error, PEND_INVALID, -1, 0,
                         "the number of modes must be 1 to %d, the number of arms, got %d",
                         n - first, r->count);
    if (r->select == PEND_SELECT_BETWEEN && !(r->from <= r->to))
        return pend_fail(error, PEND_INVALID, -1, 0,
                         "the interval's end %.17g must not be below its begin %.17g", r->to,
                         r->from);
    return PEND_OK;
}

static double modes_omega(double value) { return copysign(sqrt(fabs(value)), value); }

/* converts every selection to the mode numbers first .. first + count - 1 */
static void modes_numbers(struct pend_modes_search *s) {
    struct pend_modes_request *r = &s->request;
    if (r->select == PEND_SELECT_BETWEEN)
        pend_spectrum_between(s->spectrum, r->from, r->to, &r->first, &r->count);
    if (r->select == PEND_SELECT_ALL) r->count = s->tree->n;
    if (r->select == PEND_SELECT_ALL || r->select == PEND_SELECT_SLOWEST) r->first = 0;
    if (r->select == PEND_SELECT_FASTEST) r->first = s->tree->n - r->count;
}

/* the range first .. end - 1 of a part's eigenvalues that lie between the cuts */
static void modes_range(const struct pend_modes_search *s, int part, const double cut[2],
                        int *first, int *end) {
    const struct pend_laplacian *l = s->spectrum->part[part];
    const struct pend_modes_request *r = &s->request;
    /* with one part, or with all modes or none, no eigenvalue has to be counted */
    *first = r->count && r->count < s->tree->n ? r->first : 0;
    *end = r->count < s->tree->n ? *first + r->count : l->n;
    if (s->spectrum->symmetry->part_count == 1 || !r->count || r->count == s->tree->n) return;
    struct pend_modes_probe probe[2] = {{.shift = cut[0]}, {.shift = cut[1]}};
    PEND_ISA_PICK(pend_modes_kernel, pend_isa_best())->probe(l, 2, probe);
    *first = probe[0].below;
    *end = probe[1].below > *first ? probe[1].below : *first;
}

static enum pend_status modes_plan(struct pend_modes_search *s) {
    int parts = s->spectrum->symmetry->part_count, values = 0;
    double cut[2] = {0, 0};
    if (parts > 1 && s->request.count && s->request.count < s->tree->n) {
        /* shifts between which all selected modes lie, and few others */
        cut[0] = pend_spectrum_cut(s->spectrum, s->request.first, 0);
        cut[1] = pend_spectrum_cut(s->spectrum, s->request.first + s->request.count, 1);
    }
    s->first = malloc(2 * ((size_t)parts + 1) * sizeof *s->first);
    if (!s->first) return PEND_NO_MEMORY;
    s->number = s->first + parts + 1;
    for (int p = 0; p < parts; p++) {
        int end;
        modes_range(s, p, cut, &s->number[p], &end);
        s->first[p] = values;
        values += end - s->number[p];
        s->below += s->spectrum->symmetry->part[p].times * s->number[p];
    }
    s->first[parts] = values;
    s->value = malloc(((size_t)values + 1) * sizeof *s->value);
    s->mode = malloc(((size_t)values + 1) * sizeof *s->mode);
    return s->value && s->mode ? PEND_OK : PEND_NO_MEMORY;
}

/* starts the search for a part's eigenvalues; after the last part, starts the next phase */
static void modes_part_begin(struct pend_modes_search *s) {
    if (s->part == s->spectrum->symmetry->part_count) {
        s->phase = PHASE_ROWS;
        return;
    }
    int count = s->first[s->part + 1] - s->first[s->part];
    pend_spectrum_search(s->spectrum, s->part, s->number[s->part], count,
                         s->value + s->first[s->part]);
}

static enum pend_status modes_values(struct pend_modes_search *s) {
    int done = 0;
    PEND_TRY(pend_spectrum_step(s->spectrum, &done));
    if (!done) return PEND_OK;
    for (int i = s->first[s->part]; i < s->first[s->part + 1]; i++)
        s->mode[s->mode_count++] = (struct mode){s->value[i], s->part, i - s->first[s->part], -1};
    s->part++;
    modes_part_begin(s);
    return PEND_OK;
}

static int modes_by_value(const void *a, const void *b) {
    const struct mode *x = a, *y = b;
    if (x->value != y->value) return x->value < y->value ? -1 : 1;
    if (x->part != y->part) return x->part < y->part ? -1 : 1;
    return x->index < y->index ? -1 : x->index > y->index;
}

static int modes_by_part(const void *a, const void *b) {
    const struct mode *x = a, *y = b;
    if (x->part != y->part) return x->part < y->part ? -1 : 1;
    return x->index < y->index ? -1 : x->index > y->index;
}

static int modes_times(const struct pend_modes_search *s, const struct mode *mode) {
    return s->spectrum->symmetry->part[mode->part].times;
}

/* sorts the computed modes in ascending order and numbers their rows */
static void modes_count_rows(struct pend_modes_search *s) {
    int rows = 0;
    if (s->spectrum->symmetry->part_count > 1)
        qsort(s->mode, (size_t)s->mode_count, sizeof *s->mode, modes_by_value);
    for (int i = 0; i < s->mode_count; i++) {
        s->mode[i].row = rows;
        rows += modes_times(s, &s->mode[i]);
    }
}

/* the first (by = -1) or last (by = 1) mode whose frequency equals that of mode i */
static int modes_extend(const struct pend_modes_search *s, int i, int by) {
    while (s->request.vectors && i + by >= 0 && i + by < s->mode_count) {
        double omega = modes_omega(s->mode[i].value), next = modes_omega(s->mode[i + by].value);
        if (fabs(next - omega) > MODES_MULTIPLE * fabs(omega)) break;
        i += by;
    }
    return i;
}

/* fills the rows of the result with modes low .. high - 1; the row `from` becomes row 0 */
static void modes_fill_rows(struct pend_modes_search *s, int low, int high, int from) {
    for (int i = low; i < high; i++) {
        s->mode[i].row -= from;
        for (int j = 0; j < modes_times(s, &s->mode[i]); j++) {
            int row = s->mode[i].row + j;
            if (row < 0 || row >= s->modes->count) continue;
            s->modes->omega[row] = modes_omega(s->mode[i].value);
            s->lead[row] = -1;
        }
    }
}

/* Allocates the rows of the result: the requested ones, begin .. end - 1 of those computed, and the
 * other rows of repeated frequencies that the selection cuts. pend_modes_trim removes the
 * latter. */
static enum pend_status modes_rows(struct pend_modes_search *s) {
    const struct pend_modes_request *r = &s->request;
    int begin = (r->count ? r->first : s->below) - s->below, end = begin + r->count, low = 0,
        high = s->mode_count;
    modes_count_rows(s);
    /* the modes in these rows */
    while (low < high && s->mode[low].row + modes_times(s, &s->mode[low]) <= begin) low++;
    while (low < high && s->mode[high - 1].row >= end) high--;
    if (low < high) {
        low = modes_extend(s, low, -1);
        high = modes_extend(s, high - 1, 1) + 1;
    }
    int from = begin, to = end;
    if (low < high && r->vectors) {
        from = s->mode[low].row;
        to = s->mode[high - 1].row + modes_times(s, &s->mode[high - 1]);
    }
    PEND_TRY(pend_modes_alloc(&s->modes, to - from, s->tree->n, r->vectors));
    s->lead = malloc(((size_t)(to - from) + 1) * sizeof *s->lead);
    if (!s->lead) return PEND_NO_MEMORY;
    s->modes->first = r->first;
    s->drop = begin - from;
    s->keep = end - from;
    modes_fill_rows(s, low, high, from);
    /* later phases use only the modes `low` .. `high` - 1 */
    s->at = s->end = low;
    s->mode_count = high;
    if (r->vectors && s->spectrum->symmetry->part_count > 1)
        qsort(s->mode + low, (size_t)(high - low), sizeof *s->mode, modes_by_part);
    return PEND_OK;
}

/* starts the vectors of the next part; after the last part, starts the next phase */
static enum pend_status modes_run_begin(struct pend_modes_search *s) {
    struct pend_spectrum *spectrum = s->spectrum;
    int whole = spectrum->symmetry->part_count == 1;
    pend_vectors_free(&s->vectors);
    free(s->vector);
    free(s->room);
    s->vector = NULL;
    s->room = NULL;
    s->at = s->end;
    if (s->at == s->mode_count) {
        s->phase = s->request.up ? PHASE_STAND : PHASE_BASES;
        s->row = 0;
        return PEND_OK;
    }
    int part = s->mode[s->at].part, n = spectrum->part[part]->n;
    while (s->end < s->mode_count && s->mode[s->end].part == part) s->end++;
    s->low = s->mode[s->at].index;
    size_t count = (size_t)(s->mode[s->end - 1].index - s->low + 1);
    s->vector = malloc(count * sizeof *s->vector);
    /* in a tree without like branches, vectors are computed directly in the rows of the result */
    if (!whole) s->room = malloc(count * (size_t)n * sizeof *s->room);
    if (!s->vector || (!whole && !s->room)) return PEND_NO_MEMORY;
    for (size_t i = 0; i < count; i++)
        s->vector[i] = (whole ? s->modes->vector : s->room) + i * (size_t)n;
    const double *value = s->value + s->first[part] + s->low;
    s->phase = PHASE_VECTORS;
    return pend_vectors_new(&s->vectors, spectrum->part[part], (int)count, value,
                            whole ? spectrum->lead : 0, s->vector);
}

static enum pend_status modes_vectors(struct pend_modes_search *s) {
    int done = 0, part = s->mode[s->at].part;
    PEND_TRY(pend_vectors_step(s->vectors, &done));
    if (!done) return PEND_OK;
    if (s->spectrum->symmetry->part_count == 1) return modes_run_begin(s);
    pend_symmetry_places(s->spectrum->symmetry, part, s->spectrum->place);
    s->phase = PHASE_SPREAD;
    s->row = 0;
    return PEND_OK;
}

/* expands occurrences of one mode over the whole tree, then continues with the next mode or part */
static enum pend_status modes_spread(struct pend_modes_search *s) {
    const struct mode *mode = &s->mode[s->at];
    int times = modes_times(s, mode), n = s->spectrum->part[mode->part]->n;
    const double *angle = s->vector[mode->index - s->low];
    double largest = 0;
    for (int k = 0; k < n; k++) largest = fabs(angle[k]) > largest ? fabs(angle[k]) : largest;
    for (int piece = 0; piece < MODES_PIECE && s->row < times; piece++, s->row++) {
        int row = mode->row + s->row;
        s->lead[row] = pend_symmetry_spread(s->spectrum->symmetry, mode->part, s->row, angle,
                                            PEND_MODES_ZERO * largest, s->spectrum->place,
                                            s->modes->vector + (size_t)row * (size_t)s->tree->n);
    }
    if (s->row < times) return PEND_OK;
    s->row = 0;
    return ++s->at == s->end ? modes_run_begin(s) : PEND_OK;
}

/* Changes signs. Until here an angle is a displacement to the right divided by a length; an upright
 * arm turns the other way. */
static void modes_stand(struct pend_modes_search *s) {
    for (int piece = 0; piece < MODES_PIECE && s->row < s->modes->count; piece++, s->row++) {
        double *x = s->modes->vector + (size_t)s->row * (size_t)s->tree->n;
        for (int k = 0; k < s->tree->n; k++) x[k] = s->request.up[k] ? -x[k] : x[k];
    }
    if (s->row < s->modes->count) return;
    s->phase = PHASE_BASES;
    s->row = 0;
}

/* sets the basis of the next repeated frequency, or of the next few simple ones */
static void modes_bases(struct pend_modes_search *s) {
    struct pend_modes *modes = s->modes;
    for (int piece = 0; piece < MODES_PIECE && s->row < modes->count;) {
        int next = pend_modes_basis(modes, s->tree, MODES_MULTIPLE, s->row, s->lead);
        piece += next - s->row;
        s->row = next;
    }
    if (s->row < modes->count) return;
    s->phase = PHASE_SCALE;
    s->row = 0;
}

static void modes_scale(struct pend_modes_search *s) {
    struct pend_modes *modes = s->modes;
    const struct pend_modes_request *r = &s->request;
    // about hanging, omega^2 = sum g l W theta^2 for a vector of mass norm 1, so no angle exceeds
    // omega times the bound
    double least = INFINITY;
    for (int k = 0; k < s->tree->n; k++)
        least = fmin(least, r->loads.gravity * s->tree->len[k] * s->tree->subtree_mass[k]);
    double bound = r->up ? 0 : 1 / sqrt(least);
    for (int piece = 0; piece < MODES_PIECE && s->row < modes->count; piece++, s->row++) {
        const double *x = modes->vector + (size_t)s->row * (size_t)s->tree->n;
        modes->norm[s->row] = 1;
        int *lead = &s->lead[s->row];
        /* the kernel made the first entry positive; the bound guarantees that it is not zero */
        if (*lead < 0 && bound > 0 &&
            x[s->tree->place[0]] > PEND_MODES_ZERO * bound * modes->omega[s->row])
            *lead = 0;
        if (*lead >= 0 && x[s->tree->place[*lead]] > 0 && r->normalize == PEND_NORMALIZE_MASS)
            continue;
        pend_modes_scale(modes, s->tree, s->row, r->normalize, *lead);
    }
    if (s->row == modes->count) s->phase = PHASE_DONE;
}

static enum pend_status modes_step(struct pend_modes_search *s) {
    switch (s->phase) {
    case PHASE_VALUES:
        return modes_values(s);
    case PHASE_ROWS:
        PEND_TRY(modes_rows(s));
        s->phase = PHASE_DONE;
        return s->request.vectors ? modes_run_begin(s) : PEND_OK;
    case PHASE_VECTORS:
        return modes_vectors(s);
    case PHASE_SPREAD:
        return modes_spread(s);
    case PHASE_STAND:
        modes_stand(s);
        return PEND_OK;
    case PHASE_BASES:
        modes_bases(s);
        return PEND_OK;
    case PHASE_SCALE:
        modes_scale(s);
        return PEND_OK;
    case PHASE_DONE:
        return PEND_OK;
    }
    return PEND_BUG;
}

static enum pend_status modes_fail(enum pend_status status, int n, struct pend_error *error) {
    return pend_fail(error, status, -1, 0, "%s: the modes of %d arms", pend_status_text(status), n);
}

enum pend_status pend_modes_search_new(struct pend_modes_search **search,
                                       const struct pend_tree *tree,
                                       const struct pend_modes_request *request,
                                       struct pend_error *error) {
    *search = NULL;
    PEND_TRY(modes_check(request, tree->n, error));
    struct pend_modes_search *s = *search = calloc(1, sizeof *s);
    enum pend_status status = PEND_NO_MEMORY;
    if (!s) goto out;
    s->request = *request;
    s->tree = tree;
    status = pend_spectrum_new(&s->spectrum, tree, &request->loads, request->up);
    if (!status && pend_spectrum_check(s->spectrum, error)) {
        pend_modes_search_free(search);
        return PEND_INVALID;
    }
    if (!status) modes_numbers(s);
    if (!status) status = modes_plan(s);
    if (!status) modes_part_begin(s);
    assert(status || modes_search_valid(s));
out:
    if (status) pend_modes_search_free(search);
    return status ? modes_fail(status, tree->n, error) : PEND_OK;
}

int pend_modes_search_count(const struct pend_modes_search *search) {
    return search->request.count;
}

enum pend_status pend_modes_search_step(struct pend_modes_search *search, int *done,
                                        struct pend_error *error) {
    assert(modes_search_valid(search));
    const struct pend_spectrum *spectrum = search->spectrum;
    enum pend_status status = modes_step(search);
    if (status == PEND_NO_CONVERGENCE && !(spectrum->most < MODES_FAR * spectrum->least))
        return pend_fail(
            error, PEND_NOT_FINITE, -1, 0,
            "lengths and masses differ too much: no orthogonal modes of %d arms were found",
            search->tree->n);
    if (status) return modes_fail(status, search->tree->n, error);
    *done = search->phase == PHASE_DONE;
    assert(modes_search_valid(search));
    return PEND_OK;
}

struct pend_modes *pend_modes_search_take(struct pend_modes_search *search) {
    struct pend_modes *modes = search->modes;
    assert(search->phase == PHASE_DONE);
    if (modes) pend_modes_trim(modes, search->drop, search->keep);
    search->modes = NULL;
    return modes;
}

void pend_modes_search_free(struct pend_modes_search **search) {
    struct pend_modes_search *s = *search;
    if (!s) return;
    pend_vectors_free(&s->vectors);
    free(s->vector);
    free(s->room);
    free(s->lead);
    pend_modes_free(&s->modes);
    free(s->mode);
    free(s->value);
    free(s->first);
    pend_spectrum_free(&s->spectrum);
    free(s);
    *search = NULL;
}

double pend_modes_cost(int n, int count, int vectors) {
    assert(n >= 1 && count >= 0);
    /* time: 4.4 sweeps per eigenvalue at 1 ns per arm; a vector takes about as long as 8 sweeps,
     * more if vectors do not fit into the cache */
    return 1e-9 * n * (count + 20.0) * (vectors ? 20 : 5.5);
}

enum pend_status pend_modes_select(struct pend_modes **modes, const struct pend_tree *tree,
                                   const struct pend_modes_request *request,
                                   struct pend_error *error) {
    struct pend_modes_search *search;
    *modes = NULL;
    enum pend_status status = pend_modes_search_new(&search, tree, request, error);
    for (int done = 0; !status && !done;) status = pend_modes_search_step(search, &done, error);
    if (!status) *modes = pend_modes_search_take(search);
    pend_modes_search_free(&search);
    return status;
}

enum pend_status pend_modes_new(struct pend_modes **modes, const struct pend_tree *tree,
                                const struct pend_loads *loads, int vectors,
                                struct pend_error *error) {
    struct pend_modes_request request = {.loads = *loads, .vectors = vectors};
    return pend_modes_select(modes, tree, &request, error);
}
