/* Tests of api/call/relay and api/call/relay_host: what is computed elsewhere is what is computed
 * here, and what is told from there is not believed. The other side is in this process. */
#include "api/call/relay_host.h"

#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "api/call/part.h"
#include "tests/harness/requests.h"
#include "tests/harness/test.h"

enum { MOST_BYTES = 1 << 28, NEVER = 1 << 30 };

/* The other side, and what is wrong with the way to it. */
struct there {
    struct api_relay_host *host;
    struct api_buffer message;
    int asked, fails_at;                                     /* questions; this one is lost */
    void (*lie)(struct api_relay_told *told, unsigned seed); /* NULL = it tells the truth */
    unsigned seed;
};

/* a clock that stands still, so that the seconds of computation are the same */
static double there_now(void *context) {
    (void)context;
    return 1;
}

/* the question as one message, as a process would send it */
static void there_write(struct there *there, const struct api_relay_ask *ask) {
    struct api_relay_head head;
    const void *texts[API_RELAY_TEXTS];
    api_relay_put(ask, &head, texts);
    there->message.bytes = 0;
    CHECK(api_buffer_add(&there->message, &head, sizeof head) == PEND_OK);
    for (int i = 0; i < API_RELAY_TEXTS; i++) {
        if (!head.bytes[i]) continue;
        CHECK(api_buffer_add(&there->message, texts[i], (size_t)head.bytes[i] - 1) == PEND_OK);
        CHECK(api_buffer_add(&there->message, "", 1) == PEND_OK);
    }
}

static enum pend_status there_ask(void *context, const struct api_relay_ask *ask,
                                  struct api_relay_told *told, struct api_buffer *out,
                                  struct api_buffer *more, struct pend_error *error) {
    struct there *there = context;
    struct api_buffer *bytes, *others;
    if (there->asked++ >= there->fails_at) {
        CHECK(api_buffer_text(out, "half an ans") == PEND_OK);
        return pend_fail(error, PEND_BUG, -1, 0, "the way is lost");
    }
    there_write(there, ask);
    if (!CHECK(api_relay_host_answer(there->host, there->message.data, there->message.bytes, told,
                                     &bytes, &others)))
        return pend_fail(error, PEND_BUG, -1, 0, "there was no answer");
    if (bytes) PEND_TRY(api_buffer_add(out, bytes->data, bytes->bytes));
    if (others && more) PEND_TRY(api_buffer_add(more, others->data, others->bytes));
    if (there->lie) there->lie(told, there->seed);
    return PEND_OK;
}

static struct api_relay there_begin(struct there *there) {
    *there = (struct there){.fails_at = NEVER};
    api_buffer_init(&there->message, MOST_BYTES);
    CHECK(api_relay_host_new(&there->host, there_now) == PEND_OK);
    return (struct api_relay){there_ask, there};
}

static void there_end(struct there *there) {
    api_relay_host_free(&there->host);
    api_buffer_clear(&there->message);
}

/* An answer with all that a server reads of it. */
struct whole {
    struct api_answer answer;
    struct api_buffer out;
    enum api_progress progress;
    long steps;
    double cost;
    int foresees, streams;
    char etag[API_DIGEST_BYTES], columns[API_COLUMNS_TEXT], file_name[40];
    struct api_remarks remarks;
};

static struct api_request request_of(int i) {
    const struct test_request *one = &test_requests[i];
    return (struct api_request){.op = one->op,
                                .argument = one->op == API_OP_PRESET ? "double" : NULL,
                                .content_type = "application/json",
                                .accept = one->accept,
                                .body = one->body,
                                .body_bytes = one->body ? strlen(one->body) : 0};
}

/* computes a request, here or there; promised: its head is sent as soon as that may be */
static void compute(const struct api_request *request, const struct api_relay *relay, int promised,
                    struct whole *whole) {
    struct api_limits limits;
    struct api_call *call;
    memset(whole, 0, sizeof *whole);
    api_limits_init(&limits);
    api_buffer_init(&whole->out, MOST_BYTES);
    if (!CHECK(api_call_new(&call, &limits) == PEND_OK)) return;
    if (relay) CHECK(api_call_relay(call, relay) == PEND_OK);
    whole->progress = api_call_open(call, request, &whole->out);
    whole->cost = api_call_cost(call);
    whole->streams = api_call_streams(call);
    if (whole->progress == API_MORE) whole->foresees = api_call_foresees(call);
    if (whole->progress == API_MORE) CHECK(api_call_bytes(call) > 0);
    while (whole->progress == API_MORE) {
        if (promised && api_call_streams(call)) api_call_promise(call);
        whole->progress = api_call_run(call, &whole->out);
    }
    whole->steps = api_call_steps(call);
    whole->answer = api_call_answer(call);
    if (whole->answer.etag) strcpy(whole->etag, whole->answer.etag);
    if (whole->answer.columns) strcpy(whole->columns, whole->answer.columns);
    if (whole->answer.file_name) strcpy(whole->file_name, whole->answer.file_name);
    if (whole->answer.remarks) whole->remarks = *whole->answer.remarks;
    api_call_free(&call);
}

static void check_same(int i, const struct whole *here, const struct whole *there) {
    CHECK_SAYING(there->out.bytes == here->out.bytes &&
                     !memcmp(there->out.data, here->out.data, here->out.bytes),
                 "request %d: %zu bytes there, %zu here: %.*s", i, there->out.bytes,
                 here->out.bytes, (int)there->out.bytes, there->out.data);
    CHECK_INT(there->answer.status, here->answer.status);
    CHECK_INT(there->progress, here->progress);
    CHECK_TEXT(there->answer.media_type, here->answer.media_type);
    CHECK_TEXT(there->etag, here->etag);
    CHECK_TEXT(there->columns, here->columns);
    CHECK_TEXT(there->file_name, here->file_name);
    CHECK_INT(there->answer.length, here->answer.length);
    CHECK_INT(there->answer.has_remarks, here->answer.has_remarks);
    CHECK_INT(there->steps, here->steps);
    CHECK_INT(there->foresees, here->foresees);
    CHECK_INT(there->streams, here->streams);
    CHECK(there->cost == here->cost);
    CHECK_INT(there->remarks.count, here->remarks.count);
    for (int f = 0; f < here->remarks.count && f < there->remarks.count; f++) {
        CHECK_TEXT(there->remarks.field[f].name, here->remarks.field[f].name);
        CHECK_TEXT(there->remarks.field[f].value, here->remarks.field[f].value);
    }
}

TEST(what_is_computed_elsewhere_is_what_is_computed_here) {
    struct there other;
    struct api_relay relay = there_begin(&other);
    struct whole here, there;
    int streams = 0, refused = 0;
    for (int i = 0; i < TEST_REQUESTS; i++)
        for (int promised = 0; promised < 2; promised++) {
            struct api_request request = request_of(i);
            compute(&request, NULL, promised, &here);
            compute(&request, &relay, promised, &there);
            check_same(i, &here, &there);
            streams += here.streams;
            refused += here.answer.status == 422;
            api_buffer_clear(&here.out);
            api_buffer_clear(&there.out);
        }
    CHECK(streams > 20 && refused == 2);
    there_end(&other);
}

/* --- jobs --- */

static const char chain[] =
    "{\"pendulum\":{\"length\":[2,1.5,0.75],\"mass\":[1,1,1],\"parent\":[0,1,1]},\"initial\":{"
    "\"phi\":[0.5,1,-1]},\"times\":{\"stop\":3,\"step\":0.01},\"output\":[\"phi\",\"energy\"]}";

static const struct api_request chained = {.op = API_OP_TRAJECTORIES,
                                           .content_type = "application/json",
                                           .body = chain,
                                           .body_bytes = sizeof chain - 1};

/* one part; returns its status */
static enum pend_status compute_part(const struct api_request *request,
                                     const struct api_relay *relay, long number, long parts,
                                     struct api_buffer *carried, struct api_buffer *kept,
                                     struct pend_error *error) {
    struct api_limits limits;
    struct api_part *part;
    int done = 0;
    api_limits_init(&limits);
    const void *start = carried->bytes ? carried->data : NULL;
    enum pend_status status = relay ? api_part_relay(&part, relay, request, &limits, number, parts,
                                                     start, carried->bytes, error)
                                    : api_part_new(&part, request, &limits, number, parts, error);
    if (status == PEND_OK && !relay) api_part_clock(part, there_now, NULL);
    if (status == PEND_OK && !relay && start)
        status = api_part_resume(part, start, carried->bytes, error);
    carried->bytes = 0;
    while (status == PEND_OK && !done) status = api_part_run(part, kept, &done, error);
    if (status == PEND_OK) status = api_part_carry(part, carried);
    if (part) CHECK(api_part_bytes(part) > 0);
    api_part_free(&part);
    return status;
}

TEST(a_part_that_is_computed_elsewhere_is_the_same_and_hands_on_the_same) {
    enum { PARTS = 4 };
    struct there other;
    struct api_relay relay = there_begin(&other);
    struct api_buffer kept[2], carried[2];
    struct pend_error error = {.text = ""};
    for (int i = 0; i < 2; i++) {
        api_buffer_init(&kept[i], MOST_BYTES);
        api_buffer_init(&carried[i], MOST_BYTES);
    }
    for (long number = 0; number < PARTS; number++) {
        for (int i = 0; i < 2; i++)
            CHECK_SAYING(compute_part(&chained, i ? &relay : NULL, number, PARTS, &carried[i],
                                      &kept[i], &error) == PEND_OK,
                         "%s", error.text);
        CHECK(carried[0].bytes == carried[1].bytes && !!carried[0].bytes == (number + 1 < PARTS));
        CHECK(!carried[0].bytes || !memcmp(carried[0].data, carried[1].data, carried[0].bytes));
        if (number == 1) carried[1].data[5] ^= 1;
        if (number != 1) continue;
        /* a checkpoint that was damaged is refused there too */
        struct api_buffer none;
        api_buffer_init(&none, MOST_BYTES);
        CHECK(compute_part(&chained, &relay, 2, PARTS, &carried[1], &none, &error) == PEND_INVALID);
        CHECK_SAYING(strstr(error.text, "damaged") != NULL, "%s", error.text);
        CHECK(api_buffer_add(&carried[1], carried[0].data, carried[0].bytes) == PEND_OK);
        api_buffer_clear(&none);
    }
    CHECK(kept[0].bytes == kept[1].bytes && kept[0].bytes > 1000);
    CHECK(!memcmp(kept[0].data, kept[1].data, kept[0].bytes));
    for (int i = 0; i < 2; i++) {
        api_buffer_clear(&kept[i]);
        api_buffer_clear(&carried[i]);
    }
    there_end(&other);
}

TEST(a_plan_that_is_made_elsewhere_is_the_same) {
    struct there other;
    struct api_relay relay = there_begin(&other);
    struct api_limits limits;
    struct api_plan here, there;
    struct api_buffer body[2], out[2];
    api_limits_init(&limits);
    for (int i = 0; i < 2; i++) {
        api_buffer_init(&body[i], MOST_BYTES);
        api_buffer_init(&out[i], MOST_BYTES);
    }
    for (int i = 0; i < TEST_REQUESTS; i++) {
        struct api_request request = request_of(i);
        int status = api_plan_read(&here, &request, &limits, 0.001, &body[0], &out[0]);
        CHECK_INT(api_plan_relay(&there, &relay, &request, &limits, 0.001, &body[1], &out[1]),
                  status);
        CHECK(here.parts == there.parts && here.chained == there.chained &&
              here.cost == there.cost && here.bytes == there.bytes && here.kept == there.kept);
        if (!status) CHECK_TEXT(there.digest, here.digest);
    }
    CHECK(body[0].bytes == body[1].bytes && !memcmp(body[0].data, body[1].data, body[0].bytes));
    CHECK(out[0].bytes == out[1].bytes && !memcmp(out[0].data, out[1].data, out[0].bytes));
    other.fails_at = 0;
    out[1].bytes = 0;
    CHECK_INT(api_plan_relay(&there, &relay, &chained, &limits, 1, &body[1], &out[1]), 500);
    CHECK(body[0].bytes == body[1].bytes && there.parts == 1);
    CHECK(out[1].bytes > 20 && !memcmp(out[1].data, "{\"type\"", 7));
    for (int i = 0; i < 2; i++) {
        api_buffer_clear(&body[i]);
        api_buffer_clear(&out[i]);
    }
    there_end(&other);
}

/* --- a way that is lost, and lies --- */

TEST(a_way_that_is_lost_is_one_problem_or_ends_the_stream) {
    for (int promised = 0; promised < 2; promised++)
        for (int at = 0; at < 3; at++) {
            struct there other;
            struct api_relay relay = there_begin(&other);
            struct api_request request = chained;
            struct whole whole;
            other.fails_at = at;
            request.accept = "text/csv";
            compute(&request, &relay, promised, &whole);
            CHECK_INT(other.asked, at + 1);
            if (promised && at) {
                CHECK_INT(whole.progress, API_BROKEN);
            } else {
                CHECK_INT(whole.answer.status, 500);
                CHECK_TEXT(whole.answer.media_type, "application/problem+json");
                CHECK(whole.out.bytes > 20 && !memcmp(whole.out.data, "{\"type\"", 7));
                CHECK(api_buffer_add(&whole.out, "", 1) == PEND_OK &&
                      strstr(whole.out.data, "the way is lost"));
            }
            CHECK(!memmem(whole.out.data, whole.out.bytes, "half an ans", 11));
            api_buffer_clear(&whole.out);
            there_end(&other);
        }
    struct there other;
    struct api_relay relay = there_begin(&other);
    struct pend_error error;
    struct api_buffer kept, carried;
    api_buffer_init(&kept, MOST_BYTES);
    api_buffer_init(&carried, MOST_BYTES);
    other.fails_at = 1;
    CHECK(compute_part(&chained, &relay, 0, 3, &carried, &kept, &error) == PEND_BUG);
    CHECK_TEXT(error.text, "the way is lost");
    api_buffer_clear(&kept);
    there_end(&other);
}

/* what somebody could tell who has taken over the other side */
static void lie_one(struct api_relay_told *told, unsigned seed) {
    switch (seed) {
    case 0:
        told->progress = API_WAITS;
        break;
    case 1:
        told->progress = -1;
        break;
    case 2:
        told->status = 100;
        break;
    case 3:
        memset(told->digest, 'a', sizeof told->digest);
        break;
    case 4:
        strcpy(told->digest, "\"\r\nX-Evil: 1");
        break;
    case 5:
        memset(told->columns, 'x', sizeof told->columns);
        break;
    case 6:
        strcpy(told->columns, "a\r\nSet-Cookie: b");
        break;
    case 7:
        told->remarks.count = API_REMARKS_FIELDS + 1;
        break;
    case 8:
        told->remarks.count = -1;
        break;
    case 9:
        told->remarks.count = 1, told->named[0] = 99;
        break;
    case 10:
        told->remarks.count = 1, told->named[0] = -1;
        break;
    case 11:
        told->remarks.count = 1, told->named[0] = 0;
        memset(told->remarks.field[0].value, 'y', API_REMARKS_TEXT);
        break;
    case 12:
        told->cost = NAN;
        break;
    case 13:
        told->bytes = -1;
        break;
    case 14:
        told->answer = INFINITY;
        break;
    case 15:
        told->length = -2;
        break;
    case 16:
        told->steps = -1;
        break;
    case 17:
        strcpy(told->text, "a\nb");
        break;
    case 18:
        strcpy(told->text, "a\xff");
        break;
    default:
        memset(told->text, 'z', sizeof told->text);
        break;
    }
}
enum { LIES = 20 };

static unsigned long long lie_random = 5;

/* bits of it at random: what is believed then must still be harmless, which sanitizers watch */
static void lie_at_random(struct api_relay_told *told, unsigned seed) {
    unsigned char *bytes = (unsigned char *)told;
    for (unsigned i = 0; i <= seed % 4; i++)
        bytes[test_random_int(&lie_random, (int)sizeof *told)] ^=
            (unsigned char)(1 << test_random_int(&lie_random, 8));
}

TEST(what_cannot_be_is_not_believed) {
    struct there other;
    struct api_relay relay = there_begin(&other);
    struct whole whole;
    struct api_request request = chained;
    request.accept = "text/csv";
    other.lie = lie_one;
    for (other.seed = 0; other.seed < LIES; other.seed++) {
        compute(&request, &relay, 0, &whole);
        CHECK_SAYING(whole.answer.status == 500, "lie %u: %d", other.seed, whole.answer.status);
        CHECK(memmem(whole.out.data, whole.out.bytes, "told what cannot be", 19));
        api_buffer_clear(&whole.out);
    }
    other.lie = lie_at_random;
    for (other.seed = 0; other.seed < 200; other.seed++) {
        compute(&request, &relay, (int)(other.seed & 1), &whole);
        CHECK(whole.progress == API_DONE || whole.progress == API_BROKEN);
        CHECK(strlen(whole.columns) < sizeof whole.columns);
        api_buffer_clear(&whole.out);
    }
    there_end(&other);
}

TEST(a_plan_that_cannot_be_is_not_believed) {
    struct api_relay_told told = {.length = -1, .plan.parts = 1};
    /* a refusal has no digest, and what is to be kept has one */
    CHECK(!api_relay_believable(&told, API_RELAY_PLAN));
    told.status = 422;
    CHECK(api_relay_believable(&told, API_RELAY_PLAN));
    told.status = 0;
    memset(told.digest, 'a', API_DIGEST_BYTES - 1);
    CHECK(api_relay_believable(&told, API_RELAY_PLAN));
    told.plan.parts = 0;
    CHECK(!api_relay_believable(&told, API_RELAY_PLAN));
    told.plan.parts = LONG_MAX;
    CHECK(!api_relay_believable(&told, API_RELAY_PLAN));
}

/* bytes that are no question: neither end of the way goes wrong over them */
TEST(a_question_that_makes_no_sense_is_not_answered) {
    struct there other;
    (void)there_begin(&other);
    const struct api_relay_ask ask = {
        .kind = API_RELAY_OPEN, .request = &chained, .limits = &(struct api_limits){0}};
    struct api_relay_told told;
    struct api_buffer *out, *more;
    struct api_relay_head head;
    there_write(&other, &ask);
    for (size_t bytes = 0; bytes < other.message.bytes; bytes += bytes < sizeof head ? 7 : 1) {
        /* as a copy of just these bytes, so that a sanitizer sees what is read behind them */
        char *cut = malloc(bytes + !bytes);
        if (!CHECK(cut != NULL)) break;
        memcpy(cut, other.message.data, bytes);
        CHECK_INT(api_relay_host_answer(other.host, cut, bytes, &told, &out, &more), 0);
        free(cut);
    }
    for (int i = 0; i < 8; i++) {
        there_write(&other, &ask);
        memcpy(&head, other.message.data, sizeof head);
        if (i == 0) head.kind = 99;
        if (i == 1) head.kind = -1;
        if (i == 2) head.op = API_OP_COUNT;
        if (i == 3) head.op = -1;
        if (i == 4) head.bytes[4] = ~0ULL;
        if (i == 5) head.bytes[4]--;
        if (i == 6) head.bytes[0] = 1;
        if (i == 7) head.number = 3;
        memcpy(other.message.data, &head, sizeof head);
        CHECK_SAYING(!api_relay_host_answer(other.host, other.message.data, other.message.bytes,
                                            &told, &out, &more),
                     "question %d", i);
    }
    /* nothing was begun */
    memset(&head, 0, sizeof head);
    head.kind = API_RELAY_RUN;
    CHECK_INT(api_relay_host_answer(other.host, &head, sizeof head, &told, &out, &more), 0);
    head.kind = API_RELAY_PART;
    CHECK_INT(api_relay_host_answer(other.host, &head, sizeof head, &told, &out, &more), 0);
    there_end(&other);
}
