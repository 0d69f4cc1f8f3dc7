#include "core/modes/response.h"

#include <assert.h>
#include <complex.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/modes/kernel_response.h"
#include "core/modes/rest.h"

/* the most that angles may be in parts of what the drives would turn each arm by alone: beyond, it
 * is rounding errors that tell how far the frequency is from that of a mode */
static const double moved_most = 0x1p44;

struct pend_response {
    const struct pend_tree *tree;
    struct pend_loads loads;
    struct response_arms arms;
    struct response_node *node;
    int stable;
    double *phi;
    double complex *turn;       /* n, the first of 5 n: e^{i phi} */
    double complex *joint_rest; /* n: the force at the joint at rest, N */
    double complex *tip_rest;   /* n: the same at the tip */
    double complex (*tip)[2];   /* n: of a lane, N */
};

static double response_get(const struct pend_loads *loads, enum pend_term_row row, int k) {
    return loads->terms ? pend_terms_get(loads->terms, loads->value, row, k) : 0;
}

/* arm k is a cart: its tip stands for the point whose move by a unit of its place is the rail's
 * direction */
static int response_cart(const struct pend_response *response, int k) {
    return !k && pend_terms_cart(response->loads.terms);
}

/* i times a vector of the arm's frame, turned */
static void response_lever(double complex turn, const double from[2], double to[2]) {
    double complex lever = I * turn * (from[0] + I * from[1]);
    to[0] = creal(lever);
    to[1] = cimag(lever);
}

/* the constants of an arm alone */
static void response_arm(const struct pend_response *response, int k, struct response_arm *arm) {
    const struct pend_loads *loads = &response->loads;
    struct rest_body body = pend_rest_arm(response->tree, loads, k);
    struct rest_body drag = pend_rest_drag(response->tree, loads, k);
    double complex turn = response->turn[k];
    double tip[2] = {response->tree->len[k], 0}, point[2] = {0, 0};
    if (response_cart(response, k))
        tip[0] = body.moment[0] / body.mass, tip[1] = body.moment[1] / body.mass;
    *arm =
        (struct response_arm){.parent = response->tree->parent[k],
                              .holder = pend_terms_holder(loads->terms, response->tree->parent, k),
                              .mass = body.mass,
                              .inertia = body.inertia,
                              .drag = drag.mass,
                              .span = response->tree->len[k] * response->tree->len[k],
                              .spring = response_get(loads, PEND_TERM_STIFFNESS, k),
                              .damper = pend_rest_damper(loads, k)};
    response_lever(turn, body.moment, arm->moment);
    response_lever(turn, tip, arm->lever);
    if (k == 0) return;
    pend_rest_point(response->tree, loads, k, point);
    response_lever(response->turn[arm->parent], point, arm->place);
}

/* what depends on all that hangs on an arm: its moments, and the forces at rest */
static void response_wholes(struct pend_response *response, struct response_arm arm[],
                            struct rest_body mass[], struct rest_body drag[]) {
    const struct pend_loads *loads = &response->loads;
    double pull[2];
    pend_rest_pull(loads, pull);
    double complex both = pull[0] + I * pull[1];
    for (int k = 0; k < response->tree->n; k++) {
        mass[k] = pend_rest_arm(response->tree, loads, k);
        drag[k] = pend_rest_drag(response->tree, loads, k);
        response->tip_rest[k] = both * response->tree->mass[k];
    }
    pend_rest_gather(response->tree, loads, mass);
    pend_rest_gather(response->tree, loads, drag);
    for (int k = 0; k < response->tree->n; k++) {
        int p = response->tree->parent[k], hung = loads->terms && loads->terms->hung[k];
        double complex moment = mass[k].moment[0] + I * mass[k].moment[1];
        // a cart's frame does not turn
        if (!response_cart(response, k))
            arm[k].fall = -creal(conj(both) * moment * response->turn[k]);
        response_lever(response->turn[k], mass[k].moment, arm[k].whole);
        response_lever(response->turn[k], drag[k].moment, arm[k].wind);
        response->joint_rest[k] = both * mass[k].mass;
        if (p >= 0 && !hung) response->tip_rest[p] += response->joint_rest[k];
    }
}

static enum pend_status response_fill(struct pend_response *response, struct response_arm arm[],
                                      struct pend_error *error) {
    size_t n = (size_t)response->tree->n;
    PEND_TRY(
        pend_rest_find(response->tree, &response->loads, response->phi, &response->stable, error));
    struct rest_body *body = malloc(2 * n * sizeof *body);
    if (!body)
        return pend_fail(error, PEND_NO_MEMORY, -1, 0, "no memory for a response of %zu arms", n);
    for (size_t k = 0; k < n; k++)
        response->turn[k] = response_cart(response, (int)k) ? 1 : cexp(I * response->phi[k]);
    for (size_t k = 0; k < n; k++) response_arm(response, (int)k, arm + k);
    response_wholes(response, arm, body, body + n);
    free(body);
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
    struct response_arm *arm = malloc(n * sizeof *arm);
    struct pend_response *made = calloc(1, sizeof *made + n * sizeof(double));
    double complex *turn = malloc(5 * n * sizeof *turn);
    struct response_node *node = aligned_alloc(64, n * sizeof *node);
    *response = made;
    if (made)
        *made = (struct pend_response){
            .tree = tree, .loads = *loads, .node = node, .turn = turn, .phi = (double *)(made + 1)};
    if (made) made->arms = (struct response_arms){.n = tree->n, .arm = arm};
    enum pend_status status = PEND_OK;
    if (!arm || !made || !turn || !node)
        status = pend_fail(error, PEND_NO_MEMORY, -1, 0, "no memory for a response of %zu arms", n);
    if (status == PEND_OK) {
        made->joint_rest = turn + n, made->tip_rest = turn + 2 * n;
        made->tip = (double complex(*)[2])(turn + 3 * n);
        memcpy(made->phi, phi, n * sizeof *phi);
        int mist = loads->terms ? loads->terms->one[PEND_TERM_DRAG_PER_MASS] : -1;
        made->arms.mist = mist < 0 ? 0 : loads->value[mist];
        status = response_fill(made, arm, error);
    }
    assert(status != PEND_OK || response_valid(made));
    if (status == PEND_OK) return PEND_OK;
    free(arm);
    free(turn);
    free(node);
    free(made);
    *response = NULL;
    return status;
}

void pend_response_free(struct pend_response **response) {
    if (!*response) return;
    free((void *)(*response)->arms.arm);
    free((*response)->turn);
    free((*response)->node);
    free(*response);
    *response = NULL;
}

const double *pend_response_rest(const struct pend_response *response) {
    assert(response_valid(response));
    return response->phi;
}

const struct response_arms *pend_response_arms(const struct pend_response *response) {
    assert(response_valid(response));
    return &response->arms;
}

int pend_response_stable(const struct pend_response *response) {
    assert(response_valid(response));
    return response->stable;
}

/* ---- a frequency */

static double complex response_of(const struct response_lanes *from, int lane) {
    return from->re[lane] + I * from->im[lane];
}

/* the part of a force along a direction of the arm, which has turned by `angle` */
static double complex response_along(double complex way, const double complex force[2],
                                     double complex angle, double complex rest) {
    double complex swing = I * way;
    return creal(way) * force[0] + cimag(way) * force[1] +
           angle * (creal(swing) * creal(rest) + cimag(swing) * cimag(rest));
}

/* forces of the tips on what is there, in the fixed frame */
static void response_tips(const struct pend_response *response, double omega, int lane) {
    assert(lane >= 0 && lane < RESPONSE_LANES);
    const unsigned char *hung = response->loads.terms ? response->loads.terms->hung : NULL;
    double complex(*tip)[2] = response->tip;
    memset(tip, 0, (size_t)response->tree->n * sizeof *tip);
    for (int k = 0; k < response->tree->n; k++) {
        const struct response_arm *arm = response->arms.arm + k;
        const struct response_node *node = response->node + k;
        double complex shift = -omega * omega + 2 * I * omega * response->arms.mist;
        double complex weight = shift * response->tree->mass[k] + I * omega * arm->drag;
        double complex angle = response_of(&node->angle, lane);
        for (int i = 0; i < 2; i++)
            tip[k][i] += weight * (response_of(&node->base[i], lane) + arm->lever[i] * angle);
        if (arm->parent < 0 || (hung && hung[k])) continue;
        for (int i = 0; i < 2; i++) tip[arm->parent][i] += response_of(&node->force[i], lane);
    }
}

/* all parts of an arm */
static void response_parts(const struct pend_response *response, int k, int lane,
                           double complex out[PEND_RESPONSE_PARTS]) {
    const struct response_arm *arm = response->arms.arm + k;
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

/* hands out a lane; returns 0, and zeros, if it is not defined */
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
    return (double)n * (sizeof(struct response_node) + sizeof(struct response_arm) +
                        5 * sizeof(double complex) + 3 * sizeof(struct rest_body)) +
           4096;
}
