#include "core/modes.h"

#include <math.h>
#include <stdlib.h>

#include "core/modes_kernel.h"
#include "core/modes_spectrum.h"
#include "core/modes_store.h"

/* frequencies that agree to this, relatively, are one multiple frequency: eigenvalues are good to a few units of the
 * last place */
#define MODES_MULTIPLE 2e-15

/* one mode of the result: number `index` of those computed of a part, occurrence `which` */
struct mode {
    double value;
    int part, index, which;
    int row; /* in the result; -1 when not selected */
};

/* a computation under way */
struct modes_work {
    const struct pend_modes_request *request;
    struct pend_spectrum *spectrum;
    int *first;    /* for each part, where its values begin in value[]; one more entry ends the last */
    double *value; /* the values computed, signed, ascending in each part */
    struct mode *mode;
    int mode_count;
    int below; /* number of modes below those computed */
    struct pend_modes *modes;
};

static enum pend_status modes_check(const struct pend_modes_request *r, int n, struct pend_error *error) {
    if (!(r->gravity > 0 && isfinite(r->gravity)))
        return pend_fail(error, PEND_INVALID, -1, 0, "gravity must be a finite number greater than 0, got %.17g",
                         r->gravity);
    int counted = r->select == PEND_SELECT_SLOWEST || r->select == PEND_SELECT_FASTEST;
    if (counted && !(r->count >= 1 && r->count <= n))
        return pend_fail(error, PEND_INVALID, -1, 0, "the number of modes must be 1 to %d, the number of arms, got %d",
                         n, r->count);
    if (r->select == PEND_SELECT_BETWEEN && !(r->from <= r->to))
        return pend_fail(error, PEND_INVALID, -1, 0, "the interval's end %.17g must not be below its begin %.17g",
                         r->to, r->from);
    return PEND_OK;
}

static double modes_signed_square(double omega) { return omega * fabs(omega); }

static double modes_omega(double value) { return copysign(sqrt(fabs(value)), value); }

/* shifts that have all selected modes between them, and few others */
static void modes_cuts(const struct modes_work *w, double cut[2]) {
    const struct pend_modes_request *r = w->request;
    int n = w->spectrum->n;
    cut[0] = -2 * w->spectrum->most;
    cut[1] = 2 * w->spectrum->most;
    if (r->select == PEND_SELECT_SLOWEST) cut[1] = pend_spectrum_cut(w->spectrum, r->count, 1);
    if (r->select == PEND_SELECT_FASTEST) cut[0] = pend_spectrum_cut(w->spectrum, n - r->count, 0);
    if (r->select != PEND_SELECT_BETWEEN) return;
    double from = modes_signed_square(r->from), to = modes_signed_square(r->to);
    cut[0] = fmax(cut[0], from - 1e-12 * fabs(from));
    cut[1] = fmin(cut[1], to + 1e-12 * fabs(to));
}

/* the numbers first .. end - 1 of a part's eigenvalues that lie between the cuts */
static void modes_range(const struct modes_work *w, int part, const double cut[2], int *first, int *end) {
    const struct pend_laplacian *l = w->spectrum->part[part];
    const struct pend_modes_request *r = w->request;
    if (w->spectrum->symmetry->part_count == 1 && r->select != PEND_SELECT_BETWEEN) {
        /* numbers are known without counting */
        *first = r->select == PEND_SELECT_FASTEST ? l->n - r->count : 0;
        *end = r->select == PEND_SELECT_SLOWEST ? r->count : l->n;
        return;
    }
    struct pend_modes_probe probe[2] = {{.shift = cut[0]}, {.shift = cut[1]}};
    pend_modes_kernel()->probe(l, 2, probe);
    *first = probe[0].below;
    *end = probe[1].below > *first ? probe[1].below : *first;
}

/* all eigenvalues between the cuts, part by part, and the modes that they make */
static enum pend_status modes_values(struct modes_work *w) {
    struct pend_spectrum *s = w->spectrum;
    int parts = s->symmetry->part_count, values = 0, modes = 0, single = parts == 1;
    double cut[2] = {0, 0};
    if (!single || w->request->select == PEND_SELECT_BETWEEN) modes_cuts(w, cut);
    w->first = malloc(2 * ((size_t)parts + 1) * sizeof *w->first);
    if (!w->first) return PEND_NO_MEMORY;
    int *number = w->first + parts + 1;
    for (int p = 0; p < parts; p++) {
        int end, times = s->symmetry->part[p].times;
        modes_range(w, p, cut, &number[p], &end);
        w->first[p] = values;
        values += end - number[p];
        modes += times * (end - number[p]);
        w->below += times * number[p];
    }
    w->first[parts] = values;
    w->value = malloc(((size_t)values + 1) * sizeof *w->value);
    w->mode = malloc(((size_t)modes + 1) * sizeof *w->mode);
    if (!w->value || !w->mode) return PEND_NO_MEMORY;
    for (int p = 0; p < parts; p++) {
        int count = w->first[p + 1] - w->first[p];
        double *value = w->value + w->first[p];
        PEND_TRY(pend_spectrum_values(s, p, number[p], count, value));
        for (int index = 0; index < count; index++)
            for (int which = 0; which < s->symmetry->part[p].times; which++)
                w->mode[w->mode_count++] = (struct mode){value[index], p, index, which, -1};
    }
    return PEND_OK;
}

static int modes_by_value(const void *a, const void *b) {
    const struct mode *x = a, *y = b;
    if (x->value != y->value) return x->value < y->value ? -1 : 1;
    if (x->part != y->part) return x->part < y->part ? -1 : 1;
    if (x->index != y->index) return x->index < y->index ? -1 : 1;
    return x->which < y->which ? -1 : x->which > y->which;
}

static int modes_by_part(const void *a, const void *b) {
    const struct mode *x = a, *y = b;
    if (x->part != y->part) return x->part < y->part ? -1 : 1;
    if (x->index != y->index) return x->index < y->index ? -1 : 1;
    return x->which < y->which ? -1 : x->which > y->which;
}

/* sorts the modes, gives rows to those selected; returns their number */
static int modes_rows(struct modes_work *w, int *first) {
    const struct pend_modes_request *r = w->request;
    int begin = 0, end = w->mode_count;
    if (w->spectrum->symmetry->part_count > 1) qsort(w->mode, (size_t)w->mode_count, sizeof *w->mode, modes_by_value);
    if (r->select == PEND_SELECT_SLOWEST) end = r->count;
    if (r->select == PEND_SELECT_FASTEST) begin = end - r->count;
    if (r->select == PEND_SELECT_BETWEEN) {
        while (begin < end && modes_omega(w->mode[begin].value) < r->from) begin++;
        while (begin < end && modes_omega(w->mode[end - 1].value) > r->to) end--;
    }
    for (int i = begin; i < end; i++) w->mode[i].row = i - begin;
    *first = w->below + begin;
    return end - begin;
}

/* the vectors of one part, its modes being mode[0 .. count-1] in order of index */
static enum pend_status modes_part_vectors(struct modes_work *w, struct mode mode[], int count) {
    struct pend_spectrum *s = w->spectrum;
    int part = mode[0].part, n = s->part[part]->n, whole = s->symmetry->part_count == 1, low = -1, high = -1;
    for (int i = 0; i < count; i++) {
        if (mode[i].row < 0) continue;
        if (low < 0) low = mode[i].index;
        high = mode[i].index;
    }
    if (low < 0) return PEND_OK;
    size_t vectors = (size_t)(high - low + 1);
    double **vector = malloc(vectors * sizeof *vector), *room = NULL;
    enum pend_status status = PEND_NO_MEMORY;
    if (!vector) goto out;
    /* a tree without like branches has its vectors written in place */
    if (!whole && !(room = malloc(vectors * (size_t)n * sizeof *room))) goto out;
    for (size_t i = 0; i < vectors; i++) vector[i] = (whole ? w->modes->vector : room) + i * (size_t)n;
    status = pend_spectrum_vectors(s, part, (int)vectors, w->value + w->first[part] + low, whole ? s->lead : 0, vector);
    for (int i = 0; !whole && i < count; i++)
        if (mode[i].row >= 0)
            pend_symmetry_spread(s->symmetry, part, mode[i].which, vector[mode[i].index - low], s->place,
                                 w->modes->vector + (size_t)mode[i].row * (size_t)s->n);
out:
    free(vector);
    free(room);
    return status;
}

/* about hanging omega^2 = sum g l W theta^2 for a vector of mass norm 1, so no angle exceeds omega times this */
static double modes_bound(const struct pend_modes_request *r, const struct pend_tree *tree) {
    double least = INFINITY;
    for (int k = 0; k < tree->n; k++) least = fmin(least, r->gravity * tree->len[k] * tree->subtree_mass[k]);
    return r->up ? 0 : 1 / sqrt(least);
}

static enum pend_status modes_vectors(struct modes_work *w, const struct pend_tree *tree) {
    if (w->spectrum->symmetry->part_count > 1) qsort(w->mode, (size_t)w->mode_count, sizeof *w->mode, modes_by_part);
    for (int i = 0, end; i < w->mode_count; i = end) {
        for (end = i + 1; end < w->mode_count && w->mode[end].part == w->mode[i].part;) end++;
        PEND_TRY(modes_part_vectors(w, w->mode + i, end - i));
    }
    /* so far an angle is a displacement to the right over a length; a standing arm turns the other way */
    for (int k = 0; w->request->up && k < tree->n; k++)
        for (int i = 0; w->request->up[k] && i < w->modes->count; i++) w->modes->vector[(size_t)i * tree->n + k] *= -1;
    pend_modes_settle(w->modes, tree, MODES_MULTIPLE, modes_bound(w->request, tree), NULL);
    return PEND_OK;
}

static enum pend_status modes_solve(struct modes_work *w, const struct pend_tree *tree) {
    int first;
    PEND_TRY(pend_spectrum_new(&w->spectrum, tree, w->request->gravity, w->request->up));
    PEND_TRY(modes_values(w));
    int count = modes_rows(w, &first);
    PEND_TRY(pend_modes_alloc(&w->modes, count, tree->n, w->request->vectors));
    w->modes->first = first;
    for (int i = 0; i < w->mode_count; i++) {
        if (w->mode[i].row < 0) continue;
        w->modes->omega[w->mode[i].row] = modes_omega(w->mode[i].value);
        w->modes->growing += w->mode[i].value < 0;
    }
    return w->request->vectors ? modes_vectors(w, tree) : PEND_OK;
}

enum pend_status pend_modes_select(struct pend_modes **modes, const struct pend_tree *tree,
                                   const struct pend_modes_request *request, struct pend_error *error) {
    *modes = NULL;
    PEND_TRY(modes_check(request, tree->n, error));
    struct modes_work w = {.request = request};
    enum pend_status status = modes_solve(&w, tree);
    if (status) {
        pend_modes_free(&w.modes);
        pend_fail(error, status, -1, 0, "%s: the modes of %d arms", pend_status_text(status), tree->n);
    }
    *modes = w.modes;
    pend_spectrum_free(&w.spectrum);
    free(w.first);
    free(w.value);
    free(w.mode);
    return status;
}

enum pend_status pend_modes_new(struct pend_modes **modes, const struct pend_tree *tree, double gravity, int vectors,
                                struct pend_error *error) {
    struct pend_modes_request request = {.gravity = gravity, .vectors = vectors};
    return pend_modes_select(modes, tree, &request, error);
}
