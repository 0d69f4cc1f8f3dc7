#include "server/jobs/part_claim.h"

#include <assert.h>
#include <stdio.h>
#include <sys/random.h>
#include <unistd.h>

#include "server/base/clock.h"

enum {
    CLAIM_BUSY = 16, /* after a full claim, the next one waits 1/16 of its duration per other
                      * worker */
    CLAIM_POLL_MS = 1000,
    CLAIM_ASIDE_MS = 10000, /* longest wait of a part set aside for an idle worker */
    CLAIM_NEWS_US = 8000,   /* longest random wait per other worker, after a notification */
    CLAIM_REST_US = 20000,  /* as CLAIM_NEWS_US, after a claim that found few parts */
    CLAIM_SPREAD_MOST = 64  /* maximum number of other workers that are counted */
};

void srv_part_claim_init(struct srv_part_claim *claim, int64_t lease_us) {
    char host[48] = "";
    assert(lease_us >= 0);
    *claim = (struct srv_part_claim){.wanted = 1};
    gethostname(host, sizeof host - 1);
    if (getrandom(&claim->random, sizeof claim->random, GRND_NONBLOCK) < 0)
        claim->random = (uint64_t)srv_clock_now();
    snprintf(claim->name, sizeof claim->name, "%s:%ld:%016llx", host, (long)getpid(),
             (unsigned long long)claim->random);
    claim->asked = (struct srv_claim){.worker = claim->name, .lease_us = lease_us};
}

/* Delays the next claim by a random time, which grows with the number of workers: a notification
 * wakes many of them, and most find the parts already claimed. */
static void claim_spread(struct srv_part_claim *claim, long workers, int64_t each_us, int64_t now) {
    long others = workers - 1 < CLAIM_SPREAD_MOST ? workers - 1 : CLAIM_SPREAD_MOST;
    if (others <= 0 || claim->at > now) return;
    claim->random = claim->random * 6364136223846793005u + 1442695040888963407u;
    uint64_t most = (uint64_t)(others * each_us) * 1000;
    claim->at = now + (int64_t)((claim->random >> 32) * most >> 32);
}

/* Delays the next claim after one of small parts. If few parts were found, the random delay grows
 * with the number of workers; if at least half, it is that for one other worker, because few large
 * claims cost the database less than many small ones. After a full claim it is proportional to the
 * duration of the query. */
static void claim_rest(struct srv_part_claim *claim, int count, long workers, int64_t now) {
    int few = count < claim->asked.most, half = few && 2 * count >= claim->asked.most;
    claim_spread(claim, half && workers > 2 ? 2 : workers,
                 few ? CLAIM_REST_US : (now - claim->asked_at) / 1000 / CLAIM_BUSY, now);
}

int srv_part_claim_take(struct srv_part_claim *claim, enum srv_stored stored, long workers,
                        int64_t now) {
    struct srv_claim *asked = &claim->asked;
    int count = stored == SRV_STORED ? asked->count : 0, small = count > 0;
    assert(asked->count <= asked->most && asked->most <= SRV_CLAIMS);
    for (int i = count; i < asked->count; i++) srv_lease_clear(&claim->lease[i]);
    for (int i = 0; i < count; i++)
        small &= claim->lease[i].parts == 1 && claim->lease[i].part_us <= SRV_SMALL_US;
    asked->count = 0;
    if (!claim->aside_at && asked->skipped)
        claim->aside_at = now + (int64_t)CLAIM_ASIDE_MS * 1000000;
    if (!asked->skipped) claim->aside_at = 0;
    /* if one part was found there may be more */
    claim->wanted |= count > 0 || stored == SRV_STORED_LOST || stored == SRV_STORED_AGAIN;
    if (stored == SRV_STORED_LOST || small) claim_rest(claim, count, workers, now);
    return count;
}

void srv_part_claim_hear(struct srv_part_claim *claim, long workers, int64_t now) {
    assert(workers >= 0 && now > 0);
    if (!claim->wanted) claim_spread(claim, workers, CLAIM_NEWS_US, now);
    claim->wanted = 1;
}

int srv_part_claim_due(struct srv_part_claim *claim, int room, int holds, int64_t now) {
    assert(room >= 0 && room <= SRV_CLAIMS && !claim->asked.count);
    int late = claim->aside_at && now >= claim->aside_at;
    if (now < claim->at || (!claim->wanted && now < claim->poll_at)) return 0;
    if (!room || (late && holds)) return 0;
    claim->wanted = 0;
    claim->asked_at = now;
    claim->poll_at = now + (int64_t)CLAIM_POLL_MS * 1000000;
    claim->asked.most = room;
    claim->asked.aside = holds ? SRV_CLAIM_BESIDE : late ? SRV_CLAIM_ASIDE : SRV_CLAIM_IDLE;
    return 1;
}

int64_t srv_part_claim_next(const struct srv_part_claim *claim, int64_t now) {
    if (claim->wanted && claim->at > now) return claim->at;
    return claim->poll_at > now ? claim->poll_at : INT64_MAX;
}
