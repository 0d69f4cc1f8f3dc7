#include "tests/fuzz/fuzz.h"

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

#ifndef FUZZER
#include "tests/harness/test.h"
#endif

enum { TABLES = 16 };

static struct {
    const struct fuzz_reader *reader;
    int count;
} tables[TABLES];
static int tables_count;

void fuzz_register(const struct fuzz_reader reader[], int count) {
    if (tables_count == TABLES) abort();
    tables[tables_count].reader = reader;
    tables[tables_count++].count = count;
}

int fuzz_show(const struct fuzz_reader *reader, const void *data, size_t bytes) {
    static char *wall;
    if (!wall) {
        wall =
            mmap(NULL, 2 * FUZZ_ROOM, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
        if (wall == MAP_FAILED || mprotect(wall + FUZZ_ROOM, FUZZ_ROOM, PROT_NONE)) abort();
    }
    if (bytes >= FUZZ_ROOM) return 1;
    char *text = wall + FUZZ_ROOM - bytes - !reader->bare;
    if (bytes) memcpy(text, data, bytes);
    if (!reader->bare) text[bytes] = 0;
    return reader->read(text, bytes);
}

#ifdef FUZZER

/* --- libFuzzer's entry points; FUZZ_READER selects the reader, "" lists them; FUZZ_SEEDS names a
 * directory for its seeds --- */

static const struct fuzz_reader *chosen;

int LLVMFuzzerInitialize(int *argc, char ***argv);
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t bytes);

static void lay_seeds(const char *directory) {
    for (int i = 0; i < FUZZ_SEEDS && chosen->seed[i]; i++) {
        char path[400];
        snprintf(path, sizeof path, "%s/seed%d", directory, i);
        FILE *file = fopen(path, "wb");
        if (!file || fputs(chosen->seed[i], file) < 0 || fclose(file)) abort();
    }
}

int LLVMFuzzerInitialize(int *argc, char ***argv) {
    const char *name = getenv("FUZZ_READER");
    (void)argc, (void)argv;
    for (int t = 0; t < tables_count; t++)
        for (int i = 0; i < tables[t].count; i++) {
            const struct fuzz_reader *reader = &tables[t].reader[i];
            if (!name || !*name)
                puts(reader->name);
            else if (!strcmp(name, reader->name))
                chosen = reader;
        }
    if (chosen && getenv("FUZZ_SEEDS")) lay_seeds(getenv("FUZZ_SEEDS"));
    if (chosen) return 0;
    if (name && *name) fprintf(stderr, "there is no reader %s\n", name);
    exit(name && *name);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t bytes) {
    if (!fuzz_show(chosen, data, bytes)) abort();
    return 0;
}

#else

/* --- the test --- */

/* decodes one line of a corpus in place: \xNN is a backslash or an unprintable byte; returns the
 * length */
static size_t decode(char *line) {
    size_t bytes = 0;
    for (const char *at = line; *at && *at != '\n'; at++) {
        unsigned byte = (unsigned char)*at;
        if (byte == '\\' && sscanf(at, "\\x%2x", &byte) == 1) at += 3;
        line[bytes++] = (char)byte;
    }
    return bytes;
}

static void replay(const struct fuzz_reader *reader) {
    char path[200], *line = NULL;
    size_t room = 0;
    int lines = 0;
    snprintf(path, sizeof path, "tests/fuzz/corpus/%s", reader->name);
    FILE *file = fopen(path, "r");
    if (!CHECK_SAYING(file != NULL, "%s has no corpus", reader->name)) return;
    while (getline(&line, &room, file) > 0) {
        lines++;
        size_t bytes = decode(line);
        CHECK_SAYING(fuzz_show(reader, line, bytes), "line %d of %s", lines, path);
    }
    CHECK_SAYING(lines > 0, "%s is empty", path);
    free(line);
    fclose(file);
}

TEST(fuzz_corpora_are_replayed) {
    for (int t = 0; t < tables_count; t++)
        for (int i = 0; i < tables[t].count; i++) replay(&tables[t].reader[i]);
}

/* changes a text in one place */
static size_t mutate(char *text, size_t bytes, unsigned long long *state) {
    static const char *const words[] = {",",   ";",    "=",      "\n",  " ", "\"",
                                        "[",   "]:",   "q=",     "-",   "0", "99999999999999999999",
                                        "/33", "for=", "bytes=", "\xff"};
    size_t at = bytes ? (size_t)test_random_int(state, (int)bytes) : 0;
    const char *word = words[test_random_int(state, sizeof words / sizeof *words)];
    size_t more = strlen(word);
    switch (test_random_int(state, 4)) {
    case 0:
        if (bytes) text[at] = (char)test_random_int(state, 256);
        return bytes;
    case 1:
        return at;
    case 2:
        if (!bytes) return 0;
        memmove(text + at, text + at + 1, bytes - at - 1);
        return bytes - 1;
    default:
        memmove(text + at + more, text + at, bytes - at);
        memcpy(text + at, word, more);
        return bytes + more;
    }
}

/* FUZZ_RUNS (4000) mutations of each reader's seeds, from FUZZ_SEED (1) */
static void vary(const struct fuzz_reader *reader) {
    static char text[2 * FUZZ_ROOM];
    const char *runs_text = getenv("FUZZ_RUNS"), *seed_text = getenv("FUZZ_SEED");
    long runs = runs_text ? atol(runs_text) : 4000;
    unsigned long long state = seed_text ? strtoull(seed_text, NULL, 10) : 1;
    int seeds = 0;
    while (seeds < FUZZ_SEEDS && reader->seed[seeds]) seeds++;
    for (long i = 0; seeds && i < runs; i++) {
        const char *seed = reader->seed[test_random_int(&state, seeds)];
        size_t bytes = strlen(seed);
        memcpy(text, seed, bytes);
        for (int times = test_random_int(&state, 6); times > 0; times--)
            bytes = mutate(text, bytes, &state);
        if (!CHECK_SAYING(fuzz_show(reader, text, bytes), "%s: %.*s", reader->name, (int)bytes,
                          text))
            return;
    }
}

TEST(fuzz_mutations_of_good_bytes_are_read_or_refused) {
    for (int t = 0; t < tables_count; t++)
        for (int i = 0; i < tables[t].count; i++) vary(&tables[t].reader[i]);
}

#endif
