#include "core/modes/response.h"

#include <assert.h>
#include <complex.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/modes/kernel_response.h"
#include "core/modes/rest.h"

/* the largest ratio of the solution to the motion of each arm by itself under its drive; beyond it,
 * rounding errors determine how far the frequency is from a mode */
static const double moved_most = 0x1p44;

struct pend_response {
    const struct pend_tree *tree;
    struct pend_loads loads;
    struct linear_arms arms;
    struct response_node *node;
    int stable;
    double *phi;
    double complex *turn;       /* n, the start of 5 n numbers: e^{i phi} */
    double complex *joint_rest; /* n: the force at the joint at rest, N */
    double complex *tip_rest;   /* n: the force at the tip at rest, N */
    double complex (*tip)[2];   /* n: the amplitude of the force at the tip for one frequency, N */
};

static enum pend_status response_fill(struct pend_response *response, struct pend_error *error) {
    const struct pend_tree *tree = response->tree;
    const struct pend_loads *loads = &response->loads;
    double pull[2];
    PEND_TRY(pend_rest_find(tree, loads, response->phi, &response->stable, error));
    if (pend_linear_arms_init(&response->arms, tree, loads, response->phi) != PEND_OK)
        return pend_fail(error, PEND_NO_MEMORY, -1, 0, "no memory for a response of %d arms",
                         tree->n);
    pend_rest_pull(loads, pull);
    double complex both = pull[0] + I * pull[1];
    for (int k = 0; k < tree->n; k++) {
        int p = tree->parent[k], hung = loads->terms && loads->terms->hung[k];
        response->turn[k] = !k && pend_terms_cart(loads->terms) ? 1 : cexp(I * response->phi[k]);
        response->tip_rest[k] = both * tree->mass[k];
        response->joint_rest[k] = both * response->arms.arm[k].whole_mass;
        if (p >= 0 && !hung) response->tip_rest[p] += response->joint_rest[k];
    }
    return PEND_OK;
}

PEND_VALIDATOR response_valid(const struct pend_response *response) {
    return response && response->node && response->arms.n == response->tree->n &&
           response->arms.arm[0].parent < 0;
}

enum pend_status pend_response_new(struct pend_response **response, const struct pend_tree *tree,
                                   const struct pend_loads *loads, const double phi[],
                                   struct pend_error *error) {
    assert(pend_tree_valid(tree));
    size_t n = (size_t)tree->n;
    struct pend_response *made = calloc(1, sizeof *made + n * sizeof(double));
    double complex *turn = malloc(5 * n * sizeof *turn);
    struct response_node *node = aligned_alloc(64, n * sizeof *node);
    *response = made;
    if (made)
        *made = (struct pend_response){
            .tree = tree, .loads = *loads, .node = node, .turn = turn, .phi = (double *)(made + 1)};
    enum pend_status status = PEND_OK;
    if (!made || !turn || !node)
        status = pend_fail(error, PEND_NO_MEMORY, -1, 0, "no memory for a response of %zu arms", n);
    if (status == PEND_OK) {
        made->joint_rest = turn + n, made->tip_rest = turn + 2 * n;
        made->tip = (double complex(*)[2])(turn + 3 * n);
        memcpy(made->phi, phi, n * sizeof *phi);
        status = response_fill(made, error);
    }
    assert(status != PEND_OK || response_valid(made));
    if (status == PEND_OK) return PEND_OK;
    if (made) pend_linear_arms_clear(&made->arms);
    free(turn);
    free(node);
    free(made);
    *response = NULL;
    return status;
}

void pend_response_free(struct pend_response **response) {
    if (!*response) return;
    pend_linear_arms_clear(&(*response)->arms);
    free((*response)->turn);
    free((*response)->node);
    free(*response);
    *response = NULL;
}

const double *pend_response_rest(const struct pend_response *response) {
    assert(response_valid(response));
    return response->phi;
}

int pend_response_stable(const struct pend_response *response) {
    assert(response_valid(response));
    return response->stable;
}

/* ---- one frequency */

static double complex response_of(const struct response_lanes *from, int lane) {
    return from->re[lane] + I * from->im[lane];
}

/* the component of a force along a direction fixed to the arm, which has turned by `angle` */
static double complex response_along(double complex way, const double complex force[2],
                                     double complex angle, double complex rest) {
    double complex swing = I * way;
    return creal(way) * force[0] + cimag(way) * force[1] +
           angle * (creal(swing) * creal(rest) + cimag(swing) * cimag(rest));
}

/* computes the forces that the tips exert on their masses and arms, in the fixed frame */
static void response_tips(const struct pend_response *response, double omega, int lane) {
    assert(lane >= 0 && lane < RESPONSE_LANES);
    const unsigned char *hung = response->loads.terms ? response->loads.terms->hung : NULL;
    double complex(*tip)[2] = response->tip;
    memset(tip, 0, (size_t)response->tree->n * sizeof *tip);
    for (int k = 0; k < response->tree->n; k++) {
        const struct linear_arm *arm = response->arms.arm + k;
        const struct response_node *node = response->node + k;
        double complex shift = -omega * omega + 2 * I * omega * response->arms.drag_per_mass;
        double complex weight = shift * response->tree->mass[k] + I * omega * arm->drag;
        double complex angle = response_of(&node->angle, lane);
        for (int i = 0; i < 2; i++)
            tip[k][i] += weight * (response_of(&node->base[i], lane) + arm->lever[i] * angle);
        if (arm->parent < 0 || (hung && hung[k])) continue;
        for (int i = 0; i < 2; i++) tip[arm->parent][i] += response_of(&node->force[i], lane);
    }
}

static void response_parts(const struct pend_response *response, int k, int lane,
                           double complex out[PEND_RESPONSE_PARTS]) {
    const struct linear_arm *arm = response->arms.arm + k;
    const struct response_node *node = response->node + k;
    double complex angle = response_of(&node->angle, lane), turn = response->turn[k];
    double complex force[2] = {response_of(&node->force[0], lane),
                               response_of(&node->force[1], lane)};
    double complex joint = response->joint_rest[k], tip = response->tip_rest[k];
    out[PEND_RESPONSE_ANGLE] = angle;
    out[PEND_RESPONSE_X] = response_of(&node->base[0], lane) + arm->lever[0] * angle;
    out[PEND_RESPONSE_Y] = response_of(&node->base[1], lane) + arm->lever[1] * angle;
    out[PEND_RESPONSE_JOINT_ALONG] = response_along(turn, force, angle, joint);
    out[PEND_RESPONSE_JOINT_ACROSS] = response_along(I * turn, force, angle, joint);
    out[PEND_RESPONSE_TIP_ALONG] = response_along(turn, response->tip[k], angle, tip);
    out[PEND_RESPONSE_TIP_ACROSS] = response_along(I * turn, response->tip[k], angle, tip);
}

/* stores the results of one frequency; returns 0, and stores zeros, if they are undefined */
static int response_give(struct pend_response *response, const struct response_sweep *sweep,
                         int lane, double *const re[], double *const im[]) {
    size_t n = (size_t)response->tree->n, row = (size_t)lane * n;
    double complex out[PEND_RESPONSE_PARTS];
    int defined = sweep->moved[lane] <= moved_most * moved_most * sweep->driven[lane], finite = 1;
    if (defined) response_tips(response, sweep->omega[lane], lane);
    for (size_t k = 0; k < n; k++) {
        memset(out, 0, sizeof out);
        if (defined) response_parts(response, (int)k, lane, out);
        for (int i = 0; i < PEND_RESPONSE_PARTS; i++) {
            if (!re[i]) continue;
            re[i][row + k] = creal(out[i]);
            im[i][row + k] = cimag(out[i]);
            finite &= isfinite(creal(out[i])) && isfinite(cimag(out[i]));
        }
    }
    for (int i = 0; i < PEND_RESPONSE_PARTS && !finite; i++) {
        if (!re[i]) continue;
        memset(re[i] + row, 0, n * sizeof **re);
        memset(im[i] + row, 0, n * sizeof **im);
    }
    return defined && finite;
}

void pend_response_at(struct pend_response *response, int count, const double omega[],
                      const struct pend_response_drive *drive,
                      double *const re[PEND_RESPONSE_PARTS], double *const im[PEND_RESPONSE_PARTS],
                      unsigned char defined[]) {
    struct response_sweep sweep = {0};
    assert(response_valid(response) && count >= 1 && count <= RESPONSE_LANES);
    for (int lane = 0; lane < RESPONSE_LANES; lane++) {
        sweep.omega[lane] = omega[lane < count ? lane : 0];
        for (int i = 0; i < 2; i++) {
            sweep.pivot[i].re[lane] = drive->pivot_re[i];
            sweep.pivot[i].im[lane] = drive->pivot_im[i];
        }
    }
    for (int k = 0; k < response->tree->n; k++)
        response->node[k].drive = (struct response_lanes){0};
    for (int k = 0; k < response->tree->n && drive->couple_re; k++) {
        int p = response->arms.arm[k].holder;
        for (int lane = 0; lane < RESPONSE_LANES; lane++) {
            response->node[k].drive.re[lane] += drive->couple_re[k];
            response->node[k].drive.im[lane] += drive->couple_im[k];
            if (p < 0) continue;
            response->node[p].drive.re[lane] -= drive->couple_re[k];
            response->node[p].drive.im[lane] -= drive->couple_im[k];
        }
    }
    PEND_ISA_PICK(pend_response, pend_isa_best())(&response->arms, &sweep, response->node);
    for (int lane = 0; lane < count; lane++)
        defined[lane] = (unsigned char)response_give(response, &sweep, lane, re, im);
}

double pend_response_bytes(int n) {
    return (double)n * (sizeof(struct response_node) + sizeof(struct linear_arm) +
                        5 * sizeof(double complex) + 3 * sizeof(struct rest_body)) +
           4096;
}
