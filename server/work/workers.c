#include "server/work/workers.h"

#include <pthread.h>
#include <sched.h>
#include <stdlib.h>

struct srv_workers {
    struct srv_queue *queue;
    struct srv_fairness *fairness;
    int count; /* number of threads; the first one is the reader */
    pthread_t thread[];
};

int srv_workers_default(void) {
    cpu_set_t set;
    int count = sched_getaffinity(0, sizeof set, &set) ? 1 : CPU_COUNT(&set);
    return count > 1 ? count : 1;
}

static void *workers_main(void *argument) {
    const struct srv_workers *workers = argument;
    for (struct srv_task *task = srv_queue_pop(workers->queue); task;) {
        int level = task->level;
        if (workers->fairness) srv_fairness_begin(workers->fairness, level);
        int again = task->run(task);
        if (workers->fairness) srv_fairness_end(workers->fairness, level);
        task = again ? srv_queue_swap(workers->queue, task) : srv_queue_pop(workers->queue);
    }
    return NULL;
}

/* The reader's thread: after a body is read, its task continues at another level. */
static void *workers_read(void *argument) {
    const struct srv_workers *workers = argument;
    for (struct srv_task *task; (task = srv_queue_pop_read(workers->queue));)
        if (task->run(task)) srv_queue_again(workers->queue, task);
    return NULL;
}

enum pend_status srv_workers_new(struct srv_workers **workers, int count, struct srv_queue *queue,
                                 struct srv_fairness *fairness) {
    struct srv_workers *made = *workers =
        calloc(1, sizeof *made + (size_t)(1 + count) * sizeof *made->thread);
    if (!made) return PEND_NO_MEMORY;
    made->queue = queue;
    made->fairness = fairness;
    while (made->count <= count && !pthread_create(&made->thread[made->count], NULL,
                                                   made->count ? workers_main : workers_read, made))
        made->count++;
    if (made->count > count) return PEND_OK;
    srv_workers_free(workers);
    return PEND_NO_MEMORY;
}

void srv_workers_free(struct srv_workers **workers) {
    struct srv_workers *gone = *workers;
    *workers = NULL;
    if (!gone) return;
    srv_queue_close(gone->queue);
    for (int i = 0; i < gone->count; i++) pthread_join(gone->thread[i], NULL);
    /* The reader may have queued tasks after the last worker ended. */
    workers_main(gone);
    free(gone);
}
