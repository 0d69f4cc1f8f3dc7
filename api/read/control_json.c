#include "api/read/control_json.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { CONTROLLERS_MOST = 16, DELAY_MOST = 100, INSTANTS_MOST = 100000, LAWS_MOST = 4 };
/* s, shortest and longest period of a controller */
static const double control_finest = 1e-9, control_longest = 1e6;

struct control_reading {
    struct api_rules *rules;
    const struct api_controlled *of;
    struct api_problem *problem;
    struct pend_controller *controller;
    int outputs; /* number of delayed outputs of all controllers, for each of which the gains may
                  * have a column */
    enum pend_status status;
};

int api_control_place(const struct api_controlled *of, int i) {
    int all = of->tree->n, n = all - of->cart;
    if (i >= 2 * all) return i;
    if (i >= 2 * n) return i == 2 * n ? 0 : all;
    return of->tree->place[i % n] + (i >= n ? all : 0);
}

/* reserves space for `count` more elements of `size` bytes; returns NULL and sets the status if
 * memory is short */
static void *room_for(struct control_reading *r, void **list, size_t have, size_t count,
                      size_t size) {
    void *grown = realloc(*list, (have + count) * size);
    if (grown)
        *list = grown;
    else
        r->status = PEND_NO_MEMORY;
    return grown ? (char *)grown + have * size : NULL;
}

static double *more_numbers(struct control_reading *r, size_t count, size_t *at) {
    void *list = r->rules->number;
    double *made = room_for(r, &list, r->rules->numbers, count, sizeof *made);
    r->rules->number = list;
    *at = r->rules->numbers;
    if (made) r->rules->numbers += count;
    return made;
}

/* reads a row of a schedule; a row that is a state is put into stored order */
static void read_row(struct control_reading *r, const struct api_value *value, int width, int state,
                     double row[]) {
    static const char *const each[] = {"gain", "number of the state"};
    double *given = malloc((size_t)width * sizeof *given);
    if (!given) r->status = PEND_NO_MEMORY;
    if (given && api_field_numbers(value, width, each[state], given, r->problem) > 0)
        for (int i = 0; i < width; i++) row[state ? api_control_place(r->of, i) : i] = given[i];
    free(given);
}

/* reads instants; adds an error if they are not ascending */
static const double *read_instants(struct control_reading *r, const struct api_value *t,
                                   int *count) {
    if (!api_field_needed(t, r->problem)) return NULL;
    const double *list = api_value_numbers(t, count);
    int good = list && *count >= 2 && *count <= INSTANTS_MOST;
    for (int i = 1; good && i < *count; i++) good = list[i] - list[i - 1] >= control_finest;
    if (!good)
        api_value_fault(t, r->problem,
                        API_CODE_ORDER
                        "must be a list of 2 to %d instants, s, that ascend by 1e-9 s or more",
                        INSTANTS_MOST);
    return good ? list : NULL;
}

/* reads a single row, or {"t", "value"} with one row per instant; `wide` is another allowed
 * width */
static void read_schedule(struct control_reading *r, const struct api_value *value, int width,
                          int wide, int state, struct pend_schedule *schedule) {
    static const char *const names[] = {"t", "value", NULL};
    int table = api_value_kind(value) == API_OBJECT, rows = 0;
    struct api_value list = api_value_member(value, "value");
    struct api_value item = api_value_item(&list, 0);
    const double *instants = NULL;
    if (table) {
        (void)api_value_only(value, names, r->problem);
        if (!(instants = read_instants(r, API_MEMBER(value, "t"), &schedule->count))) return;
        if (!api_field_needed(&list, r->problem)) return;
        if (api_value_count(&list) != schedule->count) {
            api_value_fault(&list, r->problem,
                            API_CODE_WRONG_COUNT "must have %d rows, one for each instant",
                            schedule->count);
            return;
        }
        double *at = more_numbers(r, (size_t)schedule->count, &schedule->t);
        if (at) memcpy(at, instants, (size_t)schedule->count * sizeof *at);
    }
    if (wide > width && api_value_count(table ? &item : value) == wide) width = wide;
    rows = table ? schedule->count : 1;
    schedule->width = width;
    double *row = more_numbers(r, (size_t)rows * (size_t)width, &schedule->value);
    for (int i = 0; row && i < rows; i++, item = api_value_next(&item))
        read_row(r, table ? &item : value, width, state, row + (size_t)i * (size_t)width);
}

static int read_law(struct control_reading *r, const struct api_value *value, int depth);

static void read_feedback(struct control_reading *r, const struct api_value *value,
                          struct pend_law *law) {
    static const char *const names[] = {"gains", "reference", NULL};
    struct api_value gains = api_value_member(value, "gains");
    struct api_value reference = api_value_member(value, "reference");
    int rows = 2 * r->of->tree->n;
    (void)api_value_only(value, names, r->problem);
    if (api_field_needed(&gains, r->problem))
        read_schedule(r, &gains, rows, rows + r->outputs, 1, &law->gains);
    law->reference.width = rows;
    if (api_value_kind(&reference) != API_MISSING) {
        read_schedule(r, &reference, rows, rows, 1, &law->reference);
        return;
    }
    double *zero = more_numbers(r, (size_t)rows, &law->reference.value);
    if (zero) memset(zero, 0, (size_t)rows * sizeof *zero);
}

/* reads numbers by name, such as the gains of a law; missing numbers are 0 */
static void read_named(struct control_reading *r, const struct api_value *value,
                       const char *const names[], int count, struct pend_law *law) {
    law->gains.width = count;
    double *gains = more_numbers(r, (size_t)count, &law->gains.value);
    for (int i = 0; gains && i < count; i++) {
        struct api_value field = api_value_member(value, names[i]);
        gains[i] = 0;
        (void)api_value_read_number(&field, -INFINITY, INFINITY, "", &gains[i], r->problem);
    }
}

static void read_pid(struct control_reading *r, const struct api_value *value,
                     struct pend_law *law) {
    static const char *const names[] = {"p", "i", "d", "reference", NULL};
    struct api_value reference = api_value_member(value, "reference");
    (void)api_value_only(value, names, r->problem);
    read_named(r, value, names, 3, law);
    if (api_field_needed(&reference, r->problem))
        read_schedule(r, &reference, 1, 1, 0, &law->reference);
}

static void read_swing_up(struct control_reading *r, const struct api_value *value,
                          struct pend_law *law, int depth) {
    static const char *const names[] = {"gain", "p", "d", "energy", "within", "then", NULL};
    static const char *const bounds[] = {"theta", "thetad", NULL};
    struct api_value within = api_value_member(value, "within"),
                     then = api_value_member(value, "then");
    (void)api_value_only(value, names, r->problem);
    (void)api_field_needed(API_MEMBER(value, "gain"), r->problem);
    read_named(r, value, names, 3, law);
    law->energy = NAN;
    (void)api_value_read_number(API_MEMBER(value, "energy"), -INFINITY, INFINITY, "J", &law->energy,
                                r->problem);
    if (api_field_object(&within, NULL, r->problem)) {
        (void)api_value_only(&within, bounds, r->problem);
        for (int i = 0; i < 2; i++) {
            struct api_value bound = api_value_member(&within, bounds[i]);
            if (api_field_needed(&bound, r->problem))
                (void)api_value_read_number(&bound, 0, INFINITY, i ? "rad/s" : "rad",
                                            &law->within[i], r->problem);
        }
    }
    if (!api_field_needed(&then, r->problem)) return;
    law->next = read_law(r, &then, depth + 1);
    if (law->next >= 0 && r->rules->law[law->next].kind != PEND_LAW_FEEDBACK)
        api_value_fault(&then, r->problem,
                        API_CODE_UNSUPPORTED
                        "must be a \"feedback\": its reference defines where it takes over");
}

/* reads the law of a controller; returns its index, -1 after an error */
static int read_law(struct control_reading *r, const struct api_value *value, int depth) {
    static const char *const kinds[] = {"feedback", "pid", "swing_up", NULL};
    struct pend_law law = {.next = -1};
    int found = -1;
    if (!api_field_object(value, kinds, r->problem)) return -1;
    for (int i = 0; kinds[i]; i++) {
        struct api_value body = api_value_member(value, kinds[i]);
        if (api_value_kind(&body) == API_MISSING || !api_field_object(&body, NULL, r->problem))
            continue;
        found = found < 0 && depth < LAWS_MOST ? i : LAWS_MOST;
        law.kind = (enum pend_law_kind)i;
        if (i == PEND_LAW_FEEDBACK) read_feedback(r, &body, &law);
        if (i == PEND_LAW_PID) read_pid(r, &body, &law);
        if (i == PEND_LAW_SWING_UP) read_swing_up(r, &body, &law, depth);
    }
    if (found < 0 || found == LAWS_MOST) {
        api_value_fault(value, r->problem,
                        API_CODE_MISSING "must have one of \"feedback\", \"pid\" and \"swing_up\"");
        return -1;
    }
    void *list = r->rules->law;
    struct pend_law *made = room_for(r, &list, (size_t)r->rules->laws, 1, sizeof *made);
    r->rules->law = list;
    if (!made) return -1;
    *made = law;
    return r->rules->laws++;
}

static void read_limit(struct control_reading *r, const struct api_value *limit) {
    double both[2];
    if (api_field_numbers(limit, 2, "bound", both, r->problem) <= 0) return;
    if (!(both[0] < both[1])) {
        api_value_fault(limit, r->problem, API_CODE_ORDER "must ascend, [low, high]");
        return;
    }
    r->controller->low = both[0], r->controller->high = both[1];
}

static void read_joint(struct control_reading *r, const struct api_value *value) {
    struct api_value joint = api_value_member(value, "joint"), on = api_value_member(value, "cart");
    int cart = 0, both = api_value_kind(&joint) != API_MISSING;
    (void)api_field_truth(&on, &cart, r->problem);
    if (cart == both) {
        api_value_fault(value, r->problem,
                        API_CODE_MISSING "must have either \"joint\" or \"cart\": true, not both");
        return;
    }
    if (cart && !r->of->cart)
        api_value_fault(&on, r->problem, API_CODE_NOT_APPLICABLE "the pendulum has no cart");
    int arm = cart ? -1 : r->of->arm(r->of->whole, &joint, r->problem);
    r->controller->drives = arm < 0 ? 0 : r->of->tree->place[arm];
}

static void read_controller(struct control_reading *r, const struct api_value *value) {
    static const char *const names[] = {"joint", "cart",  "law",      "period",
                                        "delay", "limit", "quantize", NULL};
    struct api_value period = api_value_member(value, "period"),
                     law = api_value_member(value, "law");
    struct pend_controller *c = r->controller;
    (void)api_value_only(value, names, r->problem);
    read_joint(r, value);
    if (api_field_needed(&period, r->problem))
        (void)api_value_read_number(&period, control_finest, control_longest, "s", &c->period,
                                    r->problem);
    read_limit(r, API_MEMBER(value, "limit"));
    (void)api_value_read_number(API_MEMBER(value, "quantize"), 0, INFINITY, "", &c->quantum,
                                r->problem);
    if (api_field_needed(&law, r->problem)) c->law = read_law(r, &law, 0);
}

/* checks that gains of delayed outputs occur only if all controllers have the same delay */
static void check_waiting(const struct control_reading *r, const struct api_value *value) {
    const struct api_rules *rules = r->rules;
    int wide = 0, alike = 1;
    for (int i = 0; i < rules->laws; i++)
        wide |= rules->law[i].kind == PEND_LAW_FEEDBACK &&
                rules->law[i].gains.width > 2 * r->of->tree->n;
    for (int i = 1; i < rules->controllers; i++)
        alike &= rules->controller[i].delay == rules->controller[0].delay &&
                 rules->controller[i].period == rules->controller[0].period;
    if (wide && !alike)
        api_value_fault(value, r->problem,
                        API_CODE_CONFLICT "has gains of delayed outputs: then all controllers need "
                                          "the same period and the same delay");
}

enum pend_status api_control_read(struct api_rules *rules, const struct api_controlled *of,
                                  const struct api_value *value, struct api_problem *problem) {
    struct api_value item = api_value_item(value, 0);
    int count = api_value_count(value);
    long delay = 0;
    if (api_value_kind(value) == API_MISSING) return PEND_OK;
    if (api_value_kind(value) != API_ARRAY || !count || count > CONTROLLERS_MOST) {
        api_value_fault(value, problem,
                        API_CODE_WRONG_COUNT "must be a list of 1 to %d controllers",
                        CONTROLLERS_MOST);
        return PEND_OK;
    }
    rules->controller = calloc((size_t)count, sizeof *rules->controller);
    if (!rules->controller) return PEND_NO_MEMORY;
    struct control_reading r = {.rules = rules, .of = of, .problem = problem};
    for (; api_value_kind(&item) != API_MISSING; item = api_value_next(&item)) {
        struct pend_controller *c = r.controller = rules->controller + rules->controllers++;
        *c = (struct pend_controller){.low = -INFINITY, .high = INFINITY};
        if (!api_field_object(&item, NULL, problem)) continue;
        delay = 0;
        (void)api_field_whole(API_MEMBER(&item, "delay"), 0, DELAY_MOST, &delay, problem);
        c->delay = (int)delay;
        r.outputs = count * c->delay;
        read_controller(&r, &item);
    }
    check_waiting(&r, value);
    return r.status;
}
