#include "core/integrate/pieces/control.h"

#include <assert.h>
#include <math.h>
#include <string.h>

#include "core/dynamics/kinematics_at.h"

/* Index into the state of a controller: number of samples; number of samples at a limit; index of
 * the current law; integral of a pid; the acting and the newest output; delayed outputs, newest
 * first; whole turns added to the reference, rad. After all controllers follows scratch memory for
 * one computation. */
enum { SAMPLES, LIMITED, LAW, INTEGRAL, OUTPUT, FRESH, WAITS };

static size_t control_width(const struct pend_controller *controller, int n) {
    return WAITS + (size_t)controller->delay + (size_t)n;
}

size_t pend_control_numbers(const struct pend_rules *rules, int n) {
    if (!rules || !rules->controllers) return 0;
    size_t count = 6 * (size_t)n;
    for (int i = 0; i < rules->controllers; i++) count += control_width(&rules->controller[i], n);
    return count;
}

static size_t control_place(const struct pend_rules *rules, int n, int i) {
    size_t at = 0;
    for (int j = 0; j < i; j++) at += control_width(&rules->controller[j], n);
    return at;
}

static double control_due(const struct pend_controller *c, double start, const double own[]) {
    return start + own[SAMPLES] * c->period;
}

double pend_control_next(const struct pend_rules *rules, int n, double start, const double own[]) {
    double next = INFINITY;
    for (int i = 0; i < rules->controllers; i++) {
        next = fmin(next, control_due(&rules->controller[i], start, own));
        own += control_width(&rules->controller[i], n);
    }
    return next;
}

double pend_control_output(const struct pend_rules *rules, int n, int i, const double own[]) {
    assert(i >= 0 && i < rules->controllers);
    return own[control_place(rules, n, i) + OUTPUT];
}

double pend_control_saturated(const struct pend_rules *rules, int n, const double own[],
                              int *controller) {
    double most = 0;
    for (int i = 0; i < rules->controllers; i++) {
        double part = own[SAMPLES] > 0 ? own[LIMITED] / own[SAMPLES] : 0;
        if (part > most) most = part, *controller = i;
        own += control_width(&rules->controller[i], n);
    }
    return most;
}

/* the state of the pendulum in the form that laws use */
struct control_view {
    const struct pend_tree *tree;
    const struct pend_loads *loads;
    const struct pend_rules *rules;
    double now;
    const double *phi, *rate;
    double *first, *scratch; /* state of the first controller; scratch of 6 n numbers */
};

static double schedule_at(const struct pend_rules *rules, const struct pend_schedule *s, double now,
                          int i) {
    const double *t = rules->number + s->t, *value = rules->number + s->value + i;
    int low = 0, high = s->count - 1;
    if (s->count <= 1 || now <= t[0]) return value[0];
    if (now >= t[high]) return value[(size_t)high * (size_t)s->width];
    while (high - low > 1) {
        int middle = (low + high) / 2;
        *(t[middle] <= now ? &low : &high) = middle;
    }
    double part = (now - t[low]) / (t[high] - t[low]);
    double from = value[(size_t)low * (size_t)s->width];
    return from + part * (value[(size_t)high * (size_t)s->width] - from);
}

static int view_cart(const struct control_view *v) { return pend_terms_cart(v->loads->terms); }

static double view_state(const struct control_view *v, int i) {
    int n = v->tree->n;
    if (i >= n) return v->rate[i - n];
    return v->phi[i] + (i || !view_cart(v) ? M_PI_2 : 0);
}

/* computes -gains (x - reference), and the contribution of delayed outputs */
static double law_feedback(const struct control_view *v, const struct pend_law *law,
                           const double turns[]) {
    int n = v->tree->n, at = 2 * n;
    double u = 0;
    for (int i = 0; i < 2 * n; i++) {
        double reference = schedule_at(v->rules, &law->reference, v->now, i);
        if (i < n) reference += turns[i];
        u -= schedule_at(v->rules, &law->gains, v->now, i) * (view_state(v, i) - reference);
    }
    for (int j = 0; at < law->gains.width; j++) {
        const double *own = v->first;
        for (int i = 0; i < v->rules->controllers; i++) {
            u -= schedule_at(v->rules, &law->gains, v->now, at++) * own[WAITS + j];
            own += control_width(&v->rules->controller[i], n);
        }
    }
    return u;
}

/* the angle or the rate of a joint relative to the arm that holds it */
static double view_joint(const struct control_view *v, int k, int rate) {
    int n = v->tree->n, p = pend_terms_holder(v->loads->terms, v->tree->parent, k);
    return view_state(v, k + rate * n) - (p >= 0 ? view_state(v, p + rate * n) : 0);
}

static double law_pid(const struct control_view *v, const struct pend_law *law,
                      const struct pend_controller *c, double own[]) {
    const double *gains = v->rules->number + law->gains.value;
    double error = schedule_at(v->rules, &law->reference, v->now, 0) - view_joint(v, c->drives, 0);
    int limited = own[FRESH] != 0 && (own[FRESH] <= c->low || own[FRESH] >= c->high);
    if (!limited || own[FRESH] * error < 0) own[INTEGRAL] += error * c->period;
    return gains[0] * error + gains[1] * own[INTEGRAL] - gains[2] * view_joint(v, c->drives, 1);
}

/* the energy the pendulum would have if the cart had the given speed */
static double view_energy(const struct control_view *v, double speed) {
    int n = v->tree->n;
    double *rate = v->scratch;
    memcpy(rate, v->rate, (size_t)n * sizeof *rate);
    if (view_cart(v)) rate[0] = speed;
    struct pend_energy energy =
        pend_kinematics_energy_at(v->tree, v->loads, v->now, v->phi, rate, v->scratch + n);
    return energy.kinetic + energy.potential;
}

/* the target energy of a swing-up law: by default that at rest at the next law's reference */
static double law_energy(const struct control_view *v, const struct pend_law *law) {
    int n = v->tree->n;
    double *phi = v->scratch, *scratch = phi + 2 * n;
    if (!isnan(law->energy)) return law->energy;
    for (int i = 0; i < n; i++) {
        double theta = schedule_at(v->rules, &v->rules->law[law->next].reference, v->now, i);
        phi[i] = theta - (i || !view_cart(v) ? M_PI_2 : 0);
        phi[n + i] = 0;
    }
    return pend_kinematics_energy_at(v->tree, v->loads, v->now, phi, phi + n, scratch).potential;
}

static double law_swing_up(const struct control_view *v, const struct pend_law *law, int drives) {
    const double *gains = v->rules->number + law->gains.value;
    double missing = law_energy(v, law) - view_energy(v, 0);
    if (!view_cart(v) || drives) return gains[0] * missing * view_joint(v, drives, 1);
    // with speed s and momentum P the kinetic energy is m s^2 / 2 + s P + that of the arms alone
    double momentum = (view_energy(v, 1) - view_energy(v, -1)) / 2;
    return -gains[0] * missing * momentum - gains[1] * v->phi[0] - gains[2] * v->rate[0];
}

static void law_hand_over(const struct control_view *v, const struct pend_law *law, double own[],
                          double turns[]) {
    const struct pend_law *next = v->rules->law + law->next;
    int n = v->tree->n, cart = view_cart(v);
    for (int i = cart; i < n; i++) {
        double off = view_state(v, i) - schedule_at(v->rules, &next->reference, v->now, i);
        turns[i] = 2 * M_PI * round(off / (2 * M_PI));
        if (fabs(off - turns[i]) > law->within[0] || fabs(v->rate[i]) > law->within[1]) return;
    }
    own[LAW]++;
}

int pend_control_near(const struct pend_tree *tree, const struct pend_loads *loads, double now,
                      const double phi[], double bound) {
    const struct pend_rules *rules = loads->terms->rules;
    const struct pend_law *law = pend_control_last(rules, 0);
    assert(law->kind == PEND_LAW_FEEDBACK);
    for (int i = pend_terms_cart(loads->terms); i < tree->n; i++) {
        double off = phi[i] + M_PI_2 - schedule_at(rules, &law->reference, now, i);
        if (!(fabs(remainder(off, 2 * M_PI)) <= bound)) return 0;
    }
    return 1;
}

static double control_compute(const struct control_view *v, const struct pend_controller *c,
                              double own[]) {
    double *turns = own + WAITS + c->delay;
    const struct pend_law *law = v->rules->law + c->law;
    for (int i = 0; i < own[LAW] && law->kind == PEND_LAW_SWING_UP; i++)
        law = v->rules->law + law->next;
    if (law->kind == PEND_LAW_SWING_UP) {
        double before = own[LAW];
        law_hand_over(v, law, own, turns);
        if (own[LAW] > before) law = v->rules->law + law->next;
    }
    double u = law->kind == PEND_LAW_FEEDBACK ? law_feedback(v, law, turns)
               : law->kind == PEND_LAW_PID    ? law_pid(v, law, c, own)
                                              : law_swing_up(v, law, c->drives);
    if (c->quantum > 0) u = c->quantum * round(u / c->quantum);
    own[LIMITED] += !(u > c->low && u < c->high);
    return fmin(fmax(u, c->low), c->high);
}

void pend_control_sample(const struct pend_tree *tree, const struct pend_loads *loads, double start,
                         double now, const double phi[], const double rate[], double own[]) {
    const struct pend_rules *rules = loads->terms->rules;
    int n = tree->n;
    double *room = own + control_place(rules, n, rules->controllers), *at = own;
    struct control_view view = {tree, loads, rules, now, phi, rate, own, room};
    assert(rules->controllers > 0);
    // all controllers compute before any output changes
    for (int i = 0; i < rules->controllers; i++) {
        const struct pend_controller *c = rules->controller + i;
        if (control_due(c, start, at) == now) at[FRESH] = control_compute(&view, c, at);
        at += control_width(c, n);
    }
    at = own;
    for (int i = 0; i < rules->controllers; i++) {
        const struct pend_controller *c = rules->controller + i;
        if (control_due(c, start, at) == now) {
            double *waits = at + WAITS;
            at[OUTPUT] = c->delay ? waits[c->delay - 1] : at[FRESH];
            for (int j = c->delay - 1; j > 0; j--) waits[j] = waits[j - 1];
            if (c->delay) waits[0] = at[FRESH];
            at[SAMPLES]++;
        }
        at += control_width(c, n);
    }
}
