/* Tests of api/call/results: archives of more rows than are stored, from parts that are read again.
 * Its other functions are tested with the operations, by test_part.c. */
#include "api/call/results.h"

#include <string.h>

#include "api/encode/encode_raw.h"
#include "tests/harness/test.h"

enum { ROWS = 8400, WIDTH = 1024, SOME = 8 };

/* parts that are generated while they are read: row i has i, and numbers derived from it */
struct made {
    long row;
    int told, again; /* whether the statistics were written; how often the parts were read again */
    struct api_table table;
    struct api_buffer figures;
};

static enum pend_status made_fetch(void *context, void *data, size_t cap, size_t *bytes,
                                   struct pend_error *error) {
    struct made *made = context;
    (void)error;
    *bytes = 0;
    if (made->row == ROWS && made->told) return PEND_OK;
    if (made->row == ROWS) {
        memcpy(data, made->figures.data, *bytes = made->figures.bytes);
        made->told = 1;
        return PEND_OK;
    }
    size_t row = (size_t)api_table_numbers(&made->table, 0) * sizeof(double);
    char *at = (char *)data + API_RAW_HEAD;
    long rows = ROWS - made->row < SOME ? ROWS - made->row : SOME;
    CHECK(API_RAW_HEAD + (size_t)rows * row <= cap);
    for (long i = 0; i < rows; i++, made->row++)
        for (size_t k = 0; k < row / sizeof(double); k++, at += sizeof(double)) {
            double x = (double)made->row + (double)k * 0x1p-20;
            memcpy(at, &x, sizeof x);
        }
    *bytes = API_RAW_HEAD + (size_t)rows * row;
    api_raw_head_put(data, API_RAW_ROWS, *bytes - API_RAW_HEAD);
    return PEND_OK;
}

static void made_again(void *context) {
    struct made *made = context;
    made->row = made->told = 0;
    made->again++;
}

/* the digest of the whole answer (FNV-1a), and its bytes */
static size_t digest_of(struct made *made, int turns, unsigned long long *digest) {
    const struct api_source source = {
        .fetch = made_fetch, .again = turns ? made_again : NULL, .context = made};
    OWN(api_results, free) *results = NULL;
    OWN(api_buffer, clear) out;
    size_t bytes = 0, most = 0;
    int all = 0, done = 0;
    *digest = 14695981039346656037U;
    api_buffer_init(&out, 1 << 22);
    enum pend_status status =
        api_results_new(&results, &api_format_npz, &made->table, 0, 0, &source, &out, NULL);
    while (status == PEND_OK && !done) {
        if (!all) {
            status = api_results_fetch(results, &source, &out, &all, NULL);
        } else {
            status = api_results_end(results, &out, &done);
            all = status != PEND_OK || !api_results_again(results, &source);
        }
        for (size_t i = 0; i < out.bytes; i++)
            *digest = (*digest ^ (unsigned char)out.data[i]) * 1099511628211U;
        bytes += out.bytes;
        most = out.bytes > most ? out.bytes : most;
        out.bytes = 0;
    }
    CHECK(status == PEND_OK && done);
    CHECK_SAYING(most < 1 << 18, "%zu bytes at once", most);
    return bytes;
}

TEST(an_archive_of_more_rows_than_are_kept_is_read_again_and_has_the_same_bytes) {
    struct made made = {.table = {.rows = ROWS}};
    struct api_stats stats = {0};
    struct api_writer *raw;
    unsigned long long kept, turned;
    int done = 0;
    api_table_add(&made.table, "t", NULL, 0);
    api_table_add(&made.table, "phi", NULL, WIDTH);
    api_table_add(&made.table, "phid", NULL, WIDTH);
    CHECK(api_format_turns(&api_format_npz, &made.table));
    api_stats_whole(&stats, "steps", 12345);
    api_buffer_init(&made.figures, 1 << 12);
    struct api_table none = {.rows = 0};
    api_table_add(&none, "t", NULL, 0);
    REQUIRE(api_writer_new(&raw, &api_format_raw, &none, &made.figures) == PEND_OK);
    while (!done && CHECK(api_writer_finish(raw, &stats, &made.figures, &done) == PEND_OK)) {
    }
    api_writer_free(&raw);
    size_t bytes = digest_of(&made, 0, &kept);
    CHECK_INT(made.again, 0);
    made.row = made.told = 0;
    CHECK_INT((long long)digest_of(&made, 1, &turned), (long long)bytes);
    /* phi is stored beside t, phid is not */
    CHECK_INT(made.again, 1);
    CHECK_SAYING(kept == turned, "%llx is not %llx", turned, kept);
    api_buffer_clear(&made.figures);
}
