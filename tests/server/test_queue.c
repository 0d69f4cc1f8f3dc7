/* Tests of server/queue and server/workers. */
#include "server/queue.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>

#include "server/workers.h"
#include "tests/harness/server.h"
#include "tests/harness/test.h"

TEST(a_queue_is_first_in_first_out_and_bounded) {
    struct srv_queue *queue;
    struct srv_task task[4] = {0};
    REQUIRE(srv_queue_new(&queue, 3) == PEND_OK);
    for (int round = 0; round < 3; round++) {
        for (int i = 0; i < 3; i++) CHECK(srv_queue_push(queue, &task[i]) == PEND_OK);
        CHECK(srv_queue_push(queue, &task[3]) == PEND_LIMIT && !task[3].queued);
        CHECK_INT(srv_queue_count(queue), 3);
        CHECK(srv_queue_valid(queue));
        for (int i = 0; i < 3; i++) CHECK(srv_queue_pop(queue) == &task[i]);
        CHECK(srv_queue_valid(queue) && srv_queue_count(queue) == 0);
    }
    srv_queue_free(&queue);
    CHECK(queue == NULL);
    srv_queue_free(&queue);
}

TEST(a_task_can_be_taken_out_of_the_middle_once) {
    struct srv_queue *queue;
    struct srv_task task[3] = {0};
    REQUIRE(srv_queue_new(&queue, 3) == PEND_OK);
    for (int i = 0; i < 3; i++) CHECK(srv_queue_push(queue, &task[i]) == PEND_OK);
    CHECK_INT(srv_queue_remove(queue, &task[1]), 1);
    CHECK_INT(srv_queue_remove(queue, &task[1]), 0);
    CHECK(srv_queue_valid(queue));
    CHECK(srv_queue_pop(queue) == &task[0] && srv_queue_pop(queue) == &task[2]);
    CHECK_INT(srv_queue_remove(queue, &task[0]), 0);
    srv_queue_close(queue);
    CHECK(srv_queue_pop(queue) == NULL);
    CHECK(srv_queue_push(queue, &task[0]) == PEND_LIMIT);
    srv_queue_free(&queue);
}

TEST(random_pushes_pops_and_removals_keep_a_queue_whole) {
    enum { TASKS = 40 };
    struct srv_queue *queue;
    struct srv_task task[TASKS] = {0};
    int order[TASKS], waiting = 0;
    unsigned long long random = 3;
    REQUIRE(srv_queue_new(&queue, TASKS / 2) == PEND_OK);
    for (int round = 0; round < 20000; round++) {
        int i = test_random_int(&random, TASKS), at = 0, act = test_random_int(&random, 3), good = 1;
        while (at < waiting && order[at] != i) at++;
        int there = at < waiting;
        if (act == 0 && !there) {
            int room = waiting < TASKS / 2;
            good = (srv_queue_push(queue, &task[i]) == PEND_OK) == room;
            if (room) order[waiting++] = i;
        } else if (act == 1 && waiting) {
            good = srv_queue_pop(queue) == &task[order[0]];
            for (int k = 1; k < waiting; k++) order[k - 1] = order[k];
            waiting--;
        } else if (act == 2) {
            good = srv_queue_remove(queue, &task[i]) == there;
            for (int k = at + 1; k < waiting; k++) order[k - 1] = order[k];
            waiting -= there;
        }
        if (!CHECK(good && srv_queue_valid(queue) && srv_queue_count(queue) == waiting)) break;
    }
    while (waiting--) srv_queue_pop(queue);
    srv_queue_free(&queue);
}

static atomic_int task_runs;

struct task_count {
    struct srv_task task;
    atomic_int runs;
};

static void task_run(struct srv_task *task) {
    atomic_fetch_add(&((struct task_count *)task)->runs, 1);
    atomic_fetch_add(&task_runs, 1);
}

TEST(workers_run_every_task_once) {
    enum { TASKS = 5000, CAP = 16 };
    struct srv_queue *queue;
    struct srv_workers *workers;
    struct task_count *task = calloc(TASKS, sizeof *task);
    atomic_store(&task_runs, 0);
    REQUIRE(task && srv_queue_new(&queue, CAP) == PEND_OK);
    REQUIRE(srv_workers_new(&workers, 4, queue) == PEND_OK);
    for (int i = 0; i < TASKS;) {
        task[i].task.run = task_run;
        if (srv_queue_push(queue, &task[i].task) == PEND_OK) i++;
    }
    srv_workers_free(&workers);
    CHECK(workers == NULL);
    CHECK_INT(task_runs, TASKS);
    int wrong = 0;
    for (int i = 0; i < TASKS; i++) wrong += task[i].runs != 1;
    CHECK_INT(wrong, 0);
    srv_queue_free(&queue);
    free(task);
}

TEST(workers_wait_for_tasks_and_are_woken) {
    struct srv_queue *queue;
    struct srv_workers *workers;
    struct task_count task = {.task.run = task_run};
    REQUIRE(srv_queue_new(&queue, 2) == PEND_OK);
    REQUIRE(srv_workers_new(&workers, 2, queue) == PEND_OK);
    test_sleep(0.02);
    CHECK(srv_queue_push(queue, &task.task) == PEND_OK);
    for (double until = test_clock() + 5; !task.runs && test_clock() < until;) test_sleep(0.001);
    CHECK_INT(task.runs, 1);
    srv_workers_free(&workers);
    srv_queue_free(&queue);
}

TEST(there_is_a_worker_for_each_processor_at_least_one) {
    CHECK(srv_workers_default() >= 1 && srv_workers_default() <= 100000);
}

TEST(queue_and_workers_survive_want_of_memory) {
    struct srv_queue *queue = NULL;
    struct srv_workers *workers = NULL;
    test_alloc_fail(1, 0);
    CHECK(srv_queue_new(&queue, 2) == PEND_NO_MEMORY && !queue);
    test_alloc_faults_off();
    REQUIRE(srv_queue_new(&queue, 2) == PEND_OK);
    test_alloc_fail(1, 0);
    CHECK(srv_workers_new(&workers, 2, queue) == PEND_NO_MEMORY && !workers);
    test_alloc_faults_off();
    srv_queue_free(&queue);
}
