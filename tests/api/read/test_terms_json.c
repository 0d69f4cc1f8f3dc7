/* Real pendulums in requests: the numbers that are written are read into the same list, in every
 * form; errors are refused with their pointers. */
#include "api/read/terms_json.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "api/op/op.h"
#include "api/read/tree_json.h"
#include "tests/api/post.h"
#include "tests/harness/test.h"
#include "tests/harness/trees.h"

enum { ARMS_MOST = 12, HARMONICS_MOST = 40, TEXT = 1 << 16 };

/* a pendulum with random terms, in the caller's order; NAN = the arm lacks the field */
struct real {
    int n, parent[ARMS_MOST], harmonics;
    double length[ARMS_MOST], mass[ARMS_MOST];
    double row[PEND_TERM_ROWS][ARMS_MOST], one[PEND_TERM_ONES];
    struct {
        int drives;
        double part[3];
    } harmonic[HARMONICS_MOST];
};

struct text {
    char data[TEXT];
    size_t bytes;
};

static void add(struct text *text, const char *format, ...) __attribute__((format(printf, 2, 3)));

static void add(struct text *text, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    text->bytes +=
        (size_t)vsnprintf(text->data + text->bytes, TEXT - text->bytes, format, arguments);
    va_end(arguments);
}

static double between(unsigned long long *seed, double low, double high) {
    return low + (high - low) * test_random(seed);
}

static void real_harmonics(struct real *real, int drives, unsigned long long *seed) {
    int count = test_random_int(seed, 3);
    for (int h = 0; h < count && real->harmonics < HARMONICS_MOST; h++) {
        real->harmonic[real->harmonics].drives = drives;
        for (int p = 0; p < 3; p++) real->harmonic[real->harmonics].part[p] = between(seed, -9, 9);
        real->harmonics++;
    }
}

static void real_arm(struct real *real, int i, unsigned chance, unsigned long long *seed) {
    static const enum pend_term_row together[][3] = {
        {PEND_TERM_ROD, PEND_TERM_ROD, PEND_TERM_ROD},
        {PEND_TERM_CENTER_X, PEND_TERM_CENTER_Y, PEND_TERM_INERTIA},
        {PEND_TERM_AT_X, PEND_TERM_AT_Y, PEND_TERM_AT_Y},
        {PEND_TERM_DAMPING, PEND_TERM_DAMPING, PEND_TERM_DAMPING},
        {PEND_TERM_STIFFNESS, PEND_TERM_REST, PEND_TERM_REST},
        {PEND_TERM_FRICTION, PEND_TERM_FRICTION_SPEED, PEND_TERM_FRICTION},
        {PEND_TERM_TORQUE, PEND_TERM_TORQUE, PEND_TERM_TORQUE},
        {PEND_TERM_DRAG, PEND_TERM_DRAG_QUADRATIC, PEND_TERM_DRAG_SPEED}};
    for (int r = 0; r < PEND_TERM_ROWS; r++) real->row[r][i] = NAN;
    for (size_t f = 0; f < sizeof together / sizeof *together; f++) {
        if ((unsigned)test_random_int(seed, 100) >= chance) continue;
        if (together[f][0] == PEND_TERM_AT_X && real->parent[i] < 0) continue;
        for (int p = 0; p < 3; p++) real->row[together[f][p]][i] = between(seed, 0.1, 2);
        if (together[f][0] == PEND_TERM_CENTER_X)
            real->row[PEND_TERM_BODY][i] = between(seed, 1, 3);
    }
    int bare = !isnan(real->row[PEND_TERM_ROD][i]) || !isnan(real->row[PEND_TERM_BODY][i]);
    if (bare && test_random_int(seed, 2)) real->mass[i] = 0;
    if (!isnan(real->row[PEND_TERM_TORQUE][i])) real_harmonics(real, i, seed);
}

static void real_init(struct real *real, unsigned long long *seed) {
    memset(real, 0, sizeof *real);
    real->n = 1 + test_random_int(seed, ARMS_MOST);
    test_parents(TEST_TREE_ATTACHED, real->n, real->parent, seed);
    test_parents_shuffle(real->n, real->parent, seed);
    unsigned chance = (unsigned)test_random_int(seed, 101);
    for (int i = 0; i < real->n; i++) {
        real->length[i] = between(seed, 0.5, 2);
        real->mass[i] = between(seed, 0.5, 2);
        real_arm(real, i, chance, seed);
    }
    if (test_random_int(seed, 2)) real->one[PEND_TERM_DRAG_PER_MASS] = between(seed, 0, 1);
    if (test_random_int(seed, 2))
        for (int a = 0; a < 2; a++)
            real->one[PEND_TERM_PIVOT_ACCELERATION_X + a] = between(seed, -3, 3);
    real_harmonics(real, PEND_DRIVE_PIVOT_X, seed);
    real_harmonics(real, PEND_DRIVE_PIVOT_Y, seed);
}

/* writing it as a request */

static void add_harmonics(struct text *text, const struct real *real, int drives) {
    const char *comma = "";
    add(text, "\"harmonics\":[");
    for (int h = 0; h < real->harmonics; h++) {
        if (real->harmonic[h].drives != drives) continue;
        const double *part = real->harmonic[h].part;
        add(text, "%s{\"phase\":%.17g,\"amplitude\":%.17g,\"omega\":%.17g}", comma, part[2],
            part[0], part[1]);
        comma = ",";
    }
    add(text, "]");
}

static void add_all(struct text *text, const struct real *real) {
    add(text, ",\"drag_per_mass\":%.17g,\"pivot\":{\"x\":{", real->one[PEND_TERM_DRAG_PER_MASS]);
    add_harmonics(text, real, PEND_DRIVE_PIVOT_X);
    add(text, "},\"y\":{");
    add_harmonics(text, real, PEND_DRIVE_PIVOT_Y);
    add(text, "},\"acceleration\":[%.17g,%.17g]}", real->one[PEND_TERM_PIVOT_ACCELERATION_X],
        real->one[PEND_TERM_PIVOT_ACCELERATION_Y]);
}

/* the value of field f of arm i */
static void add_value(struct text *text, const struct real *real, int f, int i) {
    const struct api_terms_row *field = api_terms_row((enum api_terms_field)f);
    const double *x = &real->row[field->part->row][i];
    int object = field->kind == API_TERMS_OBJECT || field->kind == API_TERMS_RUBS;
    if (isnan(*x) || field->kind == API_TERMS_STOPS)
        add(text, "null");
    else if (field->kind == API_TERMS_DRIVE) {
        add(text, "{\"constant\":%.17g,", *x);
        add_harmonics(text, real, i);
        add(text, "}");
    } else if (field->kind == API_TERMS_PLAIN && field->part->point)
        add(text, "[%.17g,%.17g]", *x, x[ARMS_MOST]);
    else if (field->kind == API_TERMS_PLAIN)
        add(text, "%.17g", *x);
    for (int p = 0; !isnan(*x) && object && field->part[p].unit; p++) {
        const double *y = &real->row[field->part[p].row][i];
        add(text, "%c\"%s\":", p ? ',' : '{', field->part[p].name);
        if (field->part[p].point)
            add(text, "[%.17g,%.17g]", *y, y[ARMS_MOST]);
        else
            add(text, "%.17g", *y);
    }
    if (!isnan(*x) && object) add(text, "}");
}

static void write_arms(struct text *text, const struct real *real) {
    text->bytes = 0;
    add(text, "{\"pendulum\":{\"arms\":[");
    for (int i = 0; i < real->n; i++) {
        add(text, "%s{\"length\":%.17g", i ? "," : "", real->length[i]);
        if (real->mass[i] > 0) add(text, ",\"mass\":%.17g", real->mass[i]);
        if (real->parent[i] >= 0) add(text, ",\"parent\":\"%d\"", real->parent[i] + 1);
        for (int f = 0; f < API_TERMS_FIELDS; f++) {
            add(text, ",\"%s\":", api_terms_row((enum api_terms_field)f)->name);
            add_value(text, real, f, i);
        }
        add(text, "}");
    }
    add(text, "]");
    add_all(text, real);
    add(text, "}}");
}

static void add_list(struct text *text, const char *name, int n, const double x[]) {
    add(text, "%c\"%s\":[", strcmp(name, "length") ? ',' : ' ', name);
    for (int i = 0; i < n; i++) add(text, "%s%.17g", i ? "," : "", x[i]);
    add(text, "]");
}

static void write_lists(struct text *text, const struct real *real) {
    double parent[ARMS_MOST];
    text->bytes = 0;
    for (int i = 0; i < real->n; i++) parent[i] = real->parent[i] + 1;
    add(text, "{\"pendulum\":{");
    add_list(text, "length", real->n, real->length);
    add_list(text, "mass", real->n, real->mass);
    add_list(text, "parent", real->n, parent);
    for (int f = 0; f < API_TERMS_FIELDS; f++) {
        add(text, ",\"%s\":[", api_terms_row((enum api_terms_field)f)->name);
        for (int i = 0; i < real->n; i++) {
            if (i) add(text, ",");
            add_value(text, real, f, i);
        }
        add(text, "]");
    }
    add_all(text, real);
    add(text, "}}");
}

/* reading it */

static int read_tree(struct api_tree *tree, const char *body) {
    struct api_limits limits;
    OWN(api_problem, clear) problem;
    OWN(api_json, free) *document = NULL;
    api_limits_init(&limits);
    api_problem_init(&problem);
    int good = api_json_new(&document, body, strlen(body), 16, &problem) == PEND_OK;
    memset(tree, 0, sizeof *tree);
    if (good) {
        struct api_value root = api_json_root(document),
                         pendulum = api_value_member(&root, "pendulum");
        good = api_tree_read(tree, &pendulum, &limits, &problem) == PEND_OK;
    }
    CHECK_SAYING(good, "%s is refused: %s %s", body, problem.detail,
                 problem.count ? problem.faults->detail : "");
    return good;
}

static int check_harmonics(const struct api_tree *tree, const struct real *real) {
    int good = (tree->terms ? tree->terms->harmonics : 0) == real->harmonics;
    int next[ARMS_MOST + 2] = {0};
    for (int h = 0; good && h < real->harmonics; h++) {
        const struct pend_harmonic *made = &tree->terms->harmonic[h];
        int drives = made->drives < 0 ? made->drives : tree->tree->order[made->drives];
        int *at = &next[drives + 2];
        while (*at < real->harmonics && real->harmonic[*at].drives != drives) ++*at;
        good &= *at < real->harmonics && !memcmp(real->harmonic[*at].part, &tree->value[made->at],
                                                 sizeof real->harmonic->part);
        ++*at;
    }
    return good;
}

/* the list has every number of the description at its index, and defaults elsewhere */
static void check_list(const struct api_tree *tree, const struct real *real, const char *body) {
    int good = check_harmonics(tree, real) && tree->loads.terms == tree->terms &&
               tree->loads.value == tree->value;
    for (int i = 0; good && i < real->n; i++) {
        int k = tree->tree->place[i], p = real->parent[i];
        good &= tree->tree->mass[k] == real->mass[i];
        for (int r = 0; tree->terms && r < PEND_TERM_ROWS; r++) {
            double x = real->row[r][i], usual = api_terms_usual((enum pend_term_row)r);
            if (isnan(usual)) usual = p < 0 ? 0 : real->length[p];
            if (tree->terms->row[r] < 0)
                good &= isnan(x);
            else
                good &= tree->value[tree->terms->row[r] + k] == (isnan(x) ? usual : x);
        }
        if (tree->terms) good &= tree->terms->hung[k] == !isnan(real->row[PEND_TERM_AT_X][i]);
    }
    for (int one = 0; tree->terms && one < PEND_TERM_ONES; one++)
        good &=
            (tree->terms->one[one] < 0 ? 0 : tree->value[tree->terms->one[one]]) == real->one[one];
    CHECK_SAYING(good, "the list of %s", body);
}

static int same_lists(const struct api_tree *a, const struct api_tree *b) {
    if (!a->terms || !b->terms) return a->terms == b->terms;
    return a->terms->count == b->terms->count &&
           !memcmp(a->terms->row, b->terms->row, sizeof a->terms->row) &&
           !memcmp(a->terms->hung, b->terms->hung, (size_t)a->n) &&
           !memcmp(a->value, b->value, (size_t)a->terms->count * sizeof *a->value);
}

/* the answer of /v1/trees, as a request */
static void check_echo(const struct api_tree *tree, const char *body) {
    static struct text again;
    OWN(test_reply, free) reply = test_post(API_OP_TREES, body);
    CHECK_INT(reply.status, 200);
    char *drag = strstr(reply.out.data, "\"drag_per_mass\":"),
         *pivot = strstr(reply.out.data, "\"pivot\":"),
         *length = strstr(reply.out.data, "\"length_total\":"),
         *arms = strstr(reply.out.data, "\"arms\":["),
         *end = strstr(reply.out.data, ",\"parent\":[");
    if (CHECK(length && arms && end)) {
        char *all = drag && drag < length ? drag : pivot && pivot < length ? pivot : length;
        again.bytes = 0;
        add(&again, "{\"pendulum\":{%.*s%.*s}}", (int)(length - all), all, (int)(end - arms), arms);
        OWN(api_tree, clear) twice;
        if (read_tree(&twice, again.data))
            CHECK_SAYING(same_lists(tree, &twice), "%s is not %s", again.data, body);
    }
}

TEST(terms_are_read_into_the_same_list_in_every_form_and_written_back) {
    static struct text arms, lists;
    unsigned long long seed = 17;
    int ideal = 0, real_ones = 0;
    for (int i = 0; i < 300; i++) {
        struct real real;
        struct api_tree by_arms, by_lists;
        real_init(&real, &seed);
        write_arms(&arms, &real);
        write_lists(&lists, &real);
        if (read_tree(&by_arms, arms.data) && read_tree(&by_lists, lists.data)) {
            check_list(&by_arms, &real, arms.data);
            CHECK_SAYING(same_lists(&by_arms, &by_lists), "%s", lists.data);
            check_echo(&by_arms, lists.data);
            *(by_arms.terms ? &real_ones : &ideal) += 1;
            api_tree_clear(&by_lists);
        }
        api_tree_clear(&by_arms);
    }
    CHECK_SAYING(real_ones > 250 && ideal < 30, "%d real, %d ideal", real_ones, ideal);
}

#define TREE(members) "{\"pendulum\":{" members "}}"
#define LISTS(members) TREE("\"length\":[1,2],\"mass\":[3,4],\"parent\":[0,1]," members)
#define PAPER(members) TREE("\"L\":[1,2],\"m\":[3,4],\"S\":[[1,0],[1,1]]," members)
#define ARM(members) TREE("\"arms\":[{\"length\":1,\"mass\":1," members "}]")
#define BARE(members) TREE("\"arms\":[{\"length\":1," members "}]")

TEST(the_papers_form_has_the_terms_of_the_whole_pendulum) {
    static const char all[] = "\"drag_per_mass\":0.5,\"pivot\":{\"y\":{\"harmonics\":[{"
                              "\"amplitude\":0.1,\"omega\":40}]},\"acceleration\":[1,2]}";
    char lists[400], paper[400];
    struct api_tree a, b;
    snprintf(lists, sizeof lists, LISTS("%s"), all);
    snprintf(paper, sizeof paper, PAPER("%s"), all);
    if (read_tree(&a, lists) && read_tree(&b, paper)) {
        CHECK(a.terms && same_lists(&a, &b));
        CHECK_INT(b.terms->harmonic[0].drives, PEND_DRIVE_PIVOT_Y);
        CHECK(b.value[b.terms->harmonic[0].at + 1] == 40);
        api_tree_clear(&b);
    }
    api_tree_clear(&a);
}

/* every field with its default: the pendulum is ideal, and so is the request */
TEST(what_does_nothing_is_as_if_left_out) {
    static const char *const idle[] = {
        "\"damping\":0",
        "\"damping\":null",
        "\"stiffness\":0,\"rest\":0",
        "\"torque\":0",
        "\"torque\":{}",
        "\"torque\":{\"constant\":0,\"harmonics\":[]}",
        "\"drag\":{}",
        "\"drag\":{\"linear\":0,\"quadratic\":0,\"speed\":0.01}",
        "\"rod\":null,\"body\":null,\"at\":null,\"friction\":null",
    };
    struct test_reply plain =
        test_post(API_OP_FORCES, TREE("\"arms\":[{\"length\":1,\"mass\":1}]"));
    CHECK_INT(plain.status, 200);
    for (size_t i = 0; i < sizeof idle / sizeof *idle; i++) {
        char body[200];
        struct api_tree tree;
        snprintf(body, sizeof body, ARM("%s"), idle[i]);
        if (read_tree(&tree, body)) CHECK_SAYING(!tree.terms && !tree.value, "%s", idle[i]);
        api_tree_clear(&tree);
        OWN(test_reply, free) reply = test_post(API_OP_FORCES, body);
        CHECK_TEXT(reply.out.data, plain.out.data);
    }
    test_reply_free(&plain);
    OWN(api_tree, clear) tree;
    if (read_tree(&tree, LISTS("\"damping\":[0,null],\"at\":[null,1],\"drag_per_mass\":0,"
                               "\"pivot\":{\"x\":{},\"acceleration\":[0,0]}")))
        CHECK(!tree.terms);
}

TEST(an_arm_may_hang_on_any_point_of_its_parent_and_the_tip_is_not_one_of_them) {
    static const struct {
        const char *at;
        double x, y;
        int hung;
    } places[] = {{"1", 1, 0, 0},         {"[1,0]", 1, 0, 0},     {"0", 0, 0, 1},
                  {"-0.25", -0.25, 0, 1}, {"[1,0.5]", 1, 0.5, 1}, {"[3,-1]", 3, -1, 1}};
    for (size_t i = 0; i < sizeof places / sizeof *places; i++) {
        char body[200];
        OWN(api_tree, clear) tree;
        snprintf(body, sizeof body, LISTS("\"at\":[null,%s],\"rod\":[1,null]"), places[i].at);
        if (read_tree(&tree, body)) {
            CHECK_INT(tree.terms->hung[0], 0);
            CHECK_INT(tree.terms->hung[1], places[i].hung);
            CHECK_INT(tree.terms->row[PEND_TERM_AT_X] >= 0, places[i].hung);
            if (places[i].hung) {
                CHECK(pend_terms_get(tree.terms, tree.value, PEND_TERM_AT_X, 1) == places[i].x);
                CHECK(pend_terms_get(tree.terms, tree.value, PEND_TERM_AT_Y, 1) == places[i].y);
            }
        }
    }
}

TEST(a_tip_may_have_no_mass_where_a_rod_or_a_body_has_one) {
    static const char *const good[] = {
        BARE("\"rod\":2"),
        BARE("\"rod\":2,\"mass\":0"),
        BARE("\"rod\":2,\"mass\":null"),
        BARE("\"body\":{\"mass\":2,\"center\":0.5}"),
        BARE("\"body\":{\"mass\":2,\"center\":0,\"inertia\":1}"),
        TREE("\"length\":[1],\"parent\":[0],\"rod\":[2]"),
        TREE("\"length\":[1],\"mass\":[null],\"parent\":[0],\"rod\":[2]"),
        TREE("\"length\":[1],\"mass\":[0],\"parent\":[0],\"body\":[{\"mass\":2,\"center\":[0,1]}]"),
    };
    for (size_t i = 0; i < sizeof good / sizeof *good; i++) {
        OWN(test_reply, free) reply = test_post(API_OP_TREES, good[i]);
        CHECK_SAYING(reply.status == 200, "%s: %s", good[i], reply.out.data);
        CHECK(test_reply_number(&reply, "/arms/0/mass") == 0);
        CHECK(test_reply_number(&reply, "/subtree_mass/0") == 2);
    }
}

TEST(all_faults_of_terms_are_told_at_once_and_none_twice) {
    OWN(test_reply, free) reply = test_post(
        API_OP_TREES, TREE("\"arms\":[{\"length\":1,\"at\":1,\"rest\":2,\"body\":{\"mass\":0,"
                           "\"center\":0},\"friction\":{\"torque\":1,\"speed\":0}},{\"length\":1,"
                           "\"mass\":0,\"parent\":\"1\",\"body\":{\"mass\":1,\"center\":0}}]"));
    CHECK_INT(reply.status, 422);
    CHECK(test_reply_has_fault(&reply, "/pendulum/arms/0/at", "has no meaning"));
    CHECK(test_reply_has_fault(&reply, "/pendulum/arms/0/rest", "needs a"));
    CHECK(test_reply_has_fault(&reply, "/pendulum/arms/0/body/mass", "greater than 0"));
    CHECK(test_reply_has_fault(&reply, "/pendulum/arms/0/friction/speed", "greater than 0"));
    CHECK(test_reply_has_fault(&reply, "/pendulum/arms/1/mass", "has no inertia"));
    CHECK_INT(test_reply_faults(&reply), 5);
}

/* a torque with this many harmonics, in a pendulum with several such torques */
static struct test_reply harmonics_reply(int arms, int count) {
    size_t room = (size_t)arms * ((size_t)count * 40 + 100) + 100, used = 0;
    OWN_MEMORY char *body = malloc(room);
    used += (size_t)snprintf(body, room, "{\"pendulum\":{\"arms\":[");
    for (int i = 0; i < arms; i++) {
        used +=
            (size_t)snprintf(body + used, room - used, "%s{\"length\":1,\"mass\":1,", i ? "," : "");
        if (i) used += (size_t)snprintf(body + used, room - used, "\"parent\":\"%d\",", i);
        used += (size_t)snprintf(body + used, room - used, "\"torque\":{\"harmonics\":[");
        for (int h = 0; h < count; h++)
            used += (size_t)snprintf(body + used, room - used, "%s{\"amplitude\":%d,\"omega\":%d}",
                                     h ? "," : "", h, i);
        used += (size_t)snprintf(body + used, room - used, "]}}");
    }
    snprintf(body + used, room - used, "]}}");
    struct test_reply reply = test_post(API_OP_TREES, body);
    return reply;
}

TEST(a_torque_has_at_most_64_harmonics_and_they_keep_their_order) {
    OWN(test_reply, free) reply = harmonics_reply(3, API_TERMS_HARMONICS);
    CHECK_INT(reply.status, 200);
    CHECK_INT(test_reply_count(&reply, "/arms/2/torque/harmonics"), API_TERMS_HARMONICS);
    CHECK(test_reply_number(&reply, "/arms/2/torque/harmonics/63/amplitude") == 63);
    CHECK(test_reply_number(&reply, "/arms/1/torque/harmonics/7/omega") == 1);
    test_reply_free(&reply);
    reply = harmonics_reply(1, API_TERMS_HARMONICS + 1);
    CHECK(test_reply_has_fault(&reply, "/pendulum/arms/0/torque/harmonics",
                               "has 65 harmonics, more than the 64 that it may have"));
    test_reply_free(&reply);
    reply = harmonics_reply(4000, 12);
    CHECK_INT(reply.status, 200);
    CHECK(test_reply_number(&reply, "/arms/3999/torque/harmonics/11/omega") == 3999);
}

/* the operation's row decides whether it supports terms */
TEST(an_operation_that_takes_no_terms_says_so) {
    static const char fits[] =
        ",\"data\":{\"t\":[0,1],\"series\":[{\"theta\":1,\"values\":[1,0]}]},"
        "\"unknowns\":[{\"vary\":\"gravity\"}],\"iterations\":2";
    static const char *const rest[API_OP_COUNT] = {
        [API_OP_TREES] = "",
        [API_OP_TRAJECTORIES] = ",\"times\":[0,0.1]",
        [API_OP_FORCES] = "",
        [API_OP_MODES] = "",
        [API_OP_ENSEMBLES] = ",\"states\":[{}],\"duration\":0.1",
        [API_OP_EQUATIONS] = "",
        [API_OP_LYAPUNOV] = ",\"duration\":0.1",
        [API_OP_SECTIONS] = ",\"duration\":0.1,\"section\":{\"arm\":1,\"theta\":0}",
        [API_OP_FITS] = fits,
        [API_OP_ORBITS] = ",\"mode\":1,\"amplitude\":0.1",
        [API_OP_RESPONSE] = ",\"drive\":{\"pivot\":{\"x\":1}},\"omega\":[1]",
    };
    int refused = 0;
    for (int op = 0; op < API_OP_COUNT; op++) {
        char body[300], piece[80];
        const struct api_op *row = api_op_at((enum api_op_id)op);
        if (!rest[op]) continue;
        snprintf(
            body, sizeof body,
            "{\"pendulum\":{\"length\":[1],\"mass\":[1],\"parent\":[0],\"stiffness\":[0.1]}%s}",
            rest[op]);
        snprintf(piece, sizeof piece, "which \"%s\" does not support yet", row->name);
        OWN(test_reply, free) reply = test_post((enum api_op_id)op, body);
        if (row->terms)
            CHECK_SAYING(reply.status == 200, "%s: %s", row->name, reply.out.data);
        else
            CHECK_SAYING(test_reply_has_fault(&reply, "/pendulum", piece), "%s: %s", row->name,
                         reply.out.data);
        refused += !row->terms;
    }
    CHECK(refused < API_OP_COUNT - 2 && api_op_trees.terms);
}

struct etag {
    char text[80];
};

static struct etag etag_of(const char *members) {
    struct etag etag = {"refused"};
    struct api_limits limits;
    OWN(api_buffer, clear) out;
    OWN(api_call, free) *call;
    char body[400];
    snprintf(body, sizeof body, ARM("%s"), members);
    struct api_request request = {.op = API_OP_TREES,
                                  .content_type = "application/json",
                                  .body = body,
                                  .body_bytes = strlen(body)};
    api_limits_init(&limits);
    api_buffer_init(&out, 1 << 20);
    if (api_call_new(&call, &limits) != PEND_OK) return etag;
    if (CHECK_SAYING(api_call_open(call, &request, &out) == API_MORE, "%s", body))
        snprintf(etag.text, sizeof etag.text, "%s", api_call_etag(call));
    return etag;
}

/* caches and idempotency keys use the ETag */
TEST(pendulums_that_differ_in_a_term_have_etags_of_their_own) {
    static const char *const others[] = {
        "\"name\":\"a\"",
        "\"rod\":1",
        "\"rod\":1.0000000000000002",
        "\"body\":{\"mass\":1,\"center\":1}",
        "\"body\":{\"mass\":1,\"center\":[1,1]}",
        "\"body\":{\"mass\":1,\"center\":1,\"inertia\":1}",
        "\"damping\":1",
        "\"stiffness\":1",
        "\"stiffness\":1,\"rest\":1",
        "\"friction\":{\"torque\":1,\"speed\":1}",
        "\"friction\":{\"torque\":1,\"speed\":2}",
        "\"torque\":1",
        "\"torque\":{\"harmonics\":[{\"amplitude\":1,\"omega\":1}]}",
        "\"torque\":{\"harmonics\":[{\"amplitude\":1,\"omega\":2}]}",
        "\"torque\":{\"harmonics\":[{\"amplitude\":1,\"omega\":1,\"phase\":1}]}",
        "\"drag\":{\"linear\":1}",
        "\"drag\":{\"quadratic\":1}",
        "\"drag\":{\"quadratic\":1,\"speed\":1}",
    };
    static const char *const same[][2] = {
        {"\"name\":\"a\"", "\"name\":\"a\",\"damping\":0,\"rod\":null,\"torque\":0,\"drag\":{}"},
        {"\"stiffness\":1", "\"stiffness\":1,\"rest\":0"},
        {"\"drag\":{\"quadratic\":1}", "\"drag\":{\"speed\":0.01,\"quadratic\":1,\"linear\":0}"},
        {"\"torque\":{\"harmonics\":[{\"amplitude\":1,\"omega\":1}]}",
         "\"torque\":{\"constant\":0,\"harmonics\":[{\"amplitude\":1,\"omega\":1,\"phase\":0}]}"},
        {"\"body\":{\"mass\":1,\"center\":1}", "\"body\":{\"inertia\":0,\"center\":1,\"mass\":1}"},
    };
    enum { OTHERS = sizeof others / sizeof *others };
    struct etag seen[OTHERS];
    for (int i = 0; i < OTHERS; i++) {
        seen[i] = etag_of(others[i]);
        for (int j = 0; j < i; j++)
            CHECK_SAYING(strcmp(seen[i].text, seen[j].text) != 0, "%s and %s", others[i],
                         others[j]);
    }
    for (size_t i = 0; i < sizeof same / sizeof *same; i++)
        CHECK_TEXT(etag_of(same[i][1]).text, etag_of(same[i][0]).text);
}
