/* Fuzzes the files of keys and of options.
 * Leaves to others: rows of the store (fuzz_kept).
 * Invariant: a file is read, or refused with a sentence; a value that is written again reads the
 * same. */
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

#include "server/config/config_load.h"
#include "server/keys/keys.h"
#include "tests/fuzz/fuzz.h"

static int read_keys(char *text, size_t bytes) {
    struct srv_keys keys, again;
    struct pend_error error = {.text = ""};
    OWN(api_buffer, clear) written, twice;
    int good;
    srv_keys_init(&keys);
    srv_keys_init(&again);
    api_buffer_init(&written, 1 << 20);
    api_buffer_init(&twice, 1 << 20);
    if (srv_keys_read(&keys, text, bytes, &error) != PEND_OK)
        good = error.text[0] != 0;
    else
        good = srv_keys_write(&keys, &written) == PEND_OK &&
               srv_keys_read(&again, written.data ? written.data : "", written.bytes, &error) ==
                   PEND_OK &&
               srv_keys_write(&again, &twice) == PEND_OK && twice.bytes == written.bytes &&
               (!twice.bytes || !memcmp(twice.data, written.data, twice.bytes));
    srv_keys_clear(&keys);
    srv_keys_clear(&again);
    return good;
}

static int read_options(char *text, size_t bytes) {
    static int file = -1;
    static char path[32];
    static struct srv_config config;
    struct pend_error error = {.text = ""};
    char program[] = "pendulumd", option[] = "--config";
    char *words[] = {program, option, path, NULL}, *none[] = {NULL};
    if (file < 0) {
        file = memfd_create("options", 0);
        snprintf(path, sizeof path, "/proc/self/fd/%d", file);
    }
    if (file < 0 || ftruncate(file, 0) || pwrite(file, text, bytes, 0) != (ssize_t)bytes) abort();
    if (srv_config_load(&config, 3, words, none, &error) != PEND_OK) return error.text[0] != 0;
    for (int i = 0;; i++) {
        struct srv_option row;
        size_t size;
        if (!srv_config_row(i, &row)) return 1;
        const void *value = srv_config_value(&config, i, &size);
        if (value && size == sizeof(double) && row.most > row.least) {
            double number;
            memcpy(&number, value, sizeof number);
            if (!(number >= row.least && number <= row.most)) return 0;
        } else if (value && size != sizeof(double) && !memchr(value, 0, size)) {
            return 0;
        }
    }
}

static const struct fuzz_reader files[] = {
    {"keys",
     read_keys,
     {"role pupil requests=2 compute=none\n\trole  anonymous jobs=3\r\n",
      "# a comment\n\nkey lab role=batch made=2023-11-14T22:13:20Z expires=2030-01-01T00:00:00Z "
      "revoked=2024-02-29 priority=2 jobs=5 digest="
      "0123456789abcdef0123456789abcdef0123456789abcdef0123456789abcdef\n"},
     0},
    {"options",
     read_options,
     {"listen = 127.0.0.1:8080\n# a comment\nworkers = 2\nmax-held-bytes = 1G\n",
      "role=worker\nstore = postgresql:///x\nheader-seconds = 0.5\nsandbox = auto\n",
      "hosts = *.example.org, [::1]:8080\nframe-ancestors = https://a.example\nlog-client = "
      "none\n"},
     0},
};
FUZZ_READERS(files)
