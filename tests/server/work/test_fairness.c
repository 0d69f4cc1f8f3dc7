/* Tests of server/work/fairness. */
#include "server/work/fairness.h"

#include <pthread.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include "tests/harness/server.h"
#include "tests/harness/test.h"

struct nap {
    struct srv_fairness fairness;
    struct srv_queue *queue;
    int fd;
    pthread_t thread;
    atomic_int stop;
    atomic_long least; /* us, the shortest nap */
};

static void nap_begin(struct nap *nap, int workers) {
    *nap = (struct nap){.fd = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)};
    REQUIRE(nap->fd >= 0 && srv_queue_new(&nap->queue, 4, 4) == PEND_OK);
    srv_fairness_init(&nap->fairness, nap->queue, workers);
}

static void nap_end(struct nap *nap) {
    CHECK(!atomic_load(&nap->fairness.computing) && !atomic_load(&nap->fairness.napping));
    srv_fairness_clear(&nap->fairness);
    srv_queue_free(&nap->queue);
    close(nap->fd);
}

enum { NAPS = 20, MOST_NAPS = 1000 };

/* the shortest of some naps, s: a busy machine makes single ones long, a slow one many */
static double nap_seconds(struct nap *nap) {
    double least = 1;
    for (int i = 0; i < NAPS || (least > 0.0003 && least < 0.0009 && i < MOST_NAPS); i++) {
        double begin = test_clock();
        srv_fairness_nap(&nap->fairness, nap->fd);
        double seconds = test_clock() - begin;
        if (seconds < least) least = seconds;
    }
    return least;
}

TEST(the_sockets_thread_naps_only_while_every_worker_has_a_short_task) {
    OWN(nap, end) nap;
    struct srv_lane lane = {0};
    struct srv_task task = {.lane = &lane};
    nap_begin(&nap, 2);
    CHECK(nap_seconds(&nap) < 0.0003);
    srv_fairness_begin(&nap.fairness, 0);
    CHECK(nap_seconds(&nap) < 0.0003);
    srv_fairness_begin(&nap.fairness, 3);
    CHECK(nap_seconds(&nap) < 0.0003);
    CHECK(srv_queue_push(nap.queue, &task) == PEND_OK);
    double seconds = nap_seconds(&nap);
    CHECK_SAYING(seconds >= 0.0045 && seconds < 1, "a nap of %g s", seconds);
    CHECK(srv_queue_pop(nap.queue) == &task);
    CHECK(nap_seconds(&nap) < 0.0003);
    srv_fairness_end(&nap.fairness, 3);
    srv_fairness_end(&nap.fairness, 0);
}

static void *nap_on(void *argument) {
    struct nap *nap = argument;
    while (!atomic_load(&nap->stop)) {
        double begin = test_clock();
        srv_fairness_nap(&nap->fairness, nap->fd);
        long us = (long)((test_clock() - begin) * 1e6);
        if (us < atomic_load(&nap->least)) atomic_store(&nap->least, us);
    }
    return NULL;
}

/* the shortest nap, us, while a worker checks or does not, for 0.1 s; for longer until it is below
 * `below` */
static long nap_least(struct nap *nap, int look, long below) {
    double begin = test_clock();
    atomic_store(&nap->least, 1000000);
    while (test_clock() < begin + 0.1 ||
           (atomic_load(&nap->least) >= below && test_clock() < begin + TEST_PATIENCE))
        if (look) srv_fairness_look(&nap->fairness);
    return atomic_load(&nap->least);
}

TEST(a_worker_that_looks_wakes_the_thread_only_when_something_came) {
    OWN(nap, end) nap;
    nap_begin(&nap, 1);
    srv_fairness_begin(&nap.fairness, 0);
    REQUIRE(!pthread_create(&nap.thread, NULL, nap_on, &nap));
    while (atomic_load(&nap.fairness.fd) < 0) continue;
    long quiet = nap_least(&nap, 0, 1000000), vain = nap_least(&nap, 1, 1000000);
    CHECK(eventfd_write(nap.fd, 1) == 0);
    long unseen = nap_least(&nap, 0, 1000000), seen = nap_least(&nap, 1, 900);
    CHECK_SAYING(quiet >= 4500 && vain >= 4500 && unseen >= 4500 && seen < 900,
                 "naps of %ld, %ld, %ld, %ld us", quiet, vain, unseen, seen);
    atomic_store(&nap.stop, 1);
    pthread_join(nap.thread, NULL);
    srv_fairness_end(&nap.fairness, 0);
}

TEST(naps_and_wakes_that_meet_lose_nothing) {
    OWN(nap, end) nap;
    nap_begin(&nap, 1);
    REQUIRE(!pthread_create(&nap.thread, NULL, nap_on, &nap));
    for (double end = test_clock() + 0.3; test_clock() < end;) {
        srv_fairness_begin(&nap.fairness, 0);
        for (int i = 0; i < 100; i++) atomic_signal_fence(memory_order_seq_cst);
        srv_fairness_end(&nap.fairness, 0);
    }
    atomic_store(&nap.stop, 1);
    pthread_join(nap.thread, NULL);
    int left = -1;
    CHECK(sem_getvalue(&nap.fairness.wake, &left) == 0 && left == 0);
}
