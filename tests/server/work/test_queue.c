/* Tests of server/work/queue and server/work/workers. */
#include "server/work/queue.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>

#include "server/work/workers.h"
#include "tests/harness/server.h"
#include "tests/harness/test.h"

TEST(a_lane_is_first_in_first_out_and_the_queue_is_bounded) {
    OWN(srv_queue, free) *queue;
    struct srv_lane lane = {0};
    struct srv_task task[4] = {0};
    for (int i = 0; i < 4; i++) task[i].lane = &lane;
    REQUIRE(srv_queue_new(&queue, 3, 3) == PEND_OK);
    for (int round = 0; round < 3; round++) {
        for (int i = 0; i < 3; i++) CHECK(srv_queue_push(queue, &task[i]) == PEND_OK);
        CHECK(srv_queue_push(queue, &task[3]) == PEND_LIMIT && !task[3].queued);
        CHECK_INT(srv_queue_count(queue), 3);
        CHECK(srv_queue_waiting(queue, 0) == 3 && !srv_queue_waiting(queue, 1));
        CHECK(!srv_queue_shorter(queue, 0) && srv_queue_shorter(queue, 1) &&
              srv_queue_shorter(queue, 3));
        CHECK(srv_queue_valid(queue));
        for (int i = 0; i < 3; i++) CHECK(srv_queue_pop(queue) == &task[i]);
        CHECK(srv_queue_valid(queue) && srv_queue_count(queue) == 0);
    }
    srv_queue_free(&queue);
    CHECK(queue == NULL);
}

TEST(one_lane_does_not_take_all_the_room_but_what_was_begun_has_room) {
    OWN(srv_queue, free) *queue;
    struct srv_lane one = {0}, two = {0};
    struct srv_task task[5] = {0};
    for (int i = 0; i < 5; i++) task[i].lane = i < 3 ? &one : &two;
    REQUIRE(srv_queue_new(&queue, 3, 2) == PEND_OK);
    CHECK(srv_queue_push(queue, &task[0]) == PEND_OK);
    CHECK(srv_queue_push(queue, &task[1]) == PEND_OK);
    CHECK(srv_queue_push(queue, &task[2]) == PEND_INVALID);
    CHECK(srv_queue_push(queue, &task[3]) == PEND_OK);
    CHECK(srv_queue_push(queue, &task[4]) == PEND_LIMIT);
    srv_queue_again(queue, &task[4]);
    CHECK_INT(srv_queue_count(queue), 4);
    CHECK(srv_queue_valid(queue));
    while (srv_queue_count(queue)) srv_queue_pop(queue);
}

TEST(lanes_take_turns_however_much_one_brings) {
    enum { MANY = 12 };
    OWN(srv_queue, free) *queue;
    struct srv_lane lane[3] = {0};
    struct srv_task many[MANY] = {0}, few[2] = {0};
    REQUIRE(srv_queue_new(&queue, 100, 100) == PEND_OK);
    for (int i = 0; i < MANY; i++) {
        many[i].lane = &lane[0];
        CHECK(srv_queue_push(queue, &many[i]) == PEND_OK);
    }
    for (int i = 0; i < 2; i++) {
        few[i].lane = &lane[1 + i];
        CHECK(srv_queue_push(queue, &few[i]) == PEND_OK);
    }
    CHECK(srv_queue_pop(queue) == &many[0]);
    CHECK(srv_queue_pop(queue) == &few[0]);
    CHECK(srv_queue_pop(queue) == &few[1]);
    for (int i = 1; i < MANY; i++) CHECK(srv_queue_pop(queue) == &many[i]);
}

/* an address with many clients has a turn for each, eight at most; another one waits no longer */
TEST(lanes_of_one_road_take_its_turns) {
    enum { LANES = 20, EACH = 3 };
    OWN(srv_queue, free) *queue;
    struct srv_lane home = {0}, lane[LANES] = {0}, other = {0};
    struct srv_task task[LANES][EACH] = {0}, some[EACH] = {0};
    int at = 0;
    REQUIRE(srv_queue_new(&queue, 1000, 10) == PEND_OK);
    for (int k = 0; k < EACH; k++) {
        for (int i = 0; i < LANES; i++) {
            lane[i].road = &home.own;
            task[i][k].lane = &lane[i];
            CHECK(srv_queue_push(queue, &task[i][k]) == PEND_OK);
        }
        some[k].lane = &other;
        CHECK(srv_queue_push(queue, &some[k]) == PEND_OK);
    }
    CHECK_INT(home.own.count, LANES * EACH);
    CHECK(srv_queue_valid(queue));
    for (int turn = 0; turn < EACH; turn++) {
        for (int i = 0; i < SRV_TURNS_ROW; i++, at++)
            CHECK(srv_queue_pop(queue) == &task[at % LANES][at / LANES]);
        CHECK(srv_queue_pop(queue) == &some[turn]);
    }
    for (; at < LANES * EACH; at++) CHECK(srv_queue_pop(queue) == &task[at % LANES][at / LANES]);
    CHECK_INT(home.own.count, 0);
    CHECK_INT(srv_queue_count(queue), 0);
}

TEST(lanes_of_one_road_leave_room_to_others) {
    enum { CAP = 16, LANES = 8 };
    OWN(srv_queue, free) *queue;
    struct srv_lane home = {0}, lane[LANES] = {0}, other = {0};
    struct srv_task task[CAP] = {0}, guest = {.lane = &other};
    REQUIRE(srv_queue_new(&queue, CAP, 4) == PEND_OK);
    for (int i = 0; i < CAP; i++) {
        lane[i % LANES].road = &home.own;
        task[i].lane = &lane[i % LANES];
        CHECK(srv_queue_push(queue, &task[i]) == (i < 12 ? PEND_OK : PEND_INVALID));
    }
    CHECK(srv_queue_push(queue, &guest) == PEND_OK);
    CHECK(srv_queue_valid(queue));
    while (srv_queue_count(queue)) srv_queue_pop(queue);
}

/* a task that reads a long body in one go is left to the reader, and continues at another level */
TEST(workers_leave_long_reading_to_the_reader) {
    OWN(srv_queue, free) *queue;
    struct srv_lane lane = {0};
    struct srv_task long_body = {.lane = &lane, .level = SRV_QUEUE_READ}, task = {.lane = &lane};
    REQUIRE(srv_queue_new(&queue, 10, 10) == PEND_OK);
    CHECK(srv_queue_push(queue, &long_body) == PEND_OK);
    CHECK(srv_queue_count(queue) == 1 && !srv_queue_shorter(queue, SRV_QUEUE_LEVELS));
    CHECK(srv_queue_push(queue, &task) == PEND_OK && srv_queue_valid(queue));
    CHECK(srv_queue_pop(queue) == &task);
    CHECK(srv_queue_pop_read(queue) == &long_body);
    long_body.level = 1;
    srv_queue_again(queue, &long_body);
    CHECK(srv_queue_pop(queue) == &long_body && !srv_queue_count(queue));
    srv_queue_close(queue);
    CHECK(!srv_queue_pop(queue) && !srv_queue_pop_read(queue));
}

TEST(short_tasks_come_before_long_ones_which_do_not_starve) {
    enum { SHORTS = 64 };
    OWN(srv_queue, free) *queue;
    struct srv_lane lane[2] = {0};
    struct srv_task task[SHORTS] = {0}, batch = {.lane = &lane[1], .level = 3};
    REQUIRE(srv_queue_new(&queue, 100, 100) == PEND_OK);
    CHECK(srv_queue_push(queue, &batch) == PEND_OK);
    for (int i = 0; i < SHORTS; i++) {
        task[i].lane = &lane[0];
        CHECK(srv_queue_push(queue, &task[i]) == PEND_OK);
    }
    int turns = 0, first = -1, taken = 0;
    for (struct srv_task *next; srv_queue_count(queue) > 1; turns++) {
        next = srv_queue_pop(queue);
        if (next != &batch) continue;
        if (first < 0) first = turns;
        taken++;
        srv_queue_again(queue, &batch);
    }
    CHECK_SAYING(first >= SRV_QUEUE_SHARE - 1, "the long one came at turn %d", first);
    CHECK_SAYING(taken >= turns / (2 * SRV_QUEUE_SHARE), "it had %d of %d turns", taken, turns);
    CHECK_SAYING(taken <= turns / SRV_QUEUE_SHARE + 1, "it had %d of %d turns", taken, turns);
    srv_queue_pop(queue);
}

TEST(who_puts_one_back_and_takes_one_makes_no_lane_fuller) {
    enum { ROUNDS = 100 };
    OWN(srv_queue, free) *queue;
    struct srv_lane lane = {0}, other = {0};
    struct srv_task task[3] = {0}, late = {.lane = &lane}, guest = {.lane = &other};
    REQUIRE(srv_queue_new(&queue, 10, 3) == PEND_OK);
    for (int i = 0; i < 3; i++) {
        task[i].lane = &lane;
        CHECK(srv_queue_push(queue, &task[i]) == PEND_OK);
    }
    struct srv_task *held = srv_queue_pop(queue);
    for (int i = 0; i < ROUNDS; i++) {
        CHECK_INT(srv_queue_count(queue), 2);
        CHECK(held == &task[i % 3]);
        held = srv_queue_swap(queue, held);
    }
    CHECK(srv_queue_valid(queue) && srv_queue_push(queue, &late) == PEND_OK &&
          srv_queue_push(queue, &guest) == PEND_OK);
    /* the other lane's task comes soon; the task that was put back is not lost */
    for (int i = 0; i < 2 && held != &guest; i++) held = srv_queue_swap(queue, held);
    CHECK(held == &guest);
    CHECK_INT(srv_queue_count(queue), 4);
    while (srv_queue_count(queue)) srv_queue_pop(queue);
    /* nobody else waits: it gets the same task again */
    CHECK(srv_queue_swap(queue, &guest) == &guest && srv_queue_count(queue) == 0);
}

TEST(a_task_can_be_taken_out_of_the_middle_once) {
    OWN(srv_queue, free) *queue;
    struct srv_lane lane = {0};
    struct srv_task task[3] = {0};
    REQUIRE(srv_queue_new(&queue, 3, 3) == PEND_OK);
    for (int i = 0; i < 3; i++) {
        task[i].lane = &lane;
        CHECK(srv_queue_push(queue, &task[i]) == PEND_OK);
    }
    CHECK_INT(srv_queue_remove(queue, &task[1]), 1);
    CHECK_INT(srv_queue_remove(queue, &task[1]), 0);
    CHECK(srv_queue_valid(queue));
    CHECK(srv_queue_pop(queue) == &task[0] && srv_queue_pop(queue) == &task[2]);
    CHECK_INT(srv_queue_remove(queue, &task[0]), 0);
    srv_queue_close(queue);
    CHECK(srv_queue_pop(queue) == NULL);
    CHECK(srv_queue_push(queue, &task[0]) == PEND_LIMIT);
}

TEST(random_pushes_pops_and_removals_keep_a_queue_whole) {
    enum { TASKS = 40, LANES = 5 };
    OWN(srv_queue, free) *queue;
    struct srv_lane lane[LANES] = {0};
    struct srv_task task[TASKS] = {0};
    int waiting = 0;
    unsigned long long random = 3;
    REQUIRE(srv_queue_new(&queue, TASKS / 2, TASKS / 4) == PEND_OK);
    /* three lanes come from one address, two each from their own */
    lane[1].road = lane[2].road = &lane[0].own;
    for (int round = 0; round < 20000; round++) {
        int i = test_random_int(&random, TASKS), act = test_random_int(&random, 3), good = 1;
        struct srv_task *other;
        if (act == 0 && !task[i].queued) {
            task[i].lane = &lane[i % LANES];
            task[i].level = test_random_int(&random, SRV_QUEUE_LEVELS);
            int many = task[i].lane->count >= TASKS / 4 ||
                       (i % LANES < 3 &&
                        lane[0].count + lane[1].count + lane[2].count >= TASKS / 2 - TASKS / 8);
            enum pend_status right = waiting >= TASKS / 2 ? PEND_LIMIT
                                     : many               ? PEND_INVALID
                                                          : PEND_OK;
            good = srv_queue_push(queue, &task[i]) == right;
            waiting += right == PEND_OK;
        } else if (act == 1 && waiting) {
            other = srv_queue_pop(queue);
            good = other && !other->queued && srv_queue_count(queue) == --waiting;
        } else if (act == 2) {
            int there = task[i].queued;
            good = srv_queue_remove(queue, &task[i]) == there;
            waiting -= there;
        }
        if (!CHECK(good && srv_queue_valid(queue) && srv_queue_count(queue) == waiting)) break;
    }
    while (waiting--) srv_queue_pop(queue);
    for (int i = 0; i < LANES; i++) CHECK_INT(lane[i].count, 0);
}

static atomic_int task_runs;

struct task_count {
    struct srv_task task;
    atomic_int runs;
};

static int task_run(struct srv_task *task) {
    atomic_fetch_add(&((struct task_count *)task)->runs, 1);
    atomic_fetch_add(&task_runs, 1);
    return 0;
}

TEST(workers_run_every_task_once) {
    enum { TASKS = 5000, CAP = 16 };
    OWN(srv_queue, free) *queue = NULL;
    struct srv_workers *workers;
    struct srv_lane lane[3] = {0};
    OWN_MEMORY struct task_count *task = calloc(TASKS, sizeof *task);
    atomic_store(&task_runs, 0);
    REQUIRE(task && srv_queue_new(&queue, CAP, CAP) == PEND_OK);
    REQUIRE(srv_workers_new(&workers, 4, queue, NULL) == PEND_OK);
    for (int i = 0; i < TASKS;) {
        task[i].task.run = task_run;
        task[i].task.lane = &lane[i % 3];
        if (srv_queue_push(queue, &task[i].task) == PEND_OK) i++;
    }
    srv_workers_free(&workers);
    CHECK(workers == NULL);
    CHECK_INT(task_runs, TASKS);
    int wrong = 0;
    for (int i = 0; i < TASKS; i++) wrong += task[i].runs != 1;
    CHECK_INT(wrong, 0);
}

TEST(workers_wait_for_tasks_and_are_woken) {
    OWN(srv_queue, free) *queue;
    OWN(srv_workers, free) *workers = NULL;
    struct srv_lane lane = {0};
    struct task_count task = {.task.run = task_run, .task.lane = &lane};
    REQUIRE(srv_queue_new(&queue, 2, 2) == PEND_OK);
    REQUIRE(srv_workers_new(&workers, 2, queue, NULL) == PEND_OK);
    test_sleep(0.02);
    CHECK(srv_queue_push(queue, &task.task) == PEND_OK);
    for (double until = test_clock() + TEST_PATIENCE; !task.runs && test_clock() < until;)
        test_sleep(0.001);
    CHECK_INT(task.runs, 1);
}

TEST(there_is_a_worker_for_each_processor_at_least_one) {
    CHECK(srv_workers_default() >= 1 && srv_workers_default() <= 100000);
}

TEST(queue_and_workers_survive_want_of_memory) {
    OWN(srv_queue, free) *queue = NULL;
    struct srv_workers *workers = NULL;
    test_alloc_fail(1, 0);
    CHECK(srv_queue_new(&queue, 2, 2) == PEND_NO_MEMORY && !queue);
    test_alloc_faults_off();
    REQUIRE(srv_queue_new(&queue, 2, 2) == PEND_OK);
    test_alloc_fail(1, 0);
    CHECK(srv_workers_new(&workers, 2, queue, NULL) == PEND_NO_MEMORY && !workers);
    test_alloc_faults_off();
}
