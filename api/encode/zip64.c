#include "api/encode/zip64.h"

#include <assert.h>
#include <string.h>

#include "api/base/octets.h"

/* "version needed to extract" without and with ZIP64 */
enum { PLAIN = 20, WIDE = 45, DATE = 1 << 5 | 1 /* 1 January 1980, at 0:00 */ };

/* flag: a data descriptor follows the member */
enum { BEHIND = 1 << 3 };

/* a 32-bit field: the number or, if it is too large, the reference to the ZIP64 field */
static char *narrow(char *at, uint64_t x, uint64_t most) {
    return api_octets_whole(at, x > most ? API_ZIP64_THERE : x, 4);
}

/* returns the version of zip needed to extract this member */
static uint64_t member_version(const struct api_zip64_member *member, int extra) {
    return extra || member->streamed ? WIDE : PLAIN;
}

/* writes the fields that a member's local header and directory entry share, from the version to the
 * length of the extra field. `known`: checksum and size are known */
static char *member_facts(char *at, const struct api_zip64_member *member, int extra, int known,
                          uint64_t most) {
    uint64_t bytes = known ? member->bytes : API_ZIP64_THERE;
    at = api_octets_whole(at, member_version(member, extra), 2);
    at = api_octets_whole(at, member->streamed ? BEHIND : 0, 2);
    at = api_octets_whole(at, 0, 2 + 2); /* stored uncompressed; time 0:00 */
    at = api_octets_whole(at, DATE, 2);
    at = api_octets_whole(at, known ? member->crc : 0, 4);
    at = narrow(narrow(at, bytes, most), bytes, most);
    at = api_octets_whole(at, strlen(member->name), 2);
    return api_octets_whole(at, (uint64_t)extra, 2);
}

/* writes the ZIP64 extra field: `sized` = with both sizes, `placed` = with the offset */
static char *member_wide(char *at, int extra, int sized, uint64_t bytes, int placed,
                         uint64_t offset) {
    if (!extra) return at;
    at = api_octets_whole(api_octets_whole(at, 1, 2), (uint64_t)extra - 4, 2);
    if (sized) at = api_octets_whole(api_octets_whole(at, bytes, 8), bytes, 8);
    return placed ? api_octets_whole(at, offset, 8) : at;
}

char *api_zip64_local(char *at, const struct api_zip64_member *member, uint64_t most) {
    assert(most <= API_ZIP64_MOST && strlen(member->name) < API_ZIP64_NAME);
    int known = !member->streamed, extra = !known || member->bytes > most ? 4 + 16 : 0;
    at = api_octets_whole(at, 0x04034b50, 4);
    at = stpcpy(member_facts(at, member, extra, known, most), member->name);
    return member_wide(at, extra, extra, known ? member->bytes : 0, 0, 0);
}

char *api_zip64_behind(char *at, const struct api_zip64_member *member) {
    assert(member->streamed);
    at = api_octets_whole(api_octets_whole(at, 0x08074b50, 4), member->crc, 4);
    return api_octets_whole(api_octets_whole(at, member->bytes, 8), member->bytes, 8);
}

char *api_zip64_central(char *at, const struct api_zip64_member *member, uint64_t most) {
    assert(most <= API_ZIP64_MOST && strlen(member->name) < API_ZIP64_NAME);
    int placed = member->offset > most, wide = member->bytes > most;
    int extra = placed || wide ? 4 + 16 * wide + 8 * placed : 0;
    at = api_octets_whole(at, 0x02014b50, 4);
    at = api_octets_whole(at, member_version(member, extra), 2);
    at = member_facts(at, member, extra, 1, most);
    at = api_octets_whole(at, 0, 2 + 2 + 2); /* no comment, disk 0, no internal attributes */
    at = api_octets_whole(at, 0, 4);
    at = narrow(at, member->offset, most);
    return member_wide(stpcpy(at, member->name), extra, wide, member->bytes, placed,
                       member->offset);
}

char *api_zip64_end(char *at, int members, uint64_t begin, uint64_t bytes, uint64_t most) {
    assert(members >= 0 && members < 0xffff && most <= API_ZIP64_MOST);
    uint64_t count = (uint64_t)members;
    if (begin > most || bytes > most) {
        at = api_octets_whole(at, 0x06064b50, 4);
        at = api_octets_whole(at, API_ZIP64_END_WIDE - 12, 8);
        at = api_octets_whole(api_octets_whole(at, WIDE, 2), WIDE, 2);
        at = api_octets_whole(at, 0, 4 + 4); /* all on disk 0 */
        at = api_octets_whole(api_octets_whole(at, count, 8), count, 8);
        at = api_octets_whole(api_octets_whole(at, bytes, 8), begin, 8);
        at = api_octets_whole(api_octets_whole(at, 0x07064b50, 4), 0, 4);
        at = api_octets_whole(api_octets_whole(at, begin + bytes, 8), 1, 4);
    }
    at = api_octets_whole(api_octets_whole(at, 0x06054b50, 4), 0, 4);
    at = api_octets_whole(api_octets_whole(at, count, 2), count, 2);
    return api_octets_whole(narrow(narrow(at, bytes, most), begin, most), 0, 2);
}
