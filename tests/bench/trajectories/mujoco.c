/* Pendulums of rods integrated by MuJoCo: Runge-Kutta steps of order 4, whose length follows from
 * the tolerance.
 * Leaves to others: other peers (peers), tolerances and clocks (bench_trajectories).
 * Invariant: only smooth dynamics is enabled, and every instant is the end of a step. */
#include <dlfcn.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/bench/trajectories/peers.h"

#if __has_include(<mujoco/mujoco.h>)
#include <mujoco/mujoco.h>

/* functions of libmujoco, which is opened at run time, with the types of its header */
#define MUJOCO_CALLS(X)                                                                            \
    X(mj_defaultVFS)                                                                               \
    X(mj_makeEmptyFileVFS)                                                                         \
    X(mj_loadXML) X(mj_makeData) X(mj_step) X(mj_deleteData) X(mj_deleteModel)
static struct {
#define MUJOCO_MEMBER(name) __typeof__(&name) name;
    MUJOCO_CALLS(MUJOCO_MEMBER)
} mujoco;

static int mujoco_open(void) {
    static int there = -1;
    if (there >= 0) return there;
    void *library = dlopen("libmujoco.so", RTLD_NOW);
    there = library != NULL;
#define MUJOCO_SYMBOL(name)                                                                        \
    mujoco.name = library ? (__typeof__(&name))dlsym(library, #name) : NULL;                       \
    if (!mujoco.name) there = 0;
    MUJOCO_CALLS(MUJOCO_SYMBOL)
    return there;
}

/* the tree as a MuJoCo model: a hinge at the base of every arm, with its friction and its
 * spring, and a uniform rod */
static char *mujoco_text(const struct problem *problem, size_t *bytes) {
    const struct pend_tree *t = problem->tree;
    const struct pend_terms *terms = problem->loads.terms;
    const double *value = problem->loads.value;
    size_t room = 600 * (size_t)t->n + 1000, at = 0;
    char *text = malloc(room);
    int open[PROBLEM_ARMS_MAX], depth = 0;
    if (!text) return NULL;
#define SAY(...) at += (size_t)snprintf(text + at, room - at, __VA_ARGS__)
    SAY("<mujoco><compiler angle=\"radian\"/><option integrator=\"RK4\" gravity=\"0 %.17g 0\">"
        "<flag constraint=\"disable\" contact=\"disable\" equality=\"disable\" "
        "frictionloss=\"disable\" limit=\"disable\" actuation=\"disable\"/></option><worldbody>",
        -problem->loads.gravity);
    for (int k = 0; k < t->n; k++) {
        double l = t->len[k], rod = pend_terms_get(terms, value, PEND_TERM_ROD, k);
        double inertia = rod * l * l / 12;
        while (depth && open[depth - 1] != t->parent[k]) SAY("</body>"), depth--;
        SAY("<body pos=\"%.17g 0 0\"><joint type=\"hinge\" axis=\"0 0 1\" damping=\"%.17g\" "
            "stiffness=\"%.17g\" springref=\"%.17g\"/><inertial pos=\"%.17g 0 0\" mass=\"%.17g\" "
            "diaginertia=\"%.17g %.17g %.17g\"/>",
            k ? t->len[t->parent[k]] : 0.0, pend_terms_get(terms, value, PEND_TERM_DAMPING, k),
            pend_terms_get(terms, value, PEND_TERM_STIFFNESS, k),
            pend_terms_get(terms, value, PEND_TERM_REST, k) - (k ? 0 : M_PI_2), l / 2, rod, inertia,
            inertia, inertia);
        open[depth++] = k;
    }
    while (depth--) SAY("</body>");
    SAY("</worldbody></mujoco>\n");
#undef SAY
    *bytes = at;
    return text;
}

static mjModel *mujoco_load(const struct problem *problem) {
    char error[500] = "";
    size_t bytes;
    char *text = mujoco_text(problem, &bytes);
    mjVFS *files = malloc(sizeof *files);
    mjModel *model = NULL;
    if (text && files) {
        mujoco.mj_defaultVFS(files);
        mujoco.mj_makeEmptyFileVFS(files, "tree.xml", (int)bytes);
        memcpy(files->filedata[0], text, bytes);
        model = mujoco.mj_loadXML("tree.xml", files, error, sizeof error);
        if (!model) fprintf(stderr, "MuJoCo refuses the tree: %s\n", error);
        free(files->filedata[0]);
    }
    free(files);
    free(text);
    return model;
}

/* the angles, from the joints' */
static void mujoco_row(const struct problem *problem, const mjData *data, double phi[]) {
    for (int k = 0; k < problem->tree->n; k++)
        phi[k] = data->qpos[k] + (k ? phi[problem->tree->parent[k]] : 0);
}

int peer_mujoco(const struct problem *problem, double tolerance, double phi[]) {
    const int *parent = problem->tree->parent;
    size_t n = (size_t)problem->tree->n;
    // with order 4 the last digits would take minutes
    if (problem->error < 1e-8 || !problem->loads.terms || !mujoco_open()) return 1;
    mjModel *model = mujoco_load(problem);
    mjData *data = model ? mujoco.mj_makeData(model) : NULL;
    int failed = !data;
    if (data) {
        // the error of order 4
        double span = problem_time(problem, 1), parts = ceil(span / (0.3 * pow(tolerance, 0.25)));
        model->opt.timestep = span / parts;
        for (size_t k = 0; k < n; k++) {
            data->qpos[k] = problem->phi[k] - (k ? problem->phi[parent[k]] : 0);
            data->qvel[k] = problem->rate[k] - (k ? problem->rate[parent[k]] : 0);
        }
        mujoco_row(problem, data, phi);
        for (int i = 1; i < problem->count; i++) {
            for (int j = 0; j < (int)parts; j++) mujoco.mj_step(model, data);
            mujoco_row(problem, data, phi + (size_t)i * n);
        }
        mujoco.mj_deleteData(data);
    }
    if (model) mujoco.mj_deleteModel(model);
    return failed;
}

int peer_mujoco_there(void) { return mujoco_open(); }
#else
int peer_mujoco(const struct problem *problem, double tolerance, double phi[]) {
    (void)problem, (void)tolerance, (void)phi;
    return 1;
}

int peer_mujoco_there(void) { return 0; }
#endif
