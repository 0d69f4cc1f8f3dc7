#include "core/modes/modes_kernel.h"

#include <math.h>
#include <string.h>

#include "core/simd/vec_isa.h"

enum { WIDTH = KERNEL_WIDTH };
typedef KERNEL_OF(lanes, ) lanes;
#define kernel_fma KERNEL_OF(lanes, _fma)
#define kernel_all KERNEL_OF(lanes, _of)

/* several independent vectors of shifts keep the processor busy along a chain of arms */
enum { DD_TYPE = 4, GROUP = DD_TYPE * WIDTH };

typedef long long masks __attribute__((vector_size(WIDTH * sizeof(double))));
typedef unsigned long long sign_bits __attribute__((vector_size(WIDTH * sizeof(double))));

#define INLINE static inline __attribute__((always_inline))

/* A small number added to each pivot, relative to its spring. It is far below round-off, but
 * prevents a pivot from vanishing and keeps the digits of sums over small pivots. */
#define KERNEL_TINY 0x1p-57

/* Replaces each normal x by 1 / x. A division occupies the widest unit for 16 cycles, half the time
 * that a node takes. With AVX-512, an estimate of 14 bits is refined twice instead: to 42 bits,
 * then to the last digit. */
INLINE void kernel_inverses(lanes x[], int count) {
#if defined(__AVX512F__)
    __m512d one = (__m512d)kernel_all(1), estimate[DD_TYPE], rest[DD_TYPE];
    for (int i = 0; i < count; i++) estimate[i] = _mm512_rcp14_pd((__m512d)x[i]);
    for (int i = 0; i < count; i++) rest[i] = _mm512_fnmadd_pd((__m512d)x[i], estimate[i], one);
    for (int i = 0; i < count; i++) rest[i] = _mm512_fmadd_pd(rest[i], rest[i], rest[i]);
    for (int i = 0; i < count; i++)
        estimate[i] = _mm512_fmadd_pd(estimate[i], rest[i], estimate[i]);
    for (int i = 0; i < count; i++) rest[i] = _mm512_fnmadd_pd((__m512d)x[i], estimate[i], one);
    for (int i = 0; i < count; i++)
        x[i] = (lanes)_mm512_fmadd_pd(estimate[i], rest[i], estimate[i]);
#else
    for (int i = 0; i < count; i++) x[i] = 1.0 / x[i];
#endif
}

INLINE lanes kernel_inverse(lanes x) {
    kernel_inverses(&x, 1);
    return x;
}

INLINE lanes kernel_pick(masks where, lanes yes, lanes no) {
    return (lanes)((where & (masks)yes) | (~where & (masks)no));
}

/* the pull of a sub-tree on its parent, c t / (t + c), and its first and second derivative with
 * respect to the shift */
struct pulls {
    lanes value[DD_TYPE], rate[DD_TYPE], bend[DD_TYPE];
};

struct tally {
    lanes minus_shift[DD_TYPE], log_rate[DD_TYPE], log_bend[DD_TYPE];
    sign_bits below[DD_TYPE];
};

/* Computes a node's pull from its children's pulls. Each step runs over all shifts before the next,
 * because the processor looks only a hundred operations ahead, and one shift needs more for a
 * node. */
INLINE void probe_node(struct tally *tally, struct pulls *pulls, double spring, double mass,
                       int pairs) {
    double tiny = spring * KERNEL_TINY;
    lanes t[DD_TYPE], inverse[DD_TYPE], slope[DD_TYPE], square[DD_TYPE], bend[DD_TYPE];
    for (int i = 0; i < pairs; i++)
        t[i] = kernel_fma(tally->minus_shift[i], kernel_all(mass), pulls->value[i]);
    for (int i = 0; i < pairs; i++) inverse[i] = (t[i] + spring) + tiny;
    kernel_inverses(inverse, pairs);
    for (int i = 0; i < pairs; i++) slope[i] = (pulls->rate[i] - mass) * inverse[i];
    for (int i = 0; i < pairs; i++) tally->below[i] += (sign_bits)inverse[i] >> 63;
    for (int i = 0; i < pairs; i++) square[i] = slope[i] * slope[i];
    for (int i = 0; i < pairs; i++) tally->log_rate[i] += slope[i];
    for (int i = 0; i < pairs; i++) bend[i] = kernel_fma(pulls->bend[i], inverse[i], -square[i]);
    for (int i = 0; i < pairs; i++) inverse[i] *= spring;
    for (int i = 0; i < pairs; i++) pulls->value[i] = inverse[i] * t[i];
    for (int i = 0; i < pairs; i++) inverse[i] *= spring;
    for (int i = 0; i < pairs; i++) tally->log_bend[i] -= bend[i];
    for (int i = 0; i < pairs; i++) pulls->rate[i] = inverse[i] * slope[i];
    for (int i = 0; i < pairs; i++) pulls->bend[i] = inverse[i] * (bend[i] - square[i]);
}

INLINE void pulls_add(struct pulls *sum, const struct pulls *more, int pairs) {
    for (int i = 0; i < pairs; i++) {
        sum->value[i] += more->value[i];
        sum->rate[i] += more->rate[i];
        sum->bend[i] += more->bend[i];
    }
}

/* probes `pairs` vectors of shifts in one sweep */
INLINE void probe_group(const struct pend_laplacian *laplacian, struct tally *result, int pairs) {
    const double *spring = laplacian->spring, *mass = laplacian->mass;
    const unsigned char *turn = laplacian->turn;
    struct tally tally = *result;
    struct pulls stack[PEND_LAPLACIAN_STACK], pulls = {0};
    int top = 0;
    for (int k = laplacian->n - 1; k >= 0; k--) switch (turn[k]) {
        case 0: /* inside a chain, or the first sibling with children */
            probe_node(&tally, &pulls, spring[k], mass[k], pairs);
            break;
        case PEND_TURN_LEAF: /* a new branch begins; the sums over its earlier siblings go onto the
                              * stack */
            stack[top++] = pulls;
            pulls = (struct pulls){0};
            probe_node(&tally, &pulls, spring[k], mass[k], pairs);
            break;
        case PEND_TURN_NEXT: /* a branch ends; the sums over its earlier siblings are on the
                              * stack */
            probe_node(&tally, &pulls, spring[k], mass[k], pairs);
            pulls_add(&pulls, &stack[--top], pairs);
            break;
        default: { /* a leaf with siblings */
            struct pulls leaf = {0};
            probe_node(&tally, &leaf, spring[k], mass[k], pairs);
            pulls_add(&pulls, &leaf, pairs);
        }
        }
    *result = tally;
}

static void probe_four(const struct pend_laplacian *laplacian, struct tally *tally) {
    probe_group(laplacian, tally, 4);
}
static void probe_two(const struct pend_laplacian *laplacian, struct tally *tally) {
    probe_group(laplacian, tally, 2);
}
static void probe_one(const struct pend_laplacian *laplacian, struct tally *tally) {
    probe_group(laplacian, tally, 1);
}

static void kernel_probe(const struct pend_laplacian *laplacian, int count,
                         struct pend_modes_probe probe[]) {
    for (int begin = 0; begin < count; begin += GROUP) {
        struct tally tally = {0};
        int size = count - begin < GROUP ? count - begin : GROUP;
        for (int i = 0; i < GROUP; i++)
            tally.minus_shift[i / WIDTH][i % WIDTH] =
                -probe[begin + (i < size ? i : size - 1)].shift;
        if (size > 2 * WIDTH)
            probe_four(laplacian, &tally);
        else if (size > WIDTH)
            probe_two(laplacian, &tally);
        else
            probe_one(laplacian, &tally);
        for (int i = 0; i < size; i++) {
            probe[begin + i].below = (int)tally.below[i / WIDTH][i % WIDTH];
            probe[begin + i].log_rate = tally.log_rate[i / WIDTH][i % WIDTH];
            probe[begin + i].log_bend = tally.log_bend[i / WIDTH][i % WIDTH];
        }
    }
}

/* Arrays of the twisted factorization, WIDTH entries per node. Values that a division can restore
 * are not stored, because large trees are limited by memory bandwidth. */
struct twist {
    lanes *t;     /* pivot of the sweep from below, without the node's own spring */
    lanes *above; /* pull from above, c u / (u + c); before that, the sums over earlier siblings */
    lanes *tip;   /* sums over later siblings; then 1 / (u + c); then x */
};

/* the sweep from the leaves inwards */
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
        lanes t = kernel_fma(-shift, kernel_all(laplacian->mass[k]), pull);
        w.t[k] = t;
        pull = spring * (t * kernel_inverse((t + spring) + spring * KERNEL_TINY));
        if (turn & PEND_TURN_NEXT) {
            w.tip[k] = stack[--top];
            pull += stack[top];
        }
    }
}

/* the sweep from the root outwards; returns in each lane the node with the smallest |gamma| / m */
static masks twist_down(const struct pend_laplacian *laplacian, lanes shift, struct twist w) {
    const int *parent = laplacian->parent, *end = laplacian->end;
    lanes least = kernel_all(INFINITY), least_mass = kernel_all(1);
    masks at = {0};
    w.above[0] = kernel_all(laplacian->spring[0]);
    for (int k = 0; k < laplacian->n; k++) {
        double spring = laplacian->spring[k], mass = laplacian->mass[k];
        if (k) {
            /* the pull of everything on the parent except this branch */
            int p = parent[k];
            lanes u = kernel_fma(-shift, kernel_all(laplacian->mass[p]), w.above[p]), earlier = {0};
            if (k > p + 1) u += earlier = w.above[k];
            if (laplacian->turn[k] & PEND_TURN_NEXT) {
                u += w.tip[k];
                w.above[end[k]] =
                    earlier +
                    spring * (w.t[k] * kernel_inverse((w.t[k] + spring) + spring * KERNEL_TINY));
            }
            lanes inverse = kernel_inverse((u + spring) + spring * KERNEL_TINY);
            w.tip[k] = inverse;
            w.above[k] = spring * (u * inverse);
        }
        lanes gamma = w.t[k] + w.above[k], size = kernel_pick(gamma < 0, -gamma, gamma);
        masks less = size * least_mass < least * mass;
        least = kernel_pick(less, size, least);
        least_mass = kernel_pick(less, kernel_all(mass), least_mass);
        at = (less & ((masks){0} + k)) | (~less & at);
    }
    return at;
}

/* from the twist of one lane to the pivot: writes x to tip, and y = x - x_parent to above */
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

/* One step of a transposition in blocks of 1, 2 or 4: two vectors, `size` entries apart, exchange
 * their off-diagonal blocks. */
#define KERNEL_SWAP(node, size, LOW, HIGH)                                                         \
    for (int i = 0; i < WIDTH; i++)                                                                \
        if (!(i & (size))) {                                                                       \
            lanes low = __builtin_shufflevector(node[i], node[i + (size)], LOW);                   \
            node[i + (size)] = __builtin_shufflevector(node[i], node[i + (size)], HIGH);           \
            node[i] = low;                                                                         \
        }
#define KERNEL_INDICES(...) __VA_ARGS__

/* writes the angles of WIDTH nodes, a vector per node, to one row per lane */
INLINE void twist_store(const lanes given[WIDTH], int k, double *row[]) {
    lanes node[WIDTH];
    for (int i = 0; i < WIDTH; i++) node[i] = given[i];
#if defined(__AVX512F__)
    KERNEL_SWAP(node, 1, KERNEL_INDICES(0, 8, 2, 10, 4, 12, 6, 14),
                KERNEL_INDICES(1, 9, 3, 11, 5, 13, 7, 15))
    KERNEL_SWAP(node, 2, KERNEL_INDICES(0, 1, 8, 9, 4, 5, 12, 13),
                KERNEL_INDICES(2, 3, 10, 11, 6, 7, 14, 15))
    KERNEL_SWAP(node, 4, KERNEL_INDICES(0, 1, 2, 3, 8, 9, 10, 11),
                KERNEL_INDICES(4, 5, 6, 7, 12, 13, 14, 15))
#elif defined(__AVX2__)
    KERNEL_SWAP(node, 1, KERNEL_INDICES(0, 4, 2, 6), KERNEL_INDICES(1, 5, 3, 7))
    KERNEL_SWAP(node, 2, KERNEL_INDICES(0, 1, 4, 5), KERNEL_INDICES(2, 3, 6, 7))
#else
    KERNEL_SWAP(node, 1, KERNEL_INDICES(0, 2), KERNEL_INDICES(1, 3))
#endif
    for (int i = 0; i < WIDTH; i++) memcpy(row[i] + k, &node[i], sizeof node[i]);
}

/* Continues x from the path to the pivot into all other branches, and writes the angles to the
 * lanes' rows. Returns sum m x^2. */
static lanes twist_spread(const struct pend_laplacian *laplacian, struct twist w, masks at,
                          double *row[]) {
    const int *end = laplacian->end;
    lanes total = {0}, sum = {0}, theta[WIDTH];
    int n = laplacian->n, whole = n - n % WIDTH;
    for (int k = 0; k < n; k++) {
        double spring = laplacian->spring[k];
        lanes x = w.tip[k], y = w.above[k];
        if (k) {
            masks climbed = (at >= k) & (at < end[k]);
            lanes t = w.t[k], pull = w.tip[laplacian->parent[k]] *
                                     kernel_inverse((t + spring) + spring * KERNEL_TINY);
            x = kernel_pick(climbed, x, pull * spring);
            y = kernel_pick(climbed, y, -pull * t);
            w.tip[k] = x;
        }
        sum = kernel_fma(laplacian->mass[k] * x, x, sum);
        if (k % 256 == 255) {
            total += sum;
            sum = (lanes){0};
        }
        theta[k % WIDTH] = y * (1 / laplacian->len[k]);
        if (k % WIDTH == WIDTH - 1) twist_store(theta, k + 1 - WIDTH, row);
    }
    for (int k = whole; k < n; k++)
        for (int i = 0; i < WIDTH; i++) row[i][k] = theta[k - whole][i];
    return total + sum;
}

static void twist_tips(int n, struct twist w, lanes scale, double *row[]) {
    lanes node[WIDTH];
    int whole = n - n % WIDTH;
    for (int k = 0; k < whole; k += WIDTH) {
        for (int j = 0; j < WIDTH; j++) node[j] = w.tip[k + j] * scale;
        twist_store(node, k, row);
    }
    for (int k = whole; k < n; k++)
        for (int i = 0; i < WIDTH; i++) row[i][k] = w.tip[k][i] * scale[i];
}

static void kernel_vectors(const struct pend_laplacian *laplacian, const double value[], int lead,
                           double work[], double *vector[], double *tip[]) {
    size_t n = (size_t)laplacian->n;
    lanes shift, *room = (lanes *)work;
    struct twist w = {room, room + n, room + 2 * n};
    for (int i = 0; i < WIDTH; i++) shift[i] = value[i];
    twist_up(laplacian, shift, w);
    masks at = twist_down(laplacian, shift, w);
    for (int i = 0; i < WIDTH; i++) twist_climb(laplacian, w, (int)at[i], i);
    lanes square = twist_spread(laplacian, w, at, vector), scale;
    for (int i = 0; i < WIDTH; i++) {
        scale[i] = copysign(1 / sqrt(square[i]), vector[i][lead]);
        for (size_t k = 0; k < n; k++) vector[i][k] *= scale[i];
    }
    if (tip) twist_tips(laplacian->n, w, scale, tip);
}

/* the function `fine` of the kernel */
void KERNEL_NAME(pend_modes_refine_for_)(const struct pend_laplacian *laplacian,
                                         const double value[], int lead, double work[],
                                         double *vector[], double *tip[]);

const struct pend_modes_kernel KERNEL_NAME(pend_modes_kernel_) = {
    WIDTH, kernel_probe, kernel_vectors, KERNEL_NAME(pend_modes_refine_for_)};
