#include "core/modes_kernel.h"

#include <math.h>

#include "core/lanes.h"

/* compiled once for every instruction set: see the Makefile */
#if defined(__AVX512F__)
enum { WIDTH = 8 };
typedef lanes8 lanes;
#define kernel_fma lanes8_fma
#define kernel_all lanes8_of
#elif defined(__AVX2__)
enum { WIDTH = 4 };
typedef lanes4 lanes;
#define kernel_fma lanes4_fma
#define kernel_all lanes4_of
#else
enum { WIDTH = 2 };
typedef lanes2 lanes;
#define kernel_fma lanes2_fma
#define kernel_all lanes2_of
#endif

/* several vectors of shifts side by side keep the processor busy where the tree is a chain */
enum { PAIR = 4, GROUP = PAIR * WIDTH };

typedef long long masks __attribute__((vector_size(WIDTH * sizeof(double))));
typedef unsigned long long sign_bits __attribute__((vector_size(WIDTH * sizeof(double))));

#define KERNEL_PASTE(isa) pend_modes_kernel_for_##isa
#define KERNEL_NAME(isa) KERNEL_PASTE(isa)
#define INLINE static inline __attribute__((always_inline))

/* Added to each pivot in parts of its spring: far below round-off, yet no pivot vanishes, and sums over pivots that
 * nearly do keep their digits. */
#define KERNEL_TINY 0x1p-57

INLINE lanes kernel_pick(masks where, lanes yes, lanes no) {
    return (lanes)((where & (masks)yes) | (~where & (masks)no));
}

/* a sub-tree seen from its parent: c t / (t + c) and its first and second derivative in the shift */
struct pulls {
    lanes value[PAIR], rate[PAIR], bend[PAIR];
};

struct tally {
    lanes minus_shift[PAIR], log_rate[PAIR], log_bend[PAIR];
    sign_bits below[PAIR];
};

/* what the children pull becomes what the node itself pulls */
INLINE void probe_node(struct tally *tally, struct pulls *pulls, double spring, double mass) {
    double tiny = spring * KERNEL_TINY;
    for (int i = 0; i < PAIR; i++) {
        lanes t = kernel_fma(tally->minus_shift[i], kernel_all(mass), pulls->value[i]);
        lanes inverse = 1.0 / ((t + spring) + tiny), slope = (pulls->rate[i] - mass) * inverse;
        lanes square = slope * slope, bend = kernel_fma(pulls->bend[i], inverse, -square);
        tally->below[i] += (sign_bits)inverse >> 63;
        tally->log_rate[i] += slope;
        tally->log_bend[i] -= bend;
        inverse *= spring;
        pulls->value[i] = inverse * t;
        inverse *= spring;
        pulls->rate[i] = inverse * slope;
        pulls->bend[i] = inverse * (bend - square);
    }
}

INLINE void pulls_add(struct pulls *sum, const struct pulls *more) {
    for (int i = 0; i < PAIR; i++) {
        sum->value[i] += more->value[i];
        sum->rate[i] += more->rate[i];
        sum->bend[i] += more->bend[i];
    }
}

static void probe_group(const struct pend_laplacian *laplacian, struct tally *result) {
    const double *spring = laplacian->spring, *mass = laplacian->mass;
    const unsigned char *turn = laplacian->turn;
    struct tally tally = *result;
    struct pulls stack[PEND_LAPLACIAN_STACK], pulls = {0};
    int top = 0;
    for (int k = laplacian->n - 1; k >= 0; k--) switch (turn[k]) {
        case 0: /* inside a chain, or the first sibling with arms on it */
            probe_node(&tally, &pulls, spring[k], mass[k]);
            break;
        case PEND_TURN_LEAF: /* a new branch begins; what is under way waits */
            stack[top++] = pulls;
            pulls = (struct pulls){0};
            probe_node(&tally, &pulls, spring[k], mass[k]);
            break;
        case PEND_TURN_NEXT: /* a branch ends beside siblings that wait */
            probe_node(&tally, &pulls, spring[k], mass[k]);
            pulls_add(&pulls, &stack[--top]);
            break;
        default: { /* a single arm beside siblings */
            struct pulls leaf = {0};
            probe_node(&tally, &leaf, spring[k], mass[k]);
            pulls_add(&pulls, &leaf);
        }
        }
    *result = tally;
}

static void kernel_probe(const struct pend_laplacian *laplacian, int count, struct pend_modes_probe probe[]) {
    for (int begin = 0; begin < count; begin += GROUP) {
        struct tally tally = {0};
        int size = count - begin < GROUP ? count - begin : GROUP;
        for (int i = 0; i < GROUP; i++)
            tally.minus_shift[i / WIDTH][i % WIDTH] = -probe[begin + (i < size ? i : size - 1)].shift;
        probe_group(laplacian, &tally);
        for (int i = 0; i < size; i++) {
            probe[begin + i].below = (int)tally.below[i / WIDTH][i % WIDTH];
            probe[begin + i].log_rate = tally.log_rate[i / WIDTH][i % WIDTH];
            probe[begin + i].log_bend = tally.log_bend[i / WIDTH][i % WIDTH];
        }
    }
}

/* Arrays of the twisted factorization, WIDTH entries a node. */
struct twist {
    lanes *t;       /* pivot from below, without the node's own spring */
    lanes *inverse; /* 1 / (t + c) */
    lanes *above;   /* what pulls from above, c u / (u + c); the sums over earlier siblings, then the arm's y */
    lanes *tip;     /* sums over later siblings; 1 / (u + c); then x */
};

/* leaves inwards */
static void twist_up(const struct pend_laplacian *laplacian, lanes shift, struct twist w) {
    lanes stack[PEND_LAPLACIAN_STACK], pull = {0};
    int top = 0;
    for (int k = laplacian->n - 1; k >= 0; k--) {
        double spring = laplacian->spring[k];
        unsigned turn = laplacian->turn[k];
        if (turn & PEND_TURN_LEAF) {
            stack[top++] = pull;
            pull = (lanes){0};
        }
        lanes t = pull - shift * laplacian->mass[k], inverse = 1.0 / ((t + spring) + spring * KERNEL_TINY);
        w.t[k] = t;
        w.inverse[k] = inverse;
        pull = spring * (t * inverse);
        if (turn & PEND_TURN_NEXT) {
            w.tip[k] = stack[--top];
            pull += stack[top];
        }
    }
}

/* root outwards; returns the node with the smallest |gamma| / m of every lane */
static masks twist_down(const struct pend_laplacian *laplacian, lanes shift, struct twist w) {
    const int *parent = laplacian->parent, *end = laplacian->end;
    lanes least = kernel_all(INFINITY);
    masks at = {0};
    for (int k = 0; k < laplacian->n; k++) {
        double spring = laplacian->spring[k];
        if (!k) {
            w.above[0] = kernel_all(spring);
        } else {
            /* everything at the parent but this branch */
            int p = parent[k];
            lanes u = w.above[p] - shift * laplacian->mass[p], earlier = {0};
            if (k > p + 1) u += earlier = w.above[k];
            if (laplacian->turn[k] & PEND_TURN_NEXT) {
                u += w.tip[k];
                w.above[end[k]] = earlier + spring * (w.t[k] * w.inverse[k]);
            }
            lanes inverse = 1.0 / ((u + spring) + spring * KERNEL_TINY);
            w.tip[k] = inverse;
            w.above[k] = spring * (u * inverse);
        }
        lanes gamma = w.t[k] + w.above[k], size = kernel_pick(gamma < 0, -gamma, gamma) * (1 / laplacian->mass[k]);
        masks less = size < least;
        least = kernel_pick(less, size, least);
        at = (less & ((masks){0} + k)) | (~less & at);
    }
    return at;
}

/* from the twist to the pivot, one lane: x in tip, y = x - x_parent in above */
static void twist_climb(const struct pend_laplacian *laplacian, struct twist w, int k, int lane) {
    double x = 1;
    for (;; k = laplacian->parent[k]) {
        double spring = laplacian->spring[k], from = k ? x * (spring * w.tip[k][lane]) : 0;
        w.above[k][lane] = k ? x * w.above[k][lane] / spring : x;
        w.tip[k][lane] = x;
        if (!k) return;
        x = from;
    }
}

/* from the climbed ways into all other branches; returns sum m x^2 */
static lanes twist_spread(const struct pend_laplacian *laplacian, struct twist w, masks at) {
    const int *end = laplacian->end;
    lanes total = {0}, sum = {0};
    for (int k = 0; k < laplacian->n; k++) {
        lanes x = w.tip[k];
        if (k) {
            masks climbed = (at >= k) & (at < end[k]);
            lanes from = w.tip[laplacian->parent[k]], inverse = w.inverse[k];
            x = kernel_pick(climbed, x, from * (laplacian->spring[k] * inverse));
            w.above[k] = kernel_pick(climbed, w.above[k], -from * (w.t[k] * inverse));
            w.tip[k] = x;
        }
        sum += laplacian->mass[k] * (x * x);
        if (k % 256 == 255) {
            total += sum;
            sum = (lanes){0};
        }
    }
    return total + sum;
}

static void kernel_vectors(const struct pend_laplacian *laplacian, const double value[], double work[],
                           double *vector[], double *tip[]) {
    size_t n = (size_t)laplacian->n;
    lanes shift, *room = (lanes *)work;
    struct twist w = {room, room + n, room + 2 * n, room + 3 * n};
    for (int i = 0; i < WIDTH; i++) shift[i] = value[i];
    twist_up(laplacian, shift, w);
    masks at = twist_down(laplacian, shift, w);
    for (int i = 0; i < WIDTH; i++) twist_climb(laplacian, w, (int)at[i], i);
    lanes square = twist_spread(laplacian, w, at), scale;
    for (int i = 0; i < WIDTH; i++) scale[i] = 1 / sqrt(square[i]);
    for (int k = 0; k < laplacian->n; k++) {
        lanes theta = w.above[k] * (scale * (1 / laplacian->len[k]));
        for (int i = 0; i < WIDTH; i++) vector[i][k] = theta[i];
    }
    for (int k = 0; tip && k < laplacian->n; k++) {
        lanes x = w.tip[k] * scale;
        for (int i = 0; i < WIDTH; i++) tip[i][k] = x[i];
    }
}

const struct pend_modes_kernel KERNEL_NAME(PEND_ISA);
const struct pend_modes_kernel KERNEL_NAME(PEND_ISA) = {WIDTH, kernel_probe, kernel_vectors};
