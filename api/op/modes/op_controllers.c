/* POST /v1/controllers: gains of sampled feedback about an equilibrium, and the properties of the
 * closed loop.
 * Leaves to others: the loop (core/control), the equilibrium and its modes (core/modes), running a
 * controller (trajectories).
 * Invariant: states and gains are in the caller's order: all theta, all thetad, the cart's position
 * and velocity, the delayed outputs, newest first. */
#include "api/op/op.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "api/encode/encode.h"
#include "api/encode/stats_text.h"
#include "api/json/json_out.h"
#include "api/read/control_json.h"
#include "api/read/state_json.h"
#include "core/control/loop.h"
#include "core/modes/rest.h"

/* limits: coordinates; numbers of a state with delayed outputs; the shortest period, s; the largest
 * distance of the equilibrium from the given angles, rad */
enum { ARMS_MOST = 30, ROWS_MOST = 80, DELAY_MOST = 20 };
static const double finest = 1e-9, longest = 1e6, near = 0.1;
/* s per cube of the number of rows */
static const double row_seconds = 2e-7;

struct controllers {
    struct api_tree tree;
    struct api_states *start;
    int inputs, sensors, *input, *sensor; /* stored arms of the actuators and sensors; pointers into
                                           * one block */
    double period;
    double *phi, *q, *r; /* the equilibrium, the weights of the state and of the inputs; pointers
                          * into one block */
    double *gains;       /* the given gains; NULL if they are to be computed */
    long delay, digits;
};

static void controllers_clear(void *state) {
    struct controllers *c = state;
    free(c->gains);
    free(c->phi);
    free(c->input);
    api_states_free(&c->start);
    api_tree_clear(&c->tree);
}

/* ---- reading */

static int stored(const struct controllers *c) { return api_tree_stored(&c->tree); }

static int place_of(const struct controllers *c, int i) {
    return api_control_place(&(struct api_controlled){c->tree.tree, c->tree.cart, NULL, NULL}, i);
}

/* reads {"joints": [1], "cart": true}; returns the number of actuators */
static int read_places(const struct controllers *c, const struct api_value *value, const char *arms,
                       int list[], struct api_problem *problem) {
    const char *const names[] = {arms, "cart", NULL};
    int count = 0, cart = 0;
    if (!api_field_object(value, names, problem)) return 0;
    struct api_value joints = api_value_member(value, arms), on = api_value_member(value, "cart");
    API_VALUE_EACH (item, api_value_item(&joints, 0)) {
        int arm = api_tree_read_arm(&c->tree, &item, problem), known = 0;
        if (arm < 0) continue;
        for (int i = 0; i < count; i++) known |= list[i] == c->tree.tree->place[arm];
        if (known) api_value_fault(&item, problem, API_CODE_DUPLICATE "is in the list already");
        if (!known) list[count++] = c->tree.tree->place[arm];
    }
    if (api_field_truth(&on, &cart, problem) > 0 && cart && !c->tree.cart)
        api_value_fault(&on, problem, API_CODE_NOT_APPLICABLE "the pendulum has no cart");
    if (cart && c->tree.cart) list[count++] = 0;
    if (!count && !problem->status)
        api_value_fault(value, problem, API_CODE_MISSING "needs \"%s\" or \"cart\"", arms);
    return count;
}

/* adds an error that states which torques would hold a pendulum that is not in equilibrium at the
 * requested angles */
static void fault_rest(const struct controllers *c, const double torque[], const double size[],
                       const struct api_value *value, struct api_problem *problem) {
    char text[400], scratch[16];
    int used = 0;
    for (int i = 0; i < c->tree.n + c->tree.cart; i++) {
        int k = c->tree.tree->place[i];
        if (fabs(torque[k]) <= 1e-9 * size[k] || used > 300) continue;
        used += i < c->tree.n ? snprintf(text + used, sizeof text - (size_t)used,
                                         "%s%.6g N m in the joint of arm %s", used ? ", " : "",
                                         torque[k], api_tree_name(&c->tree, i, scratch))
                              : snprintf(text + used, sizeof text - (size_t)used,
                                         "%s%.6g N on the cart", used ? ", " : "", torque[k]);
    }
    api_value_fault(value, problem,
                    API_CODE_OUT_OF_RANGE "is not an equilibrium: %s would balance it. Add that as "
                                          "a constant torque or force, or choose other angles",
                    used ? text : "other torques");
}

static enum pend_status read_rest(struct controllers *c, const struct api_value *value,
                                  struct api_problem *problem) {
    const struct pend_tree *tree = c->tree.tree;
    size_t n = (size_t)stored(c);
    double far = 0, length = 0;
    if (!(c->phi = calloc(6 * n, sizeof *c->phi))) return PEND_NO_MEMORY;
    double *torque = c->phi + n, *size = torque + n;
    c->q = size + n, c->r = c->q + 2 * n;
    if (api_value_kind(value) == API_MISSING)
        for (size_t k = 0; k < n; k++) c->start->phi[k] = k < (size_t)c->tree.cart ? 0 : -M_PI_2;
    memcpy(c->phi, c->start->phi, n * sizeof *c->phi);
    PEND_TRY(pend_rest_torques(tree, &c->tree.loads, c->phi, torque, size));
    enum pend_status status = pend_rest_find(tree, &c->tree.loads, c->phi, NULL, NULL);
    if (status == PEND_NO_MEMORY) return status;
    for (size_t k = (size_t)c->tree.cart; k < n; k++) {
        far = fmax(far, fabs(c->phi[k] - c->start->phi[k]));
        length += tree->len[k];
    }
    if (status != PEND_OK || !(far <= near)) fault_rest(c, torque, size, value, problem);
    // default weights: 1 rad for angles, one pendulum length for the cart, and the torque that
    // holds the pendulum horizontal
    for (size_t k = 0; k < n; k++) c->q[k] = 1;
    if (c->tree.cart) c->q[0] = 1 / (length * length);
    for (int j = 0; j < c->inputs; j++) c->r[j] = 1 / pow(size[c->input[j]], 2);
    return PEND_OK;
}

static void read_weights(struct controllers *c, const struct api_value *root,
                         struct api_problem *problem) {
    int rows = 2 * stored(c);
    double given[2 * (ARMS_MOST + 1)];
    struct api_value q = api_value_member(root, "Q"), r = api_value_member(root, "R");
    if (api_field_numbers(&q, rows, "number of the state", given, problem) > 0)
        for (int i = 0; i < rows; i++) {
            struct api_value item = api_value_item(&q, i);
            if (!(given[i] >= 0 && given[i] <= 1e300))
                api_value_fault(&item, problem,
                                API_CODE_OUT_OF_RANGE "must be a number from 0 to 1e300");
            c->q[place_of(c, i)] = given[i];
        }
    if (api_field_numbers(&r, c->inputs, "actuator", given, problem) > 0)
        for (int i = 0; i < c->inputs; i++) {
            struct api_value item = api_value_item(&r, i);
            if (!(given[i] > 0 && given[i] <= 1e300))
                api_value_fault(&item, problem,
                                API_CODE_OUT_OF_RANGE "must be greater than 0 and at most 1e300");
            c->r[i] = given[i];
        }
}

/* reads gains to be examined: one row per actuator; a single actuator needs no list of rows */
static enum pend_status read_gains(struct controllers *c, const struct api_value *root,
                                   struct api_problem *problem) {
    struct api_value gains = api_value_member(root, "gains"), item = api_value_item(&gains, 0);
    int rows = 2 * stored(c) + c->inputs * (int)c->delay;
    double row[2 * (ARMS_MOST + 1) + ROWS_MOST];
    if (api_value_kind(&gains) == API_MISSING) return PEND_OK;
    for (int i = 0; i < 2; i++) {
        struct api_value weight = api_value_member(root, i ? "R" : "Q");
        if (api_value_kind(&weight) != API_MISSING)
            api_value_fault(&weight, problem,
                            API_CODE_CONFLICT
                            "computes gains, but \"gains\" are given too: leave one out");
    }
    int flat = c->inputs == 1 && api_value_kind(&item) == API_NUMBER;
    if (!flat && api_value_count(&gains) != c->inputs) {
        api_value_fault(&gains, problem,
                        API_CODE_WRONG_COUNT "must have %d rows, one for each actuator", c->inputs);
        return PEND_OK;
    }
    c->gains = calloc((size_t)(rows * c->inputs), sizeof *c->gains);
    if (!c->gains) return PEND_NO_MEMORY;
    for (int j = 0; j < c->inputs; j++, item = api_value_next(&item)) {
        if (api_field_numbers(flat ? &gains : &item, rows, "number of the state", row, problem) <=
            0)
            continue;
        for (int i = 0; i < rows; i++) c->gains[j * rows + place_of(c, i)] = row[i];
    }
    return PEND_OK;
}

static enum pend_status read_loop(struct controllers *c, const struct api_reading *reading) {
    struct api_problem *problem = reading->problem;
    const struct api_value *root = reading->root;
    struct api_value rest = api_value_member(root, "equilibrium");
    struct api_value sensors = api_value_member(root, "sensors");
    int n = stored(c);
    if (c->tree.n > ARMS_MOST) {
        api_value_fault(API_MEMBER(root, "pendulum"), problem,
                        API_CODE_LIMIT "has %d arms; controllers are designed for at most %d",
                        c->tree.n, ARMS_MOST);
        return PEND_OK;
    }
    PEND_TRY(api_states_new(&c->start, 1, n));
    api_states_read(c->start, 0, &rest, &c->tree, reading->limits, problem);
    if (c->start->mode[0])
        api_value_fault(&rest, problem,
                        API_CODE_NOT_APPLICABLE "must be given by angles, not by a mode");
    if (!(c->input = calloc(2 * (size_t)n, sizeof *c->input))) return PEND_NO_MEMORY;
    c->sensor = c->input + n;
    c->inputs = read_places(c, API_MEMBER(root, "actuators"), "joints", c->input, problem);
    for (; c->sensors < n; c->sensors++) c->sensor[c->sensors] = c->sensors;
    if (api_value_kind(&sensors) != API_MISSING)
        c->sensors = read_places(c, &sensors, "arms", c->sensor, problem);
    if (2 * n + c->inputs * (int)c->delay > ROWS_MOST)
        api_value_fault(root, problem,
                        API_CODE_LIMIT "asks for a state of %d numbers, delayed outputs included; "
                                       "controllers are designed for at most %d",
                        2 * n + c->inputs * (int)c->delay, ROWS_MOST);
    if (problem->status) return PEND_OK;
    PEND_TRY(read_rest(c, &rest, problem));
    read_weights(c, root, problem);
    return read_gains(c, root, problem);
}

static enum pend_status controllers_read(void *state, const struct api_reading *reading) {
    static const char *const fields[] = {"pendulum", "equilibrium", "actuators", "sensors",
                                         "period",   "delay",       "Q",         "R",
                                         "gains",    "digits",      NULL};
    struct controllers *c = state;
    struct api_problem *problem = reading->problem;
    struct api_value period = api_value_member(reading->root, "period");
    struct api_value delay = api_value_member(reading->root, "delay");
    (void)api_value_only(reading->root, fields, problem);
    enum pend_status status = api_reading_tree(reading, &c->tree);
    if (status == PEND_NO_MEMORY) return status;
    if (api_field_needed(&period, problem))
        (void)api_value_read_number(&period, finest, longest, "s", &c->period, problem);
    (void)api_field_whole(&delay, 0, DELAY_MOST, &c->delay, problem);
    (void)api_field_whole(API_MEMBER(reading->root, "digits"), 1, 17, &c->digits, problem);
    if (!c->delay) api_value_usual(&delay);
    if (status == PEND_OK) PEND_TRY(read_loop(c, reading));
    return problem->status ? PEND_INVALID : PEND_OK;
}

/* ---- running */

/* the results, pointers into one block */
struct found {
    struct pend_loop *loop;
    struct pend_damped *modes;
    struct api_stats stats;
    char warning[API_WARNING_TEXT];
    double *gains, *multiplier, *reach, *seen; /* multiplier: real, then imaginary parts */
    double *row;                               /* scratch of `rows` numbers */
};

static int unstable(const struct found *f) {
    return !(hypot(f->multiplier[0], f->multiplier[f->loop->rows]) < 1);
}

/* the index of a mode that does not decay and that the actuators cannot reach; -1 = none */
static int found_lost(const struct found *f) {
    double fastest = 0;
    for (int j = 0; j < f->modes->count; j++)
        fastest = fmax(fastest, hypot(f->modes->omega[j], f->modes->decay[j]));
    for (int j = 0; j < f->modes->count; j++)
        if (f->reach[j] < PEND_LOOP_REACHED && f->modes->decay[j] > -1e-9 * fastest) return j;
    return -1;
}

static enum pend_status found_modes(const struct controllers *c, struct found *f) {
    int n = stored(c), size = n * c->sensors;
    double *sees = calloc((size_t)size, sizeof *sees);
    if (!sees) return PEND_NO_MEMORY;
    for (int i = 0; i < c->sensors; i++) sees[c->sensor[i] * c->sensors + i] = 1;
    enum pend_status status =
        pend_loop_reach(f->loop, f->modes, c->inputs, f->loop->joint, f->reach);
    if (status == PEND_OK) status = pend_loop_reach(f->loop, f->modes, c->sensors, sees, f->seen);
    free(sees);
    return status;
}

static enum pend_status found_gains(const struct controllers *c, struct found *f,
                                    struct pend_error *error) {
    int lost = found_lost(f), rows = f->loop->rows;
    if (c->gains) {
        memcpy(f->gains, c->gains, (size_t)(rows * c->inputs) * sizeof *f->gains);
    } else if (lost >= 0) {
        return pend_fail(error, PEND_INVALID, -1, 0,
                         "the actuators cannot control mode %d (growth %.4g 1/s, %.4g rad/s), "
                         "which does not decay: choose other joints, or give the pendulum friction",
                         lost + 1, f->modes->decay[lost], f->modes->omega[lost]);
    } else {
        enum pend_status status = pend_loop_gains(f->loop, c->q, c->r, f->gains);
        if (status == PEND_NO_CONVERGENCE)
            return pend_fail(error, PEND_NOT_FINITE, -1, 0,
                             "no gains were found that make the loop stable: the period of %.4g s "
                             "may be too long, or an undamped mode has no weight",
                             c->period);
        PEND_TRY(status);
    }
    PEND_TRY(pend_loop_multipliers(f->loop, f->gains, -1, f->multiplier, f->multiplier + rows));
    api_stats_whole(&f->stats, "stable", !unstable(f));
    if (!unstable(f)) return PEND_OK;
    snprintf(f->warning, sizeof f->warning,
             "the loop is unstable: its largest multiplier is %.6g %+.6g i, of absolute value %.6g",
             f->multiplier[0], f->multiplier[rows], hypot(f->multiplier[0], f->multiplier[rows]));
    api_stats_warning(&f->stats, "warning_unstable", f->warning);
    return PEND_OK;
}

/* writes a row of a matrix in the caller's order and in natural units */
static enum pend_status write_row(const struct controllers *c, const struct found *f,
                                  const char *name, const double row[], int count,
                                  struct api_buffer *out) {
    for (int i = 0; i < count; i++) f->row[i] = row[place_of(c, i)];
    return api_out_numbers(out, name, count, f->row, (int)c->digits);
}

static enum pend_status write_plant(const struct controllers *c, const struct found *f,
                                    struct api_buffer *out) {
    const struct pend_loop *loop = f->loop;
    int rows = loop->rows, m = c->inputs;
    for (int part = 0; part < 2; part++) {
        PEND_TRY(api_out_open(out, part ? "B" : "A", '['));
        for (int i = 0; i < rows; i++) {
            int at = place_of(c, i), wide = part ? m : rows;
            const double *row = part ? loop->b + at * m : loop->a + at * rows;
            for (int j = 0; j < wide; j++) {
                int by = part ? j : place_of(c, j);
                f->row[j] =
                    row[by] * loop->scale[at] / (part ? loop->input_scale[by] : loop->scale[by]);
            }
            PEND_TRY(api_out_numbers(out, NULL, wide, f->row, (int)c->digits));
        }
        PEND_TRY(api_buffer_text(out, "]"));
    }
    return PEND_OK;
}

static enum pend_status write_brace(struct api_buffer *out) {
    PEND_TRY(api_out_comma(out));
    return api_buffer_text(out, "{");
}

/* writes the controllers in the format of the pendulum's field `control` */
static enum pend_status write_control(const struct controllers *c, const struct found *f,
                                      struct api_buffer *out) {
    int n = stored(c), rows = f->loop->rows;
    PEND_TRY(api_out_open(out, "control", '['));
    for (int j = 0; j < c->inputs; j++) {
        int arm = c->tree.tree->order[c->input[j]];
        PEND_TRY(write_brace(out));
        if (arm < c->tree.n) PEND_TRY(api_out_whole(out, "joint", arm + 1));
        if (arm == c->tree.n) PEND_TRY(api_buffer_text(out, "\"cart\":true"));
        PEND_TRY(api_out_open(out, "law", '{'));
        PEND_TRY(api_out_open(out, "feedback", '{'));
        PEND_TRY(write_row(c, f, "gains", f->gains + j * rows, rows, out));
        for (int i = 0; i < 2 * n; i++) {
            int at = place_of(c, i);
            f->row[i] = at >= n ? 0 : c->phi[at] + (at >= c->tree.cart ? M_PI_2 : 0);
        }
        PEND_TRY(api_out_numbers(out, "reference", 2 * n, f->row, 0));
        PEND_TRY(api_buffer_text(out, "}}"));
        PEND_TRY(api_out_number(out, "period", c->period, 0));
        if (c->delay) PEND_TRY(api_out_whole(out, "delay", c->delay));
        PEND_TRY(api_buffer_text(out, "}"));
    }
    return api_buffer_text(out, "]");
}

static enum pend_status write_missed(const struct found *f, const char *name, const double part[],
                                     struct api_buffer *out) {
    int count = 0;
    for (int j = 0; j < f->modes->count; j++)
        if (part[j] < PEND_LOOP_REACHED) f->row[count++] = j + 1;
    return api_out_numbers(out, name, count, f->row, 0);
}

static enum pend_status write_modes(const struct controllers *c, const struct found *f,
                                    struct api_buffer *out) {
    int count = f->modes->count, digits = (int)c->digits;
    PEND_TRY(api_out_open(out, "modes", '{'));
    PEND_TRY(api_out_numbers(out, "omega", count, f->modes->omega, digits));
    PEND_TRY(api_out_numbers(out, "growth", count, f->modes->decay, digits));
    PEND_TRY(api_out_numbers(out, "reach", count, f->reach, digits));
    PEND_TRY(api_out_numbers(out, "seen", count, f->seen, digits));
    PEND_TRY(api_buffer_text(out, "}"));
    PEND_TRY(write_missed(f, "unreachable", f->reach, out));
    return write_missed(f, "unobservable", f->seen, out);
}

static enum pend_status write_margins(const struct controllers *c, const struct found *f,
                                      struct api_buffer *out) {
    int digits = (int)c->digits;
    PEND_TRY(api_out_open(out, "margins", '['));
    for (int j = 0; j < c->inputs && !unstable(f); j++) {
        struct pend_margins m;
        PEND_TRY(pend_loop_margins(f->loop, f->gains, j, &m));
        PEND_TRY(write_brace(out));
        PEND_TRY(api_out_number(out, "gain_low", m.gain[0], digits));
        if (isfinite(m.gain[1])) PEND_TRY(api_out_number(out, "gain_high", m.gain[1], digits));
        PEND_TRY(api_out_number(out, "phase", m.phase, digits));
        if (isfinite(m.delay)) PEND_TRY(api_out_number(out, "delay", m.delay, digits));
        PEND_TRY(api_buffer_text(out, "}"));
    }
    return api_buffer_text(out, "]");
}

static enum pend_status write_found(const struct controllers *c, struct found *f,
                                    const struct api_turn *turn) {
    struct api_buffer *out = turn->out;
    int rows = f->loop->rows;
    PEND_TRY(api_buffer_text(out, "{"));
    PEND_TRY(write_control(c, f, out));
    PEND_TRY(api_out_open(out, "multipliers", '{'));
    PEND_TRY(api_out_numbers(out, "re", rows, f->multiplier, (int)c->digits));
    PEND_TRY(api_out_numbers(out, "im", rows, f->multiplier + rows, (int)c->digits));
    PEND_TRY(api_buffer_text(out, "}"));
    PEND_TRY(write_margins(c, f, out));
    PEND_TRY(write_modes(c, f, out));
    PEND_TRY(write_plant(c, f, out));
    PEND_TRY(write_row(c, f, "Q", c->q, 2 * stored(c), out));
    PEND_TRY(api_out_numbers(out, "R", c->inputs, c->r, (int)c->digits));
    api_turn_tell(turn, 0, &f->stats);
    PEND_TRY(api_stats_json(&f->stats, out));
    return api_buffer_text(out, "}");
}

static enum pend_status controllers_run(void *state, const struct api_turn *turn, int *done,
                                        struct pend_error *error) {
    const struct controllers *c = state;
    struct found f = {.loop = NULL};
    size_t n = (size_t)stored(c), m = (size_t)c->inputs, rows = 2 * n + m * (size_t)c->delay;
    const struct pend_tree *tree = c->tree.tree;
    enum pend_status status = pend_loop_new(&f.loop, tree, &c->tree.loads, c->phi, c->inputs,
                                            c->input, c->period, (int)c->delay);
    if (status == PEND_OK) status = pend_damped_new(&f.modes, tree, &c->tree.loads, c->phi, error);
    if (status == PEND_OK && !(f.gains = calloc(rows * (m + 3) + 4 * n, sizeof *f.gains)))
        status = PEND_NO_MEMORY;
    f.multiplier = f.gains + m * rows;
    f.row = f.multiplier + 2 * rows;
    f.reach = f.row + rows, f.seen = f.reach + 2 * n;
    if (status == PEND_OK) status = found_modes(c, &f);
    if (status == PEND_OK) status = found_gains(c, &f, error);
    if (status == PEND_OK) status = write_found(c, &f, turn);
    free(f.gains);
    pend_damped_free(&f.modes);
    pend_loop_free(&f.loop);
    *done = status == PEND_OK;
    if (status == PEND_OK || error->text[0]) return status;
    return pend_fail(error, status == PEND_NO_MEMORY ? status : PEND_NOT_FINITE, -1, 0,
                     "lengths, masses, weights and the period differ too much to compute gains");
}

static double controllers_rows(const struct controllers *c) {
    return 2.0 * stored(c) + c->inputs * (double)c->delay;
}

static double controllers_cost(const void *state) {
    return pow(controllers_rows(state), 3) * row_seconds;
}

/* memory of the matrices of the loop and of the Riccati equation, and of the text of A and B */
static double controllers_bytes(const void *state) {
    const struct controllers *c = state;
    double rows = controllers_rows(c);
    return rows * rows * (16 * sizeof(double) + 2 * API_OUT_NUMBER_BYTES) + 1e6 +
           api_tree_bytes(&c->tree) + api_states_bytes(c->start);
}

const struct api_op api_op_controllers = {.name = "controllers",
                                          .size = sizeof(struct controllers),
                                          .body = 1,
                                          .terms = 1,
                                          .cart = 1,
                                          .read = controllers_read,
                                          .run = controllers_run,
                                          .cost = controllers_cost,
                                          .bytes = controllers_bytes,
                                          .clear = controllers_clear};
