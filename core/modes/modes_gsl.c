#include "core/modes/modes_gsl.h"

#include <math.h>
#include <stdlib.h>

#include <gsl/gsl_eigen.h>

/* Memory of GSL's own objects comes from one block: workspaces are built by hand, since
 * gsl_*_alloc calls the program's error handler when memory is short. */
struct gsl_room {
    gsl_matrix_view matrix, vector;
    gsl_vector_view value;
    gsl_eigen_symmv_workspace work;
    double data[];
};

static struct gsl_room *gsl_room_new(int n) {
    size_t square = (size_t)n * (size_t)n;
    struct gsl_room *room = calloc(1, sizeof *room + (2 * square + 6 * (size_t)n) * sizeof(double));
    if (!room) return NULL;
    room->matrix = gsl_matrix_view_array(room->data, (size_t)n, (size_t)n);
    room->vector = gsl_matrix_view_array(room->data + square, (size_t)n, (size_t)n);
    double *rest = room->data + 2 * square;
    room->value = gsl_vector_view_array(rest, (size_t)n);
    room->work = (gsl_eigen_symmv_workspace){.size = (size_t)n,
                                             .d = rest + n,
                                             .sd = rest + 2 * (size_t)n,
                                             .gc = rest + 3 * (size_t)n,
                                             .gs = rest + 4 * (size_t)n};
    return room;
}

/* K^{-1/2} Re(0) K^{-1/2}: for arms on one way out entry (j, k) of Re(0) is l_j l_k times the
 * mass that both carry */
static void gsl_fill(gsl_matrix *matrix, const struct pend_tree *tree,
                     const struct pend_loads *loads) {
    const double *len = tree->len, *carried = tree->subtree_mass;
    for (int k = 0; k < tree->n; k++)
        for (int j = k; j >= 0; j = tree->parent[j]) {
            double value = sqrt(len[j] * len[k]) * sqrt(carried[k] / carried[j]) / loads->gravity;
            gsl_matrix_set(matrix, (size_t)k, (size_t)j, value);
            gsl_matrix_set(matrix, (size_t)j, (size_t)k, value);
        }
}

/* theta = K^{-1/2} u; lead: n ints of scratch */
static void gsl_vectors(struct pend_modes *modes, const struct pend_tree *tree,
                        const struct pend_loads *loads, const gsl_matrix *u, double tips[],
                        int lead[]) {
    for (int mode = 0; mode < modes->n; mode++) {
        double *x = modes->vector + (size_t)mode * modes->n;
        for (int k = 0; k < modes->n; k++)
            x[k] = gsl_matrix_get(u, (size_t)k, (size_t)mode) /
                   sqrt(loads->gravity * tree->len[k] * tree->subtree_mass[k]);
        double norm = pend_modes_mass_norm(tree, x, tips);
        for (int k = 0; k < modes->n; k++) x[k] /= norm;
        lead[mode] = -1;
    }
    for (int mode = 0; mode < modes->n;)
        mode = pend_modes_basis(modes, tree, modes->n * 1e-15, mode, lead);
    for (int mode = 0; mode < modes->n; mode++) {
        modes->norm[mode] =
            pend_modes_mass_norm(tree, modes->vector + (size_t)mode * modes->n, tips);
        pend_modes_scale(modes, tree, mode, PEND_NORMALIZE_MASS, -1);
    }
}

enum pend_status pend_modes_gsl_new(struct pend_modes **modes, const struct pend_tree *tree,
                                    const struct pend_loads *loads, int vectors,
                                    struct pend_error *error) {
    enum pend_status status = PEND_OK;
    struct gsl_room *room = NULL;
    *modes = NULL;
    PEND_TRY(pend_loads_check_linear(loads, error));
    room = gsl_room_new(tree->n);
    if (!room || pend_modes_alloc(modes, tree->n, tree->n, vectors)) {
        status =
            pend_fail(error, PEND_NO_MEMORY, -1, 0, "no memory for the modes of %d arms", tree->n);
        goto out;
    }
    gsl_fill(&room->matrix.matrix, tree, loads);
    if (gsl_eigen_symmv(&room->matrix.matrix, &room->value.vector, &room->vector.matrix,
                        &room->work)) {
        status = pend_fail(error, PEND_NO_CONVERGENCE, -1, 0,
                           "the eigenvalues of %d arms did not converge", tree->n);
        goto out;
    }
    gsl_eigen_symmv_sort(&room->value.vector, &room->vector.matrix, GSL_EIGEN_SORT_VAL_DESC);
    for (int k = 0; k < tree->n; k++)
        (*modes)->omega[k] = 1 / sqrt(gsl_vector_get(&room->value.vector, (size_t)k));
    if (vectors)
        gsl_vectors(*modes, tree, loads, &room->vector.matrix, room->work.d, (int *)room->work.sd);
out:
    if (status) pend_modes_free(modes);
    free(room);
    return status;
}
