/* Tests of server/store/store_leases: parts and their holders; random histories agree with a
 * model. */
#include "server/store/store_jobs.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/server/ground.h"

STORE_TEST(a_late_worker_writes_nothing) {
    OWN(srv_store, close) *other = ground_open(ground);
    struct srv_store_sweep sweep;
    struct srv_lease late, now;
    struct srv_job job;
    char back[SRV_CHUNK_BYTES];
    size_t bytes;
    REQUIRE(other);
    CHECK_INT(ground_submit(store, "j", "anna", NULL, 1, 0, &job), SRV_STORED);
    CHECK_INT(ground_claim(store, "late", 1000, &late), SRV_STORED);
    ground_pause_ms(5);
    CHECK_INT(srv_store_sweep(other, NULL, &sweep), SRV_STORED);
    CHECK(sweep.released == 1 && !sweep.given_up);
    CHECK_INT(srv_store_extend(store, &late, SECOND), SRV_STORED_LOST);
    CHECK_INT(ground_claim(other, "now", 60 * SECOND, &now), SRV_STORED);
    CHECK(now.attempt == 2 && now.part == 0);
    CHECK_INT(srv_store_finish(store, &late, "late", 4, NULL, 0), SRV_STORED_LOST);
    CHECK_INT(srv_store_fail(store, &late, "late"), SRV_STORED_LOST);
    CHECK_INT(srv_store_finish(other, &now, "now", 3, NULL, 0), SRV_STORED);
    CHECK_INT(srv_store_finish(store, &late, "late", 4, NULL, 0), SRV_STORED_LOST);
    /* repeated, because the first answer was lost: done once */
    CHECK_INT(srv_store_finish(other, &now, "now", 3, NULL, 0), SRV_STORED);
    CHECK_INT(srv_store_chunk(store, "j", 0, 0, back, &bytes), SRV_STORED);
    CHECK(bytes == 3 && !memcmp(back, "now", 3));
    CHECK_INT(srv_store_job(store, "j", &job), SRV_STORED);
    CHECK(job.state == SRV_JOB_SUCCESSFUL && job.done == 1 && job.bytes == 3);
}

STORE_TEST(a_bit_that_changed_in_a_result_is_seen) {
    OWN(srv_lease, clear) lease;
    struct srv_job job;
    char back[SRV_CHUNK_BYTES];
    size_t bytes;
    CHECK_INT(ground_submit(store, "j", "anna", NULL, 1, 0, &job), SRV_STORED);
    CHECK_INT(ground_claim_whole(store, "w", 60 * SECOND, &lease), SRV_STORED);
    CHECK_INT(srv_store_finish(store, &lease, "abc", 3, NULL, 0), SRV_STORED);
    CHECK_INT(srv_store_chunk(store, "j", 0, 0, back, &bytes), SRV_STORED);
    ground_run(ground, ground->postgres ? "UPDATE results SET data = '\\x616263'::bytea"
                                        : "UPDATE results SET data = X'616263'");
    CHECK_INT(srv_store_chunk(store, "j", 0, 0, back, &bytes), SRV_STORED);
    ground_run(ground, ground->postgres ? "UPDATE results SET data = '\\x616262'::bytea"
                                        : "UPDATE results SET data = X'616262'");
    CHECK_INT(srv_store_chunk(store, "j", 0, 0, back, &bytes), SRV_STORED_DAMAGED);
    CHECK_INT((long long)bytes, 0);
    /* the seal of another position is not valid here */
    ground_run(ground, ground->postgres ? "UPDATE results SET data = '\\x616263'::bytea, chunk = 1"
                                        : "UPDATE results SET data = X'616263', chunk = 1");
    CHECK_INT(srv_store_chunk(store, "j", 0, 1, back, &bytes), SRV_STORED_DAMAGED);
}

STORE_TEST(what_kills_three_workers_is_given_up) {
    struct srv_store_sweep sweep;
    struct srv_lease lease;
    struct srv_job job;
    (void)ground;
    CHECK_INT(ground_submit(store, "poison", "anna", NULL, 7, 0, &job), SRV_STORED);
    /* one before the others, which are done: the job's progress counts in its favour; then as often
     * as is allowed */
    for (int i = 0; i <= SRV_MOST_KILLS; i++) {
        CHECK_INT(ground_claim(store, "w", 1000, &lease), SRV_STORED);
        CHECK_INT(lease.alone, i > 0);
        CHECK(lease.part == 0 && lease.attempt == i + 1);
        ground_pause_ms(3);
        CHECK_INT(srv_store_sweep(store, NULL, &sweep), SRV_STORED);
        CHECK_INT(sweep.given_up, i == SRV_MOST_KILLS);
        for (int k = 1; k < 7 && !i; k++) {
            CHECK_INT(ground_claim(store, "w", 60000000, &lease), SRV_STORED);
            CHECK_INT(lease.part, k);
            CHECK_INT(srv_store_finish(store, &lease, "x", 1, NULL, 0), SRV_STORED);
        }
    }
    CHECK_INT(srv_store_job(store, "poison", &job), SRV_STORED);
    CHECK_INT(job.state, SRV_JOB_FAILED);
    CHECK(strstr(job.message, "3 workers") && strstr(job.message, "part 1 of 7"));
    CHECK_INT(ground_claim(store, "w", 1000, &lease), SRV_STORED_NONE);
}

STORE_TEST(a_job_all_of_whose_parts_kill_ends_soon) {
    struct srv_store_sweep sweep = {0};
    struct srv_lease lease;
    struct srv_job job;
    int kills = 0;
    (void)ground;
    CHECK_INT(ground_submit(store, "poison", "anna", NULL, 1000, 0, &job), SRV_STORED);
    for (; kills < 20 && !sweep.given_up; kills++) {
        CHECK_INT(ground_claim(store, "w", 1000, &lease), SRV_STORED);
        ground_pause_ms(3);
        CHECK_INT(srv_store_sweep(store, NULL, &sweep), SRV_STORED);
    }
    CHECK_INT(sweep.given_up, 1);
    CHECK_INT(kills, 12);
}

STORE_TEST(what_a_worker_gives_back_bears_no_mark) {
    struct srv_lease lease;
    struct srv_job job;
    (void)ground;
    CHECK_INT(ground_submit(store, "j", "anna", NULL, 1, 0, &job), SRV_STORED);
    for (int i = 1; i <= 5; i++) {
        CHECK_INT(ground_claim(store, "mine", 60 * SECOND, &lease), SRV_STORED);
        CHECK_INT(lease.attempt, i);
        CHECK_INT(srv_store_release(store, "another's"), SRV_STORED);
        CHECK_INT(srv_store_extend(store, &lease, 60 * SECOND), SRV_STORED);
        CHECK_INT(srv_store_release(store, "mine"), SRV_STORED);
        CHECK_INT(srv_store_extend(store, &lease, 60 * SECOND), SRV_STORED_LOST);
    }
    CHECK_INT(srv_store_job(store, "j", &job), SRV_STORED);
    CHECK_INT(job.state, SRV_JOB_RUNNING);
}

STORE_TEST(chained_parts_come_one_after_the_other) {
    struct srv_lease lease, none;
    struct srv_store_sweep sweep;
    struct srv_job job;
    char carry[32];
    (void)ground;
    CHECK_INT(ground_submit(store, "chain", "anna", NULL, 4, 1, &job), SRV_STORED);
    for (long i = 0; i < 4; i++) {
        CHECK_INT(ground_claim(store, "w", i == 2 ? 1000 : 60 * SECOND, &lease), SRV_STORED);
        CHECK_INT(ground_claim(store, "w", SECOND, &none), SRV_STORED_NONE);
        if (i == 2 && lease.attempt == 1) {
            /* a repeated part starts from the same checkpoint */
            srv_lease_clear(&lease);
            ground_pause_ms(3);
            CHECK_INT(srv_store_sweep(store, NULL, &sweep), SRV_STORED);
            CHECK_INT(ground_claim(store, "w", 60 * SECOND, &lease), SRV_STORED);
            CHECK_INT(lease.attempt, 2);
        }
        CHECK_INT(lease.part, i);
        snprintf(carry, sizeof carry, "after %ld", i - 1);
        if (i)
            CHECK(lease.start_bytes == 7 && !memcmp(lease.start, carry, 7));
        else
            CHECK(!lease.start);
        snprintf(carry, sizeof carry, "after %ld", i);
        CHECK_INT(srv_store_finish(store, &lease, "x", 1, i < 3 ? carry : NULL, 7), SRV_STORED);
        srv_lease_clear(&lease);
    }
    CHECK_INT(srv_store_job(store, "chain", &job), SRV_STORED);
    CHECK_INT(job.state, SRV_JOB_SUCCESSFUL);
}

STORE_TEST(clients_take_turns_and_so_do_jobs) {
    struct srv_lease lease;
    struct srv_job job;
    char id[16], order[64] = "";
    (void)ground;
    /* anna has many jobs, berta comes with one job of two parts: berta is served every second
     * time */
    for (int i = 0; i < 10; i++) {
        snprintf(id, sizeof id, "a%d", i);
        CHECK_INT(ground_submit(store, id, "anna", NULL, 1, 0, &job), SRV_STORED);
    }
    for (int i = 0; i < 4; i++)
        CHECK_INT(ground_claim(store, "w", 60 * SECOND, &lease), SRV_STORED);
    CHECK_TEXT(lease.job, "a3");
    CHECK_INT(ground_submit(store, "b", "berta", NULL, 2, 0, &job), SRV_STORED);
    for (int i = 0; i < 4; i++) {
        CHECK_INT(ground_claim(store, "w", 60 * SECOND, &lease), SRV_STORED);
        order[i] = lease.job[0];
    }
    CHECK(!strcmp(order, "abab") || !strcmp(order, "baba"));
}

/* the job with the least work left goes first, whichever came first */
static void submit_cost(struct srv_store *store, const char *id, long parts, int64_t cost_us) {
    struct srv_job job;
    struct srv_job_order order = ground_order(id, "anna");
    order.parts = parts;
    order.cost_us = cost_us;
    CHECK_INT(srv_store_submit(store, &order, &job), SRV_STORED);
}

static const char *claimed(struct srv_store *store) {
    static char id[SRV_ID_BYTES];
    struct srv_lease lease;
    if (!CHECK_INT(ground_claim(store, "w", 60 * SECOND, &lease), SRV_STORED)) return "";
    memcpy(id, lease.job, sizeof id);
    return id;
}

STORE_TEST(a_short_job_waits_for_no_long_one) {
    struct srv_lease lease;
    char id[16];
    (void)ground;
    for (int i = 0; i < 50; i++) {
        snprintf(id, sizeof id, "long%d", i);
        submit_cost(store, id, 100, 100LL * SECOND);
    }
    CHECK_TEXT(claimed(store), "long0");
    submit_cost(store, "short", 2, SECOND / 1000);
    for (int i = 0; i < 2; i++) CHECK_TEXT(claimed(store), "short");
    /* of equal jobs the one that has begun is finished first, in place of all being half done */
    for (int i = 0; i < 5; i++) {
        CHECK_INT(ground_claim(store, "w", 60 * SECOND, &lease), SRV_STORED);
        CHECK_TEXT(lease.job, "long0");
        CHECK_INT(lease.part, i + 1);
    }
}

/* sets ranks, which change so behind a store's back only here */
static void ranks_set(const struct ground *ground, struct srv_store *store, const char *command) {
    ground_run(ground, command);
    memset(store->floor, 0, sizeof store->floor);
}

/* ten equal jobs of 3.4 s, posted together: a short one that comes at any time is next, and so is
 * one of half their length; for a job that has begun the remaining time counts */
STORE_TEST(ten_equal_jobs_keep_no_short_one_waiting) {
    char id[24];
    for (int i = 0; i < 10; i++) {
        snprintf(id, sizeof id, "equal%d", i);
        submit_cost(store, id, 4, 34 * SECOND / 10);
    }
    CHECK_TEXT(claimed(store), "equal0");
    /* 30 s later */
    ranks_set(ground, store, "UPDATE jobs SET rank = rank - 30000000");
    for (int i = 0; i < 3; i++) {
        snprintf(id, sizeof id, i == 2 ? "half%d" : "short%d", i);
        submit_cost(store, id, 1, i == 2 ? 17 * SECOND / 10 : SECOND / 1000);
        CHECK_TEXT(claimed(store), id);
    }
    for (int i = 1; i < 4; i++) CHECK_TEXT(claimed(store), "equal0");
    CHECK_TEXT(claimed(store), "equal1");
    /* by a statement and by the function */
    const int64_t left[] = {0, 1, 57142856, 57142857, 100000000, INT64_C(259200000000)};
    for (int i = 0; i < 6; i++) {
        int64_t rank = srv_store_rank(1000, left[i]);
        int64_t most = left[i] + 3600 * (int64_t)SECOND, times = 64 * left[i];
        int64_t off = rank - 1000 - (most < times ? most : times);
        CHECK_SAYING(off >= 0 && off < 64, "%lld: %lld", (long long)left[i], (long long)rank);
    }
    submit_cost(store, "day", 4, 86400LL * SECOND);
    ranks_set(ground, store, "UPDATE jobs SET rank = rank - 1000000000000 WHERE id = 'day'");
    for (int part = 1; part <= 4; part++) {
        CHECK_TEXT(claimed(store), "day");
        int64_t of =
            ground_ask(ground, "SELECT rank - created + 1000000000000 FROM jobs WHERE id = 'day'");
        CHECK_INT(of, srv_store_rank(0, (4 - part) * 21600LL * SECOND));
    }
}

/* several small parts are claimed at a time, clients in turn; a long one is claimed alone */
STORE_TEST(one_claim_takes_several_small_parts_or_one_long) {
    struct srv_lease lease[SRV_CLAIMS];
    struct srv_job job;
    char id[16];
    struct srv_claim claim = {.worker = "w", .lease_us = 60 * SECOND, .most = SRV_CLAIMS};
    int count, annas = 0;
    submit_cost(store, "long", 2, 2 * SECOND);
    claim.count = 0;
    CHECK_INT(srv_store_claim(store, &claim, lease), SRV_STORED);
    count = claim.count;
    CHECK(count == 1 && !strcmp(lease[0].job, "long") && lease[0].part_us == SECOND);
    srv_lease_clear(&lease[0]);
    for (int i = 0; i < 2 * SRV_CLAIMS; i++) {
        snprintf(id, sizeof id, "a%d", i);
        submit_cost(store, id, 1, 100);
    }
    for (int i = 0; i < 4; i++) {
        snprintf(id, sizeof id, "b%d", i);
        CHECK_INT(ground_submit(store, id, "berta", NULL, 1, 0, &job), SRV_STORED);
    }
    claim.count = 0;
    CHECK_INT(srv_store_claim(store, &claim, lease), SRV_STORED);
    count = claim.count;
    for (int i = 0; i < count; i++) {
        annas += lease[i].job[0] == 'a';
        CHECK(lease[i].part == 0 && lease[i].attempt == 1 && lease[i].request_bytes > 0 &&
              lease[i].request);
        CHECK_INT(srv_store_extend(store, &lease[i], 60 * SECOND), SRV_STORED);
        CHECK_INT(srv_store_finish(store, &lease[i], "x", 1, NULL, 0), SRV_STORED);
        srv_lease_clear(&lease[i]);
    }
    /* berta has four; the rest of the claim is anna's, or is left for the next */
    CHECK_SAYING(count - annas == 4 && annas >= SRV_CLAIMS / 2, "%d of %d", annas, count);
    /* parts that together take longer than a claim may are not claimed together: 4 ms each, 20 ms
     * in all */
    for (int i = 0; i < 20; i++) {
        snprintf(id, sizeof id, "c%d", i);
        submit_cost(store, id, 1, 4000);
        ranks_set(ground, store, "UPDATE jobs SET rank = 0 WHERE part_us = 4000");
    }
    claim.count = 0;
    CHECK_INT(srv_store_claim(store, &claim, lease), SRV_STORED);
    count = claim.count;
    CHECK_INT(count, SRV_CLAIM_US / 4000);
    for (int i = 0; i < count; i++) srv_lease_clear(&lease[i]);
    ground_sums(ground);
}

/* after an hour more than its computation time, or 64 times that, a job goes before all later
 * ones */
STORE_TEST(a_long_job_does_not_wait_for_ever) {
    submit_cost(store, "long", 10, 100LL * SECOND);
    submit_cost(store, "a", 1, SECOND);
    CHECK_TEXT(claimed(store), "a");
    ranks_set(ground, store, "UPDATE jobs SET rank = rank - 3600000000 WHERE id = 'long'");
    submit_cost(store, "c", 1, SECOND / 1000);
    CHECK_TEXT(claimed(store), "c");
    ranks_set(ground, store, "UPDATE jobs SET rank = rank - 100000000 WHERE id = 'long'");
    submit_cost(store, "b", 1, SECOND);
    CHECK_TEXT(claimed(store), "long");
    CHECK_TEXT(claimed(store), "long");
}

/* ---- a model */

enum { MODEL_JOBS = 30, MODEL_PARTS = 5 };

struct model_job {
    int open, chained, parts, dismissed, failed;
    enum { MODEL_FRESH, MODEL_HELD, MODEL_BACK, MODEL_DONE } part[MODEL_PARTS];
    long attempt[MODEL_PARTS];
};

static int model_claimable(const struct model_job *job, int part) {
    if (!job->open || part >= job->parts) return 0;
    if (job->part[part] == MODEL_BACK) return 1;
    return job->part[part] == MODEL_FRESH &&
           (!job->chained || !part || job->part[part - 1] == MODEL_DONE);
}

static int model_any(const struct model_job job[], int jobs) {
    for (int j = 0; j < jobs; j++)
        for (int s = 0; s < MODEL_PARTS; s++)
            if (model_claimable(&job[j], s)) return 1;
    return 0;
}

static int model_done(const struct model_job *job) {
    for (int s = 0; s < job->parts; s++)
        if (job->part[s] != MODEL_DONE) return 0;
    return 1;
}

static int model_agrees(struct srv_store *store, const struct model_job model[], int jobs) {
    int good = 1;
    for (int j = 0; j < jobs && good; j++) {
        char id[16];
        struct srv_job job;
        int done = 0;
        snprintf(id, sizeof id, "m%d", j);
        for (int s = 0; s < model[j].parts; s++) done += model[j].part[s] == MODEL_DONE;
        good = srv_store_job(store, id, &job) == SRV_STORED && job.done == done &&
               (job.state == SRV_JOB_DISMISSED) == model[j].dismissed &&
               (job.state == SRV_JOB_FAILED) == model[j].failed &&
               (job.state <= SRV_JOB_RUNNING) == model[j].open;
    }
    return good;
}

STORE_TEST(random_histories_agree_with_a_model) {
    struct model_job model[MODEL_JOBS] = {0};
    struct srv_lease held[200];
    int jobs = 0, leases = 0, rounds = 600;
    unsigned long long random = 5;
    for (int round = 0; round < rounds; round++) {
        int act = test_random_int(&random, 10), good = 1;
        struct srv_job job;
        char id[16];
        if (act < 1 && jobs < MODEL_JOBS) {
            struct model_job *own = &model[jobs];
            *own = (struct model_job){.open = 1,
                                      .chained = test_random_int(&random, 2),
                                      .parts = 1 + test_random_int(&random, MODEL_PARTS)};
            snprintf(id, sizeof id, "m%d", jobs++);
            good = ground_submit(store, id, jobs % 3 ? "anna" : "berta", NULL, own->parts,
                                 own->chained, &job) == SRV_STORED;
        } else if (act < 5 && leases < 200) {
            struct srv_lease *lease = &held[leases];
            enum srv_stored stored = ground_claim(store, test_random_int(&random, 2) ? "w0" : "w1",
                                                  3600LL * SECOND, lease);
            good = stored == (model_any(model, jobs) ? SRV_STORED : SRV_STORED_NONE);
            if (stored == SRV_STORED) {
                struct model_job *own = &model[atoi(lease->job + 1)];
                good = good && model_claimable(own, (int)lease->part) &&
                       lease->attempt == own->attempt[lease->part] + 1;
                own->part[lease->part] = MODEL_HELD;
                own->attempt[lease->part] = lease->attempt;
                leases++;
            }
        } else if (act < 9 && leases) {
            /* any lease that was ever given, including lost ones */
            struct srv_lease *lease = &held[test_random_int(&random, leases)];
            struct model_job *own = &model[atoi(lease->job + 1)];
            int mine = own->open && own->part[lease->part] == MODEL_HELD &&
                       own->attempt[lease->part] == lease->attempt;
            int was = !own->dismissed && !own->failed && own->part[lease->part] == MODEL_DONE &&
                      own->attempt[lease->part] == lease->attempt;
            int fail = test_random_int(&random, 12) == 0;
            const char *carry = own->chained && lease->part + 1 < own->parts ? "c" : NULL;
            enum srv_stored stored = fail ? srv_store_fail(store, lease, "no")
                                          : srv_store_finish(store, lease, "r", 1, carry, 1);
            good = stored == (mine || (was && !fail) ? SRV_STORED : SRV_STORED_LOST);
            if (mine && fail) own->failed = 1;
            if (mine && fail) own->open = 0;
            if (mine && !fail) own->part[lease->part] = MODEL_DONE;
            if (model_done(own)) own->open = 0;
        } else if (jobs && test_random_int(&random, 4) == 0) {
            int j = test_random_int(&random, jobs);
            snprintf(id, sizeof id, "m%d", j);
            good = srv_store_dismiss(store, id, &job) == SRV_STORED;
            model[j].dismissed = 1;
            model[j].failed = model[j].open = 0;
        } else {
            const char *worker = test_random_int(&random, 2) ? "w0" : "w1";
            good = srv_store_release(store, worker) == SRV_STORED;
            /* the model does not know which worker has what: query it */
            for (int i = 0; i < leases; i++) {
                struct model_job *own = &model[atoi(held[i].job + 1)];
                int mine = own->open && own->part[held[i].part] == MODEL_HELD &&
                           own->attempt[held[i].part] == held[i].attempt;
                if (mine && srv_store_extend(store, &held[i], 3600LL * SECOND) == SRV_STORED_LOST)
                    own->part[held[i].part] = MODEL_BACK;
            }
        }
        if (!CHECK_SAYING(good, "round %d, act %d", round, act)) break;
        if (round % 50 == 49 && !CHECK(model_agrees(store, model, jobs))) break;
    }
    CHECK(jobs > 10 && leases > 30);
    ground_sums(ground);
    for (int i = 0; i < leases; i++) srv_lease_clear(&held[i]);
}

/* a client per job gets few more turns than eight others */
STORE_TEST(many_clients_of_one_address_take_few_turns) {
    enum { TOKENS = 32, EACH = 3, CLAIMS = 60 };
    struct srv_job job;
    struct srv_lease lease;
    char id[40], client[16];
    int of_other = 0;
    (void)ground;
    for (int k = 0; k < EACH; k++)
        for (int i = 0; i < TOKENS; i++) {
            snprintf(id, sizeof id, "t%d-%d", i, k);
            snprintf(client, sizeof client, "t%d", i);
            struct srv_job_order order = ground_order(id, client);
            order.source = "home";
            CHECK_INT(srv_store_submit(store, &order, &job), SRV_STORED);
        }
    for (int k = 0; k < CLAIMS; k++) {
        snprintf(id, sizeof id, "other-%d", k);
        CHECK_INT(ground_submit(store, id, "other", NULL, 1, 0, &job), SRV_STORED);
    }
    for (int k = 0; k < CLAIMS; k++) {
        CHECK_INT(ground_claim(store, "w", 60 * SECOND, &lease), SRV_STORED);
        of_other += !strncmp(lease.job, "other", 5);
        srv_lease_clear(&lease);
    }
    /* about one in seven; without weights it would be one in thirty-three */
    CHECK_SAYING(of_other >= 7 && of_other <= 12, "%d of %d", of_other, CLAIMS);
}

/* a sweep that finds an expired lease, and its job successful once its row is locked, removes what
 * is still held */
STORE_TEST(a_job_that_has_ended_keeps_the_parts_that_are_done) {
    struct srv_store_sweep sweep;
    struct srv_lease lease;
    struct srv_job job;
    CHECK_INT(ground_submit(store, "job", "anna", NULL, 1, 0, &job), SRV_STORED);
    CHECK_INT(ground_claim(store, "w", 60 * SECOND, &lease), SRV_STORED);
    CHECK_INT(srv_store_finish(store, &lease, "x", 1, NULL, 0), SRV_STORED);
    ground_run(ground, "INSERT INTO parts (job, number, state, attempt, kills, worker, lease, "
                       "bytes) VALUES ('job', 1, 1, 1, 0, 'gone', 1, 0)");
    CHECK_INT(srv_store_sweep(store, NULL, &sweep), SRV_STORED);
    CHECK_INT(ground_ask(ground, "SELECT CAST(COUNT(*) AS BIGINT) FROM parts WHERE state = 1"), 0);
    CHECK_INT(ground_ask(ground, "SELECT CAST(COUNT(*) AS BIGINT) FROM parts WHERE state = 2"), 1);
    /* so that a call whose answer was lost can be repeated */
    CHECK_INT(srv_store_finish(store, &lease, "x", 1, NULL, 0), SRV_STORED);
    srv_lease_clear(&lease);
    ground_sums(ground);
}
