#include "core/tree/presets.h"

#include <assert.h>
#include <math.h>
#include <string.h>

/* A row of the table of presets. NULL lists have defaults: parent, a chain; length and mass, all 1;
 * phi and theta, all arms at the angle `all`; rate, at rest. theta is measured from hanging, phi
 * from the positive real axis. */
struct shape {
    const char *name, *title, *description;
    int n;
    const int *parent;
    const double *length, *mass;
    const double *phi, *theta;
    double all; /* phi */
    const double *rate;
    double stop, step;
};

#define INTS (const int[])
#define REALS (const double[])

static const struct shape shape_table[] = {
    {.name = "paper-four-arms",
     .title = "The paper's four-arm pendulum",
     .description =
         "The example of the paper: two arms share the second joint. Released at rest from the "
         "horizontal; its compression forces are plotted over these 5 seconds.",
     .n = 4,
     .parent = INTS{-1, 0, 1, 1},
     .length = REALS{2, 1.5, 0.75, 1.25},
     .mass = REALS{1, 1, 1, 0.1},
     .stop = 5,
     .step = 0.01},
    {.name = "single",
     .title = "Single pendulum",
     .description = "One arm, let go 5 degrees from upright: it lingers at the top and its period "
                    "is far longer than "
                    "2 pi sqrt(l/g).",
     .n = 1,
     .all = 1.4835298641951802,
     .stop = 12,
     .step = 0.02},
    {.name = "double",
     .title = "Double pendulum",
     .description = "Two equal arms, small swing. The start mixes the two modes, whose frequencies "
                    "are sqrt(g/l) times "
                    "sqrt(2 - sqrt 2) and sqrt(2 + sqrt 2).",
     .n = 2,
     .theta = REALS{0.2, 0},
     .stop = 20,
     .step = 0.02},
    {.name = "triple",
     .title = "Triple pendulum",
     .description = "The standard triple: three equal arms, one below the other, released from the "
                    "horizontal.",
     .n = 3,
     .stop = 10,
     .step = 0.01},
    {.name = "non-standard-triple",
     .title = "Non-standard triple pendulum",
     .description = "The paper's other triple: two arms share the tip of the first. In one of its "
                    "modes, (0, 1, -1), the "
                    "first arm does not move at all; this start is near it.",
     .n = 3,
     .parent = INTS{-1, 0, 0},
     .theta = REALS{0.05, 0.7, -0.6},
     .stop = 10,
     .step = 0.01},
    {.name = "chain-10",
     .title = "Chain of ten",
     .description = "Ten equal arms, straight and horizontal at rest. The pull of the falling "
                    "chain runs out to its end, "
                    "which snaps through.",
     .n = 10,
     .length = REALS{0.2, 0.2, 0.2, 0.2, 0.2, 0.2, 0.2, 0.2, 0.2, 0.2},
     .mass = REALS{0.1, 0.1, 0.1, 0.1, 0.1, 0.1, 0.1, 0.1, 0.1, 0.1},
     .stop = 8,
     .step = 0.01},
    {.name = "star",
     .title = "Star of eight",
     .description = "Eight arms around the tip of one, evenly spread like spokes and let go: "
                    "forces between them pass "
                    "through the hub alone.",
     .n = 9,
     .parent = INTS{-1, 0, 0, 0, 0, 0, 0, 0, 0},
     .length = REALS{1, 0.6, 0.6, 0.6, 0.6, 0.6, 0.6, 0.6, 0.6},
     .mass = REALS{1, 0.2, 0.2, 0.2, 0.2, 0.2, 0.2, 0.2, 0.2},
     .theta =
         REALS{0.4, 0.39269908169872414, 1.1780972450961724, 1.9634954084936207, 2.748893571891069,
               -2.748893571891069, -1.9634954084936207, -1.1780972450961724, -0.39269908169872414},
     .stop = 10,
     .step = 0.01},
    {.name = "binary-4",
     .title = "Binary tree of depth 4",
     .description = "Every arm carries two shorter and lighter ones, four levels deep. It starts "
                    "spread out like a tree "
                    "in winter, upside down.",
     .n = 15,
     .parent = INTS{-1, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 5, 5, 6, 6},
     .length = REALS{1, 0.8, 0.8, 0.6, 0.6, 0.6, 0.6, 0.4, 0.4, 0.4, 0.4, 0.4, 0.4, 0.4, 0.4},
     .mass = REALS{1, 0.5, 0.5, 0.25, 0.25, 0.25, 0.25, 0.125, 0.125, 0.125, 0.125, 0.125, 0.125,
                   0.125, 0.125},
     .theta =
         REALS{0.3, -0.6, 0.9, -1.1, -0.3, 0.4, 1.3, -1.5, -0.9, -0.6, 0.1, 0.2, 0.8, 1.0, 1.7},
     .stop = 10,
     .step = 0.01},
    {.name = "chaotic-double",
     .title = "Chaotic double pendulum",
     .description = "Two equal arms let go from above the horizontal, where two starts that differ "
                    "by a hair part within "
                    "seconds: no computation of this motion stays right for long.",
     .n = 2,
     .phi = REALS{0.5235987755982988, 1.0471975511965976},
     .stop = 20,
     .step = 0.01},
    {.name = "two-to-one",
     .title = "Lissajous pendulum",
     .description = "Masses of 0.64 and 0.36 make the two frequencies of a small swing exactly 1 : "
                    "2, so that the tips "
                    "come back after each period of the slow mode.",
     .n = 2,
     .mass = REALS{0.64, 0.36},
     .theta = REALS{0.1, 0.02},
     .stop = 20,
     .step = 0.02},
    {.name = "whip",
     .title = "Whip",
     .description = "Sixteen arms whose masses taper to a thousandth. A flick of the heavy end "
                    "runs outwards and the "
                    "light tip overtakes it many times over.",
     .n = 16,
     .length = REALS{0.3, 0.12, 0.12, 0.12, 0.12, 0.12, 0.12, 0.12, 0.12, 0.12, 0.12, 0.12, 0.12,
                     0.12, 0.12, 0.12},
     .mass = REALS{1, 0.63, 0.4, 0.25, 0.16, 0.1, 0.063, 0.04, 0.025, 0.016, 0.01, 0.0063, 0.004,
                   0.0025, 0.0016, 0.001},
     .theta = REALS{0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0},
     .rate = REALS{12, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0},
     .stop = 4,
     .step = 0.005},
    {.name = "thor",
     .title = "Thor",
     .description = "A Y: a light trunk with two heavy arms that whirl in opposite senses and "
                    "throw the joint between "
                    "them about.",
     .n = 3,
     .parent = INTS{-1, 0, 0},
     .length = REALS{1, 0.8, 0.8},
     .mass = REALS{0.1, 1, 1},
     .theta = REALS{0, 2.0943951023931953, -2.0943951023931953},
     .rate = REALS{0, 6, -5},
     .stop = 12,
     .step = 0.01},
    {.name = "octopus",
     .title = "Octopus",
     .description = "Four tentacles of four arms each, on a heavy head, spread wide and let go.",
     .n = 17,
     .parent = INTS{-1, 0, 1, 2, 3, 0, 5, 6, 7, 0, 9, 10, 11, 0, 13, 14, 15},
     .length = REALS{0.8, 0.4, 0.35, 0.3, 0.25, 0.4, 0.35, 0.3, 0.25, 0.4, 0.35, 0.3, 0.25, 0.4,
                     0.35, 0.3, 0.25},
     .mass = REALS{3, 0.3, 0.25, 0.2, 0.15, 0.3, 0.25, 0.2, 0.15, 0.3, 0.25, 0.2, 0.15, 0.3, 0.25,
                   0.2, 0.15},
     .theta = REALS{0.6, -1.9, -1.7, -1.5, -1.3, -0.7, -0.8, -1.0, -1.2, 0.7, 0.8, 1.0, 1.2, 1.9,
                    1.7, 1.5, 1.3},
     .stop = 10,
     .step = 0.01},
    {.name = "mobile",
     .title = "Mobile",
     .description = "Arms of very different length and weight on two joints, as in a mobile from "
                    "which the beams were "
                    "taken: a slow heavy swing with fast light ones on top.",
     .n = 7,
     .parent = INTS{-1, 0, 0, 0, 2, 2, 2},
     .length = REALS{0.5, 1.2, 0.7, 0.3, 0.9, 0.45, 0.2},
     .mass = REALS{0.2, 2, 0.1, 0.5, 1, 0.3, 0.05},
     .theta = REALS{0.2, -0.5, 0.8, -1.4, 0.3, 1.1, -2},
     .stop = 12,
     .step = 0.01},
};

enum { SHAPE_COUNT = sizeof shape_table / sizeof *shape_table };

int pend_preset_count(void) { return SHAPE_COUNT; }

static double shape_phi(const struct shape *shape, int k) {
    if (shape->phi) return shape->phi[k];
    return shape->theta ? shape->theta[k] - M_PI_2 : shape->all;
}

void pend_preset_get(int i, struct pend_preset *preset) {
    assert(i >= 0 && i < SHAPE_COUNT);
    const struct shape *shape = &shape_table[i];
    assert(shape->n >= 1 && shape->n <= PEND_PRESET_ARMS);
    *preset = (struct pend_preset){.name = shape->name,
                                   .title = shape->title,
                                   .description = shape->description,
                                   .n = shape->n,
                                   .loads.gravity = 9.81,
                                   .stop = shape->stop,
                                   .step = shape->step};
    for (int k = 0; k < shape->n; k++) {
        preset->parent[k] = shape->parent ? shape->parent[k] : k - 1;
        preset->length[k] = shape->length ? shape->length[k] : 1;
        preset->mass[k] = shape->mass ? shape->mass[k] : 1;
        preset->phi[k] = shape_phi(shape, k);
        preset->rate[k] = shape->rate ? shape->rate[k] : 0;
    }
}

int pend_preset_find(const char *name) {
    for (int i = 0; i < SHAPE_COUNT; i++)
        if (!strcmp(shape_table[i].name, name)) return i;
    return -1;
}
