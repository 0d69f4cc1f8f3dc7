#include "server/classes/nickname.h"

#include <assert.h>
#include <stdlib.h>

#include "server/classes/nickname_table.h"

enum {
    NICKNAME_CODES = 1024 /* characters of a fold: a name has 32, which become at most 18 each */
};

/* Reads a UTF-8 character; a malformed one is U+FFFD. */
static unsigned nickname_read(const char **text) {
    const unsigned char *at = (const unsigned char *)*text;
    unsigned first = *at++, more = first < 0xc0 ? 0 : first < 0xe0 ? 1 : first < 0xf0 ? 2 : 3;
    unsigned code = first < 0x80 ? first : first & (0x3fU >> more);
    for (unsigned i = 0; i < more && (*at & 0xc0) == 0x80; i++) code = code << 6 | (*at++ & 0x3f);
    int bad = (first >= 0x80 && first < 0xc2) || first > 0xf4 ||
              at - (const unsigned char *)*text != 1 + (long)more;
    *text = (const char *)at;
    return bad ? 0xfffd : code;
}

static size_t nickname_write(char *to, unsigned code) {
    size_t bytes = code < 0x80 ? 1 : code < 0x800 ? 2 : code < 0x10000 ? 3 : 4;
    static const unsigned char first[] = {0, 0, 0xc0, 0xe0, 0xf0};
    for (size_t i = bytes; i-- > 1; code >>= 6) to[i] = (char)(0x80 | (code & 0x3f));
    to[0] = (char)(first[bytes] | code);
    return bytes;
}

static int nickname_row(const void *code, const void *row) {
    unsigned one = *(const unsigned *)code, other = ((const struct srv_nickname_row *)row)->code;
    return (one > other) - (one < other);
}

static int nickname_marks(const void *code, const void *range) {
    unsigned one = *(const unsigned *)code;
    const unsigned *ends = range;
    return (one > ends[1]) - (one < ends[0]);
}

static int nickname_mark(unsigned code) {
    return bsearch(&code, srv_nickname_marks, srv_nickname_mark_count, sizeof *srv_nickname_marks,
                   nickname_marks) != NULL;
}

int srv_nickname_fold(const char *name, char fold[], size_t cap) {
    unsigned codes[NICKNAME_CODES];
    size_t count = 0, used = 0;
    assert(cap > 3);
    while (*name) {
        char own[5] = "";
        unsigned code = nickname_read(&name);
        const struct srv_nickname_row *row =
            bsearch(&code, srv_nickname_rows, srv_nickname_row_count, sizeof *row, nickname_row);
        nickname_write(own, code);
        const char *text = row ? srv_nickname_text + row->at : own;
        while (*text && count < NICKNAME_CODES) codes[count++] = nickname_read(&text);
    }
    /* the order of combining marks does not matter */
    for (size_t i = 1; i < count; i++)
        for (size_t k = i; k > 0 && codes[k - 1] > codes[k] && nickname_mark(codes[k]) &&
                           nickname_mark(codes[k - 1]);
             k--) {
            unsigned mark = codes[k];
            codes[k] = codes[k - 1];
            codes[k - 1] = mark;
        }
    for (size_t i = 0; i < count && used + 4 < cap; i++)
        used += nickname_write(fold + used, codes[i]);
    fold[used] = 0;
    return (int)used;
}
