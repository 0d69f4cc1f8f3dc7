/* Tests of server/intake. */
#include "server/intake.h"

#include <pthread.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include "tests/harness/server.h"
#include "tests/harness/test.h"

struct nap {
    struct srv_intake intake;
    struct srv_queue *queue;
    int fd;
    pthread_t thread;
    atomic_int stop;
    atomic_long naps;
};

static void nap_begin(struct nap *nap, int workers) {
    *nap = (struct nap){.fd = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)};
    REQUIRE(nap->fd >= 0 && srv_queue_new(&nap->queue, 4, 4) == PEND_OK);
    srv_intake_init(&nap->intake, nap->queue, workers);
}

static void nap_end(struct nap *nap) {
    CHECK(!atomic_load(&nap->intake.computing) && !atomic_load(&nap->intake.napping));
    srv_intake_clear(&nap->intake);
    srv_queue_free(&nap->queue);
    close(nap->fd);
}

/* the shortest of some naps, s: a busy machine makes single ones long */
static double nap_seconds(struct nap *nap) {
    double least = 1;
    for (int i = 0; i < 20; i++) {
        double begin = test_clock();
        srv_intake_nap(&nap->intake, nap->fd);
        double seconds = test_clock() - begin;
        if (seconds < least) least = seconds;
    }
    return least;
}

TEST(the_sockets_thread_naps_only_while_every_worker_has_a_short_task) {
    struct nap nap;
    struct srv_lane lane = {0};
    struct srv_task task = {.lane = &lane};
    nap_begin(&nap, 2);
    CHECK(nap_seconds(&nap) < 0.0003);
    srv_intake_begin(&nap.intake, 0);
    CHECK(nap_seconds(&nap) < 0.0003);
    srv_intake_begin(&nap.intake, 3);
    CHECK(nap_seconds(&nap) < 0.0003);
    CHECK(srv_queue_push(nap.queue, &task) == PEND_OK);
    double seconds = nap_seconds(&nap);
    CHECK_SAYING(seconds >= 0.0009 && seconds < 0.1, "a nap of %g s", seconds);
    CHECK(srv_queue_pop(nap.queue) == &task);
    CHECK(nap_seconds(&nap) < 0.0003);
    srv_intake_end(&nap.intake, 3);
    srv_intake_end(&nap.intake, 0);
    nap_end(&nap);
}

static void *nap_on(void *argument) {
    struct nap *nap = argument;
    while (!atomic_load(&nap->stop)) {
        srv_intake_nap(&nap->intake, nap->fd);
        atomic_fetch_add(&nap->naps, 1);
    }
    return NULL;
}

/* naps while a worker does `looks` looks in a tenth of a second */
static long nap_count(struct nap *nap, int look) {
    long before = atomic_load(&nap->naps);
    for (double end = test_clock() + 0.1; test_clock() < end;)
        if (look) srv_intake_look(&nap->intake);
    return atomic_load(&nap->naps) - before;
}

TEST(a_worker_that_looks_wakes_the_thread_only_when_something_came) {
    struct nap nap;
    nap_begin(&nap, 1);
    srv_intake_begin(&nap.intake, 0);
    REQUIRE(!pthread_create(&nap.thread, NULL, nap_on, &nap));
    while (atomic_load(&nap.intake.fd) < 0) continue;
    CHECK(nap_count(&nap, 0) <= 101);
    CHECK(nap_count(&nap, 1) <= 101);
    CHECK(eventfd_write(nap.fd, 1) == 0);
    long most = 0;
    for (int i = 0; i < 10 && most <= 101; i++) {
        long naps = nap_count(&nap, 1);
        if (naps > most) most = naps;
    }
    CHECK_SAYING(most > 101 && most <= 251, "%ld naps in 0.1 s", most);
    atomic_store(&nap.stop, 1);
    pthread_join(nap.thread, NULL);
    srv_intake_end(&nap.intake, 0);
    nap_end(&nap);
}

TEST(naps_and_wakes_that_meet_lose_nothing) {
    struct nap nap;
    nap_begin(&nap, 1);
    REQUIRE(!pthread_create(&nap.thread, NULL, nap_on, &nap));
    for (double end = test_clock() + 0.3; test_clock() < end;) {
        srv_intake_begin(&nap.intake, 0);
        for (int i = 0; i < 100; i++) atomic_signal_fence(memory_order_seq_cst);
        srv_intake_end(&nap.intake, 0);
    }
    atomic_store(&nap.stop, 1);
    pthread_join(nap.thread, NULL);
    int left = -1;
    CHECK(sem_getvalue(&nap.intake.wake, &left) == 0 && left == 0);
    nap_end(&nap);
}
