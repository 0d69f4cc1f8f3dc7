/* The sweep from the leaves to the root; b is the displacement of an arm's joint, x its angle and
 * x_p that of its parent:
 *
 *     s = -w^2 + 2 i w drag_per_mass,  d = i w drag,  kappa = spring + i w damper
 *     form = s mass + d,  cross = s moment + d lever,  own = s inertia + d span + fall
 * Each child, whose base is displaced by b + place x, adds its form, cross and own. Then
 *     D = own + kappa,  x = (couple - <cross, b> + kappa x_p) / D
 *
 * (without x_p if the joint turns against the ground: at the pivot, or on a cart). Substituting x
 * leaves a symmetric form in b and x_p for the parent. Complex pivots can vanish: a pivot near 0 is
 * replaced by a small number, and iterative refinement removes the residual. Refinement also
 * restores the digits that light arms between heavy ones lose. */
#include "core/modes/kernel_response.h"

#include "core/simd/vec_isa.h"

#define INLINE static inline __attribute__((always_inline))

/* an elimination pivot smaller than this fraction of its largest terms is replaced */
#define KERNEL_TINY 0x1p-50
/* allowed residual of the equations, relative to the size of their terms */
#define KERNEL_MISSED 0x1p-50

enum { CORRECTIONS = 6 };

typedef struct {
    lanes8 re, im;
} wave;

INLINE wave wave_get(const struct response_lanes *from) {
    return (wave){lanes8_get(from->re), lanes8_get(from->im)};
}

INLINE void wave_put(struct response_lanes *to, wave x) {
    lanes8_put(to->re, x.re);
    lanes8_put(to->im, x.im);
}

INLINE wave wave_add(wave a, wave b) { return (wave){a.re + b.re, a.im + b.im}; }
INLINE wave wave_sub(wave a, wave b) { return (wave){a.re - b.re, a.im - b.im}; }

INLINE wave wave_fma(wave a, wave b, wave c) {
    return (wave){lanes8_fma(a.re, b.re, lanes8_fma(-a.im, b.im, c.re)),
                  lanes8_fma(a.re, b.im, lanes8_fma(a.im, b.re, c.im))};
}

INLINE wave wave_mul(wave a, wave b) {
    return (wave){lanes8_fma(a.re, b.re, -(a.im * b.im)), lanes8_fma(a.re, b.im, a.im * b.re)};
}

INLINE wave wave_scale(double r, wave a, wave c) {
    lanes8 all = lanes8_of(r);
    return (wave){lanes8_fma(all, a.re, c.re), lanes8_fma(all, a.im, c.im)};
}

INLINE lanes8 wave_size(wave a) { return lanes8_abs(a.re) + lanes8_abs(a.im); }

INLINE lanes8 wave_square(wave a) { return lanes8_fma(a.re, a.re, a.im * a.im); }

INLINE wave wave_inverse(wave a) {
    lanes8 part = 1.0 / wave_square(a);
    return (wave){a.re * part, -a.im * part};
}

/* factors by which masses and drag enter at a frequency */
struct kernel_shift {
    wave mass;
    lanes8 omega;
};

/* mass and drag at the frequency: mass m + i w drag d */
INLINE wave kernel_weigh(const struct kernel_shift *shift, double mass, double drag) {
    return (wave){shift->mass.re * mass,
                  lanes8_fma(shift->omega, lanes8_of(drag), shift->mass.im * mass)};
}

INLINE void kernel_add(struct response_lanes *to, wave x) {
    wave_put(to, wave_add(wave_get(to), x));
}

static void kernel_open(const struct linear_arm *arm, const struct kernel_shift *shift,
                        struct response_node *node) {
    wave weight = kernel_weigh(shift, arm->mass, arm->drag);
    wave turn = kernel_weigh(shift, arm->inertia, arm->drag * arm->span);
    wave joint = {lanes8_of(arm->spring), shift->omega * arm->damper};
    wave_put(&node->form[0], weight);
    wave_put(&node->form[1], (wave){lanes8_of(0), lanes8_of(0)});
    wave_put(&node->form[2], weight);
    for (int i = 0; i < 2; i++)
        wave_put(&node->cross[i], kernel_weigh(shift, arm->moment[i], arm->drag * arm->lever[i]));
    lanes8_put(node->scale.re, wave_size(turn) + lanes8_abs(lanes8_of(arm->fall)));
    turn.re += arm->fall;
    wave_put(&node->own, turn);
    wave_put(&node->joint, joint);
}

/* adds the form of an arm to its parent, after elimination of the arm's angle */
static void kernel_pass(const struct linear_arm *arm, const struct response_node *node,
                        struct response_node *parent) {
    wave x = wave_get(&node->cross[0]), y = wave_get(&node->cross[1]);
    wave joint = wave_get(&node->joint), inverse = wave_get(&node->inverse);
    wave minus = {-inverse.re, -inverse.im};
    wave none = {lanes8_of(0), lanes8_of(0)};
    wave xd = wave_mul(x, minus), yd = wave_mul(y, minus);
    wave give = arm->holder < 0 ? none : wave_mul(joint, inverse);
    wave xx = wave_fma(x, xd, wave_get(&node->form[0]));
    wave xy = wave_fma(x, yd, wave_get(&node->form[1]));
    wave yy = wave_fma(y, yd, wave_get(&node->form[2]));
    wave u = wave_mul(x, give), v = wave_mul(y, give), own = wave_mul(give, wave_get(&node->own));
    double px = arm->place[0], py = arm->place[1];
    wave ax = wave_scale(px, xx, wave_scale(py, xy, none));
    wave ay = wave_scale(px, xy, wave_scale(py, yy, none));
    wave bent = wave_scale(px, ax, wave_scale(py, ay, none));
    wave led = wave_scale(2 * px, u, wave_scale(2 * py, v, none));
    kernel_add(&parent->form[0], xx);
    kernel_add(&parent->form[1], xy);
    kernel_add(&parent->form[2], yy);
    kernel_add(&parent->cross[0], wave_add(ax, u));
    kernel_add(&parent->cross[1], wave_add(ay, v));
    kernel_add(&parent->own, wave_add(bent, wave_add(led, own)));
    lanes8_put(parent->scale.re,
               lanes8_get(parent->scale.re) + wave_size(bent) + wave_size(led) + wave_size(own));
}

/* computes the forms and elimination pivots of all arms */
static void kernel_factor(const struct linear_arms *arms, const struct kernel_shift *shift,
                          struct response_node node[]) {
    for (int k = 0; k < arms->n; k++) kernel_open(arms->arm + k, shift, node + k);
    for (int k = arms->n - 1; k >= 0; k--) {
        const struct linear_arm *arm = arms->arm + k;
        wave joint = wave_get(&node[k].joint), own = wave_get(&node[k].own);
        wave pivot = wave_add(own, joint);
        lanes8 least = (lanes8_get(node[k].scale.re) + wave_size(joint)) * KERNEL_TINY;
        bits8 small = (bits8)(wave_size(pivot) < least);
        pivot.re = lanes8_pick(small, least, pivot.re);
        own.re = lanes8_pick(small, pivot.re - joint.re, own.re);
        wave_put(&node[k].own, own);
        wave_put(&node[k].inverse, wave_inverse(pivot));
        if (arm->parent >= 0) kernel_pass(arm, node + k, node + arm->parent);
    }
}

/* adds the solution for a right-hand side (the torques `couple` of the nodes and the displacement
 * of the pivot) in the lanes of a mask */
static void kernel_solve(const struct linear_arms *arms, const wave pivot[2], bits8 where,
                         struct response_node node[]) {
    wave none = {lanes8_of(0), lanes8_of(0)};
    for (int k = 0; k < arms->n; k++)
        for (int i = 0; i < 2; i++) wave_put(&node[k].push[i], none);
    for (int k = arms->n - 1; k > 0; k--) {
        const struct linear_arm *arm = arms->arm + k;
        struct response_node *parent = node + arm->parent;
        wave share = wave_mul(wave_get(&node[k].couple), wave_get(&node[k].inverse));
        wave minus = {-share.re, -share.im}, sum = none;
        if (arm->holder >= 0) sum = wave_mul(share, wave_get(&node[k].joint));
        for (int i = 0; i < 2; i++) {
            wave push = wave_fma(wave_get(&node[k].cross[i]), minus, wave_get(&node[k].push[i]));
            kernel_add(&parent->push[i], push);
            sum = wave_scale(arm->place[i], push, sum);
        }
        kernel_add(&parent->couple, sum);
    }
    for (int k = 0; k < arms->n; k++) {
        const struct linear_arm *arm = arms->arm + k;
        const struct response_node *parent = arm->parent < 0 ? NULL : node + arm->parent;
        wave sum = wave_get(&node[k].couple);
        // `rest` has the parent's new angle, `push` the new displacement of the joint
        wave carrier = parent ? wave_get(&parent->rest) : none;
        wave held = arm->holder < 0 ? none : carrier;
        for (int i = 0; i < 2; i++) {
            wave base =
                parent ? wave_scale(arm->place[i], carrier, wave_get(&parent->push[i])) : pivot[i];
            wave minus = {-base.re, -base.im};
            sum = wave_fma(wave_get(&node[k].cross[i]), minus, sum);
            wave_put(&node[k].push[i], base);
        }
        wave angle =
            wave_mul(wave_fma(wave_get(&node[k].joint), held, sum), wave_get(&node[k].inverse));
        wave_put(&node[k].rest, angle);
        angle.re = lanes8_pick(where, angle.re, none.re);
        angle.im = lanes8_pick(where, angle.im, none.im);
        kernel_add(&node[k].angle, angle);
    }
}

static void kernel_place(const struct linear_arms *arms, const wave pivot[2],
                         struct response_node node[]) {
    for (int k = 0; k < arms->n; k++) {
        const struct linear_arm *arm = arms->arm + k;
        for (int i = 0; i < 2; i++)
            wave_put(&node[k].base[i],
                     arm->parent < 0 ? pivot[i]
                                     : wave_scale(arm->place[i], wave_get(&node[arm->parent].angle),
                                                  wave_get(&node[arm->parent].base[i])));
    }
}

/* computes the joint force and the residual of the arm's own equation, both without its children */
static void kernel_balance(const struct linear_arms *arms, const struct kernel_shift *shift, int k,
                           struct response_node node[]) {
    const struct linear_arm *arm = arms->arm + k;
    wave angle = wave_get(&node[k].angle), miss = wave_get(&node[k].drive), joint;
    wave weight = kernel_weigh(shift, arm->mass, arm->drag);
    wave turn = kernel_weigh(shift, arm->inertia, arm->drag * arm->span);
    lanes8 scale = wave_size(miss);
    for (int i = 0; i < 2; i++) {
        wave base = wave_get(&node[k].base[i]);
        wave cross = kernel_weigh(shift, arm->moment[i], arm->drag * arm->lever[i]);
        wave torque = wave_mul(cross, base);
        wave_put(&node[k].force[i], wave_fma(weight, base, wave_mul(cross, angle)));
        miss = wave_sub(miss, torque);
        scale += wave_size(torque);
    }
    turn.re += arm->fall;
    turn = wave_mul(turn, angle);
    miss = wave_sub(miss, turn);
    scale += wave_size(turn);
    joint = wave_get(&node[k].joint);
    wave none = {lanes8_of(0), lanes8_of(0)};
    wave held = arm->holder < 0 ? none : wave_get(&node[arm->holder].angle);
    wave bent = wave_mul(joint, wave_sub(angle, held));
    miss = wave_sub(miss, bent);
    scale += wave_size(bent);
    wave_put(&node[k].rest, miss);
    lanes8_put(node[k].scale.im, scale);
    // the torque of the joint acts on the parent too; `couple` is unused until the next solution
    wave_put(&node[k].couple, arm->holder < 0 ? none : bent);
}

/* Computes the forces at the joints and the residuals of the equations. Returns the lanes with too
 * large residuals. */
static bits8 kernel_check(const struct linear_arms *arms, const struct kernel_shift *shift,
                          struct response_node node[]) {
    bits8 missed = (bits8)(lanes8_of(0) != 0);
    for (int k = 0; k < arms->n; k++) kernel_balance(arms, shift, k, node);
    for (int k = arms->n - 1; k >= 0; k--) {
        const struct linear_arm *arm = arms->arm + k;
        lanes8 scale = lanes8_get(node[k].scale.im);
        wave rest = wave_get(&node[k].rest);
        missed |= (bits8)(wave_size(rest) > scale * KERNEL_MISSED);
        if (arm->parent < 0) continue;
        struct response_node *parent = node + arm->parent;
        wave back = wave_get(&node[k].couple), sum = wave_add(wave_get(&parent->rest), back);
        scale = wave_size(back);
        for (int i = 0; i < 2; i++) {
            wave force = wave_get(&node[k].force[i]);
            kernel_add(&parent->force[i], force);
            sum = wave_scale(-arm->place[i], force, sum);
            scale += wave_size(force) * lanes8_abs(lanes8_of(arm->place[i]));
        }
        wave_put(&parent->rest, sum);
        lanes8_put(parent->scale.im, lanes8_get(parent->scale.im) + scale);
    }
    return missed;
}

/* sums of squares of the solution and of the torques of drives and pivot, in units of the arms' own
 * stiffness */
static void kernel_sizes(const struct linear_arms *arms, const struct kernel_shift *shift,
                         const wave pivot[2], struct response_sweep *sweep,
                         const struct response_node node[]) {
    lanes8 moved = lanes8_of(0), driven = lanes8_of(0);
    for (int k = 0; k < arms->n; k++) {
        const struct linear_arm *arm = arms->arm + k;
        wave torque = wave_get(&node[k].drive);
        lanes8 stiff = lanes8_get(node[k].scale.re) + wave_size(wave_get(&node[k].joint));
        for (int i = 0; i < 2; i++)
            torque = wave_fma(kernel_weigh(shift, arm->whole[i], arm->wind[i]), pivot[i], torque);
        moved += wave_square(wave_get(&node[k].angle)) * stiff;
        driven += wave_square(torque) / stiff;
    }
    memcpy(sweep->moved, &moved, sizeof moved);
    memcpy(sweep->driven, &driven, sizeof driven);
}

void KERNEL_NAME(pend_response_)(const struct linear_arms *arms, struct response_sweep *sweep,
                                 struct response_node node[]) {
    struct kernel_shift shift;
    wave none = {lanes8_of(0), lanes8_of(0)}, still[2] = {none, none};
    const wave pivot[2] = {wave_get(&sweep->pivot[0]), wave_get(&sweep->pivot[1])};
    memcpy(&shift.omega, sweep->omega, sizeof shift.omega);
    shift.mass.re = -(shift.omega * shift.omega);
    shift.mass.im = shift.omega * (2 * arms->drag_per_mass);
    kernel_factor(arms, &shift, node);
    for (int k = 0; k < arms->n; k++) {
        wave_put(&node[k].angle, none);
        node[k].couple = node[k].drive;
    }
    kernel_solve(arms, pivot, (bits8)(none.re == 0), node);
    for (int i = 0;; i++) {
        kernel_place(arms, pivot, node);
        bits8 missed = kernel_check(arms, &shift, node);
        long long all = 0;
        for (int lane = 0; lane < RESPONSE_LANES; lane++) all |= missed[lane];
        if (i == CORRECTIONS || !all) break;
        for (int k = 0; k < arms->n; k++) node[k].couple = node[k].rest;
        kernel_solve(arms, still, missed, node);
    }
    kernel_sizes(arms, &shift, pivot, sweep, node);
}
