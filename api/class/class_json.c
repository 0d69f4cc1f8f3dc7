#include "api/class/class_json.h"

#include <assert.h>
#include <math.h>
#include <string.h>

#include "api/call/canonical.h"
#include "api/call/job_json.h"
#include "api/encode/negotiate.h"
#include "api/link/scene.h"

/* maximum number of characters of texts */
enum { CLASS_TITLE = 200, CLASS_LINE = 300, CLASS_TEXT = 4000, CLASS_UNIT = 16, CLASS_TRIES = 20 };

/* factor by which a received body may exceed its canonical form, because of blanks and the format
 * of numbers */
enum { CLASS_SPARE = 4 };

struct class_reading {
    const struct api_limits *limits;
    struct api_class_facts *facts;
    struct api_problem *problem;
    enum pend_status status; /* PEND_NO_MEMORY after a failure */
};

/* kinds of questions and answers; the flag of a choice also holds the number of choices */
enum { KIND_NUMBER, KIND_CHOICE, KIND_ANGLE, KIND_TEXT };
enum { FLAG_CLOSED = 1, FLAG_KIND = 2, FLAG_CHOICES = 16 };
static const char *const class_kinds[] = {"number", "choice", "angle", "text", NULL};

/* --- parts --- */

/* the number of characters of a text; -1 if it contains a character that may not occur: control
 * characters (also U+0080 to U+009F), bidirectional controls and, in a line, line separators
 * (U+2028, U+2029) */
static long class_characters(const char *text, int line) {
    long characters = 0;
    for (const unsigned char *at = (const unsigned char *)text; *at; at++) {
        characters += (*at & 0xc0) != 0x80;
        if (!line) continue;
        if (*at < ' ' || *at == 0x7f || (at[0] == 0xc2 && at[1] < 0xa0)) return -1;
        if (at[0] == 0xe2 && at[1] == 0x80 && at[2] >= 0xa8 && at[2] <= 0xae) return -1;
        if (at[0] == 0xe2 && at[1] == 0x81 && at[2] >= 0xa6 && at[2] <= 0xa9) return -1;
    }
    return characters;
}

/* reads a text of least .. most characters, on a single line if `line` */
static void class_text(const struct api_value *value, long least, long most, int line,
                       struct api_problem *problem) {
    char found[API_FOUND_BYTES];
    assert(least >= 0 && least <= most);
    if (api_value_kind(value) == API_MISSING && !least) return;
    const char *text = api_value_text(value);
    if (text) {
        long characters = class_characters(text, line);
        if (characters >= least && characters <= most) return;
        if (characters < 0)
            api_value_fault(value, problem,
                            API_CODE_OUT_OF_RANGE "must be one line, without control characters or "
                                                  "characters that change the writing direction");
        else
            api_value_fault(value, problem,
                            API_CODE_WRONG_COUNT "must have %ld to %ld characters, got %ld", least,
                            most, characters);
        return;
    }
    api_value_found(value, found);
    api_value_fault(value, problem,
                    API_CODE_WRONG_TYPE "must be a text of %ld to %ld characters, got %s", least,
                    most, found);
}

int api_class_id_good(const char *id) {
    size_t bytes = strlen(id);
    return bytes >= 1 && bytes <= API_CLASS_ID &&
           strspn(id, "abcdefghijklmnopqrstuvwxyz0123456789-") == bytes;
}

/* reads the id of an item; returns non-zero if it is present and valid */
static int class_id(const struct api_value *value, int needed, struct api_problem *problem) {
    const char *id = api_value_text(value);
    if (api_value_kind(value) == API_MISSING && !needed) return 0;
    if (id && api_class_id_good(id)) return 1;
    api_value_fault(value, problem, API_CODE_OUT_OF_RANGE "must be 1 to %d of a-z, 0-9 and -",
                    API_CLASS_ID);
    return 0;
}

static void class_scene(const struct api_value *scene, struct class_reading *reading) {
    static const char *const fields[] = {"request", "view", NULL};
    struct api_problem *problem = reading->problem;
    if (api_value_kind(scene) == API_MISSING || api_value_kind(scene) == API_NULL) return;
    if (!api_field_object(scene, NULL, problem)) return;
    struct api_value view = api_value_member(scene, "view");
    (void)api_value_only(scene, fields, problem);
    enum pend_status status =
        api_scene_check_request(API_MEMBER(scene, "request"), reading->limits, problem);
    if (status == PEND_NO_MEMORY) reading->status = status;
    if (api_value_kind(&view) != API_MISSING) (void)api_field_object(&view, NULL, problem);
}

/* reads the value of an answer; returns its flag, 0 if invalid */
static int64_t class_value(const struct api_value *value, struct api_problem *problem) {
    if (api_value_kind(value) == API_STRING) {
        class_text(value, 0, CLASS_TEXT, 0, problem);
        return FLAG_KIND * KIND_TEXT;
    }
    if (api_value_kind(value) != API_NUMBER) {
        char found[API_FOUND_BYTES];
        api_value_found(value, found);
        api_value_fault(value, problem, API_CODE_WRONG_TYPE "must be a number or a text, got %s",
                        found);
        return 0;
    }
    double x = api_value_number(value);
    int whole = x >= 1 && x <= API_CLASS_CHOICES && x == floor(x) ? (int)x : 0;
    return FLAG_KIND * KIND_NUMBER + FLAG_CHOICES * whole;
}

static void class_choices(const struct api_value *choices, struct api_problem *problem) {
    int count = api_value_count(choices);
    assert(count >= 0);
    if (api_value_kind(choices) != API_ARRAY || count < 2 || count > API_CLASS_CHOICES) {
        api_value_fault(choices, problem, API_CODE_WRONG_COUNT "must be a list of 2 to %d texts",
                        API_CLASS_CHOICES);
        return;
    }
    API_VALUE_EACH (item, api_value_first(choices)) class_text(&item, 1, CLASS_LINE, 1, problem);
}

/* reads the kind of answer that a question requires; returns its flag */
static int64_t class_wants(const struct api_value *question, struct api_problem *problem) {
    int kind = KIND_TEXT;
    struct api_value word = api_value_member(question, "kind"),
                     choices = api_value_member(question, "choices");
    if (api_field_needed(&word, problem)) (void)api_field_word(&word, class_kinds, &kind, problem);
    class_text(API_MEMBER(question, "unit"), 0, CLASS_UNIT, 1, problem);
    if (kind == KIND_CHOICE) {
        class_choices(&choices, problem);
        return FLAG_KIND * kind + FLAG_CHOICES * api_value_count(&choices);
    }
    if (api_value_kind(&choices) != API_MISSING)
        api_value_fault(&choices, problem,
                        API_CODE_NOT_APPLICABLE "is only for questions of the kind \"choice\"");
    return FLAG_KIND * kind;
}

int api_class_fits(int64_t question, int64_t answer) {
    assert(question >= 0 && answer >= 0);
    int64_t wanted = question / FLAG_KIND % 8, given = answer / FLAG_KIND % 8;
    int64_t choice = answer / FLAG_CHOICES;
    if (wanted == KIND_TEXT) return given == KIND_TEXT;
    if (given != KIND_NUMBER) return 0;
    return wanted != KIND_CHOICE || (choice >= 1 && choice <= question / FLAG_CHOICES);
}

static void class_tolerance(const struct api_value *tolerance, struct api_problem *problem) {
    double number;
    (void)api_value_read_number(tolerance, 0, INFINITY, "", &number, problem);
}

/* --- the kinds of item --- */

static void class_room(const struct api_value *root, struct class_reading *reading) {
    static const char *const fields[] = {"hours", NULL};
    (void)api_value_only(root, fields, reading->problem);
    (void)api_value_read_number(API_MEMBER(root, "hours"), 0.25, 720, "h", &reading->facts->hours,
                                reading->problem);
}

static void class_pupil(const struct api_value *root, struct class_reading *reading) {
    static const char *const fields[] = {"nickname", NULL};
    struct api_value nickname = api_value_member(root, "nickname");
    (void)api_value_only(root, fields, reading->problem);
    class_text(&nickname, 1, API_CLASS_NICKNAME, 1, reading->problem);
    const char *text = api_value_text(&nickname);
    if (text) strncpy(reading->facts->nickname, text, sizeof reading->facts->nickname - 1);
}

/* reads the teacher's clock and drawer, which the class follows */
static void class_follow(const struct api_value *follow, struct api_problem *problem) {
    static const char *const fields[] = {"drawer", "time", "playing", NULL};
    int playing = 0;
    double time;
    if (api_value_kind(follow) == API_MISSING || !api_field_object(follow, fields, problem)) return;
    class_text(API_MEMBER(follow, "drawer"), 0, CLASS_UNIT, 1, problem);
    (void)api_value_read_number(API_MEMBER(follow, "time"), 0, 1e9, "s", &time, problem);
    (void)api_field_truth(API_MEMBER(follow, "playing"), &playing, problem);
}

static void class_stage(const struct api_value *root, struct class_reading *reading) {
    static const char *const fields[] = {"scene",   "frozen",   "open",      "text",
                                         "release", "question", "worksheet", "address_share",
                                         "follow",  "pace",     NULL};
    struct api_problem *problem = reading->problem;
    struct api_value release = api_value_member(root, "release");
    int truth = 0, opened = 1;
    long count;
    (void)api_value_only(root, fields, problem);
    class_scene(API_MEMBER(root, "scene"), reading);
    (void)api_field_truth(API_MEMBER(root, "frozen"), &truth, problem);
    (void)api_field_truth(API_MEMBER(root, "open"), &opened, problem);
    class_text(API_MEMBER(root, "text"), 0, CLASS_TEXT, 0, problem);
    (void)class_id(API_MEMBER(root, "question"), 0, problem);
    (void)class_id(API_MEMBER(root, "worksheet"), 0, problem);
    (void)api_field_whole(API_MEMBER(root, "address_share"), 1, 100000, &reading->facts->share,
                          problem);
    reading->facts->shut = !opened;
    class_follow(API_MEMBER(root, "follow"), problem);
    (void)api_field_whole(API_MEMBER(root, "pace"), 1, API_CLASS_STEPS, &count, problem);
    if (api_value_kind(&release) == API_MISSING || !api_field_object(&release, NULL, problem))
        return;
    static const char *const parts[] = {"number", "spread", NULL};
    struct api_value number = api_value_member(&release, "number");
    double rad;
    (void)api_value_only(&release, parts, problem);
    if (api_field_needed(&number, problem))
        (void)api_field_whole(&number, 1, 1000000, &count, problem);
    (void)api_value_read_number(API_MEMBER(&release, "spread"), 0, 1, "rad", &rad, problem);
}

static void class_own_stage(const struct api_value *root, struct class_reading *reading) {
    static const char *const fields[] = {"scene", "state", "release", "step", "idle", NULL},
                             *const states[] = {"working", "stuck", "done", "away", NULL};
    struct api_problem *problem = reading->problem;
    int word;
    long number;
    (void)api_value_only(root, fields, problem);
    class_scene(API_MEMBER(root, "scene"), reading);
    (void)api_field_word(API_MEMBER(root, "state"), states, &word, problem);
    (void)api_field_whole(API_MEMBER(root, "release"), 1, 1000000, &number, problem);
    (void)class_id(API_MEMBER(root, "step"), 0, problem);
    (void)api_field_whole(API_MEMBER(root, "idle"), 0, 30 * 86400, &number, problem);
}

static void class_question(const struct api_value *root, struct class_reading *reading) {
    static const char *const fields[] = {"text",  "kind",   "unit", "choices",
                                         "scene", "closed", NULL};
    struct api_problem *problem = reading->problem;
    int shut = 0;
    (void)api_value_only(root, fields, problem);
    class_text(API_MEMBER(root, "text"), 1, CLASS_TEXT, 0, problem);
    class_scene(API_MEMBER(root, "scene"), reading);
    (void)api_field_truth(API_MEMBER(root, "closed"), &shut, problem);
    reading->facts->flag = class_wants(root, problem) + (shut ? FLAG_CLOSED : 0);
}

static void class_solution(const struct api_value *root, struct class_reading *reading) {
    static const char *const fields[] = {"value", "tolerance", "text", "shown", NULL};
    struct api_problem *problem = reading->problem;
    struct api_value value = api_value_member(root, "value");
    (void)api_value_only(root, fields, problem);
    if (api_value_kind(&value) != API_MISSING) (void)class_value(&value, problem);
    class_tolerance(API_MEMBER(root, "tolerance"), problem);
    class_text(API_MEMBER(root, "text"), 0, CLASS_TEXT, 0, problem);
    (void)api_field_truth(API_MEMBER(root, "shown"), &reading->facts->shown, problem);
}

static void class_answer(const struct api_value *root, struct class_reading *reading) {
    static const char *const fields[] = {"value", "scene", NULL};
    struct api_value value = api_value_member(root, "value");
    (void)api_value_only(root, fields, reading->problem);
    if (api_field_needed(&value, reading->problem))
        reading->facts->flag = class_value(&value, reading->problem);
    class_scene(API_MEMBER(root, "scene"), reading);
}

/* reads the question of a step with its solution, which everyone with the worksheet may see */
static void class_step_question(const struct api_value *question, struct class_reading *reading) {
    static const char *const fields[] = {"text",  "kind",      "unit", "choices",
                                         "value", "tolerance", NULL};
    struct api_problem *problem = reading->problem;
    if (api_value_kind(question) == API_MISSING || !api_field_object(question, NULL, problem))
        return;
    struct api_value value = api_value_member(question, "value");
    (void)api_value_only(question, fields, problem);
    class_text(API_MEMBER(question, "text"), 0, CLASS_TEXT, 0, problem);
    int64_t wanted = class_wants(question, problem);
    class_tolerance(API_MEMBER(question, "tolerance"), problem);
    if (api_value_kind(&value) == API_MISSING) return;
    if (!api_class_fits(wanted, class_value(&value, problem)))
        api_value_fault(&value, problem,
                        API_CODE_WRONG_TYPE
                        "must be an answer to the question: a number, the number "
                        "of a choice, or a text");
}

/* true if a step before `at` has the same id */
static int class_step_before(const struct api_value *steps, const struct api_value *at,
                             const char *id) {
    struct api_value step = api_value_first(steps);
    assert(at->index >= 0);
    for (; step.index < at->index; step = api_value_next(&step)) {
        const char *text = api_value_text(API_MEMBER(&step, "id"));
        if (text && !strcmp(text, id)) return 1;
    }
    return 0;
}

static void class_step(const struct api_value *steps, const struct api_value *step,
                       struct class_reading *reading) {
    static const char *const fields[] = {"id",   "title", "text",         "scene", "question",
                                         "hint", "needs", "hidden_until", NULL},
                             *const needs[] = {"nothing", "answer", "right", NULL};
    struct api_problem *problem = reading->problem;
    if (!api_field_object(step, NULL, problem)) return;
    struct api_value id = api_value_member(step, "id"),
                     question = api_value_member(step, "question"),
                     need = api_value_member(step, "needs"),
                     until = api_value_member(step, "hidden_until");
    int word = 0;
    (void)api_value_only(step, fields, problem);
    if (class_id(&id, 1, problem) && class_step_before(steps, step, api_value_text(&id)))
        api_value_fault(&id, problem, API_CODE_DUPLICATE "is already the id of an earlier step");
    class_text(API_MEMBER(step, "title"), 0, CLASS_TITLE, 1, problem);
    class_text(API_MEMBER(step, "text"), 0, CLASS_TEXT, 0, problem);
    class_text(API_MEMBER(step, "hint"), 0, CLASS_TEXT, 0, problem);
    class_scene(API_MEMBER(step, "scene"), reading);
    class_step_question(&question, reading);
    (void)api_field_word(&need, needs, &word, problem);
    if (word && api_value_kind(&question) == API_MISSING)
        api_value_fault(&need, problem,
                        API_CODE_NOT_APPLICABLE "is only for a step with a question");
    if (class_id(&until, 0, problem) && !class_step_before(steps, step, api_value_text(&until)))
        api_value_fault(&until, problem, API_CODE_UNKNOWN_NAME "must be the id of an earlier step");
}

static void class_worksheet(const struct api_value *root, struct class_reading *reading) {
    static const char *const fields[] = {"title", "language", "steps", "closed", "feedback", NULL},
                             *const when[] = {"at_once", "at_end", "never", NULL};
    struct api_problem *problem = reading->problem;
    struct api_value steps = api_value_member(root, "steps");
    int count = api_value_count(&steps), shut = 0, word;
    (void)api_value_only(root, fields, problem);
    class_text(API_MEMBER(root, "title"), 1, CLASS_TITLE, 1, problem);
    class_text(API_MEMBER(root, "language"), 0, CLASS_UNIT, 1, problem);
    (void)api_field_truth(API_MEMBER(root, "closed"), &shut, problem);
    (void)api_field_word(API_MEMBER(root, "feedback"), when, &word, problem);
    reading->facts->flag = shut ? FLAG_CLOSED : 0;
    if (api_value_kind(&steps) != API_ARRAY || count < 1 || count > API_CLASS_STEPS) {
        api_value_fault(&steps, problem, API_CODE_WRONG_COUNT "must be a list of 1 to %d steps",
                        API_CLASS_STEPS);
        return;
    }
    API_VALUE_EACH (step, api_value_first(&steps)) class_step(&steps, &step, reading);
}

static void class_tries(const struct api_value *tries, struct api_problem *problem) {
    if (api_value_kind(tries) == API_MISSING) return;
    if (api_value_kind(tries) != API_ARRAY || api_value_count(tries) > CLASS_TRIES) {
        api_value_fault(tries, problem,
                        API_CODE_WRONG_COUNT "must be a list of at most %d earlier answers",
                        CLASS_TRIES);
        return;
    }
    API_VALUE_EACH (item, api_value_first(tries)) (void)class_value(&item, problem);
}

static void class_handin(const struct api_value *root, struct class_reading *reading) {
    static const char *const fields[] = {"answers", "done", NULL}, *const parts[] = {
                                                                       "step", "value", "scene",
                                                                       "tries", NULL};
    struct api_problem *problem = reading->problem;
    struct api_value answers = api_value_member(root, "answers");
    int truth;
    (void)api_value_only(root, fields, problem);
    (void)api_field_truth(API_MEMBER(root, "done"), &truth, problem);
    if (api_value_kind(&answers) != API_ARRAY || api_value_count(&answers) > API_CLASS_STEPS) {
        api_value_fault(&answers, problem,
                        API_CODE_WRONG_COUNT "must be a list of at most %d answers",
                        API_CLASS_STEPS);
        return;
    }
    API_VALUE_EACH (answer, api_value_first(&answers)) {
        if (!api_field_object(&answer, parts, problem)) continue;
        (void)class_id(API_MEMBER(&answer, "step"), 1, problem);
        (void)class_value(API_MEMBER(&answer, "value"), problem);
        class_tries(API_MEMBER(&answer, "tries"), problem);
        class_scene(API_MEMBER(&answer, "scene"), reading);
    }
}

/* name, most bytes and reader of each kind */
static const struct {
    const char *name;
    size_t most;
    void (*read)(const struct api_value *root, struct class_reading *reading);
} class_table[API_CLASS_KINDS] = {
    [API_CLASS_ROOM] = {"room", 1024, class_room},
    [API_CLASS_PUPIL] = {"pupil", 1024, class_pupil},
    [API_CLASS_STAGE] = {"stage", 32 * 1024, class_stage},
    [API_CLASS_OWN_STAGE] = {"stage", 8 * 1024, class_own_stage},
    [API_CLASS_QUESTION] = {"question", 32 * 1024, class_question},
    [API_CLASS_SOLUTION] = {"solution", 20 * 1024, class_solution},
    [API_CLASS_WORKSHEET] = {"worksheet", 64 * 1024, class_worksheet},
    [API_CLASS_ANSWER] = {"answer", 20 * 1024, class_answer},
    [API_CLASS_HANDIN] = {"handin", 32 * 1024, class_handin},
};

/* --- a body --- */

static void class_large(enum api_class_kind kind, size_t bytes, struct api_problem *problem) {
    api_problem_set(problem, 413,
                    API_TYPE_LIMIT "a %s has at most %zu bytes without blanks, got %zu",
                    class_table[kind].name, class_table[kind].most, bytes);
}

static enum pend_status class_make(const struct api_request *request, enum api_class_kind kind,
                                   struct class_reading *reading, struct api_buffer *value) {
    struct api_json *document = NULL;
    enum pend_status status =
        api_json_new(&document, request->body ? request->body : "", request->body_bytes,
                     (int)reading->limits->depth, reading->problem);
    if (status == PEND_OK) {
        struct api_value root = api_json_root(document);
        if (api_field_object(&root, NULL, reading->problem)) class_table[kind].read(&root, reading);
        status = reading->status;
        if (status == PEND_OK && reading->problem->status) status = PEND_INVALID;
        if (status == PEND_OK) status = api_canonical_write(&root, value);
    }
    if (status == PEND_OK && value->bytes > class_table[kind].most) {
        class_large(kind, value->bytes, reading->problem);
        status = PEND_INVALID;
    }
    api_json_free(&document);
    return status;
}

int api_class_read(const struct api_request *request, const struct api_limits *limits,
                   enum api_class_kind kind, struct api_class_facts *facts,
                   struct api_buffer *value, struct api_buffer *out) {
    struct api_request checked = *request;
    struct api_problem problem;
    struct class_reading reading = {.limits = limits, .facts = facts, .problem = &problem};
    enum pend_status status = PEND_INVALID;
    assert((unsigned)kind < API_CLASS_KINDS);
    *facts = (struct api_class_facts){.hours = 24};
    api_problem_init(&problem);
    checked.op = API_OP_TREES;
    api_request_check(&checked, limits, &problem);
    if (!api_negotiate_format(request->accept, 0)) api_negotiate_refuse(&problem, 0);
    if (!problem.status && request->body_bytes > CLASS_SPARE * class_table[kind].most)
        class_large(kind, request->body_bytes, &problem);
    if (!problem.status) status = class_make(&checked, kind, &reading, value);
    return api_problem_end(&problem, status, out);
}

/* --- writing --- */

enum pend_status api_class_item_write(const struct api_class_item *item, struct api_buffer *out) {
    assert(*item->name && item->version > 0 && (item->value || !item->bytes));
    PEND_TRY(api_out_comma(out));
    PEND_TRY(api_buffer_text(out, "{"));
    PEND_TRY(api_out_text(out, "name", item->name));
    PEND_TRY(api_out_whole(out, "version", (long)item->version));
    PEND_TRY(api_job_time(out, "changed", item->changed));
    PEND_TRY(api_out_key(out, "value"));
    if (item->bytes)
        PEND_TRY(api_buffer_add(out, item->value, item->bytes));
    else
        PEND_TRY(api_buffer_text(out, "null"));
    return api_buffer_text(out, "}");
}

enum pend_status api_class_room_write(const struct api_class_room *room, struct api_buffer *out) {
    char path[64] = "/v1/classes/";
    assert(*room->code && *room->role && room->pupil >= 0 && room->ends >= room->created);
    strncat(path, room->code, sizeof path - sizeof "/v1/classes/");
    PEND_TRY(api_buffer_text(out, "{"));
    PEND_TRY(api_out_text(out, "code", room->code));
    PEND_TRY(api_out_text(out, "role", room->role));
    if (room->pupil) PEND_TRY(api_out_whole(out, "pupil", room->pupil));
    if (room->token) PEND_TRY(api_out_text(out, "token", room->token));
    PEND_TRY(api_job_time(out, "created", room->created));
    PEND_TRY(api_job_time(out, "ends", room->ends));
    if (room->empty_ends) PEND_TRY(api_job_time(out, "empty_ends", room->empty_ends));
    PEND_TRY(api_out_whole(out, "version", (long)room->version));
    PEND_TRY(api_out_whole(out, "pupils", room->pupils));
    PEND_TRY(api_out_key(out, "open"));
    PEND_TRY(api_buffer_text(out, room->shut ? "false" : "true"));
    if (room->source) PEND_TRY(api_out_text(out, "address_mark", room->source));
    PEND_TRY(api_out_open(out, "links", '{'));
    PEND_TRY(api_out_text(out, "self", path));
    return api_buffer_text(out, "}");
}
