#include "server/queue.h"

#include <assert.h>
#include <pthread.h>
#include <stdlib.h>

/* The ring of waiting tasks closes in `ring`, whose next is the first and whose previous is the last. */
struct srv_queue {
    pthread_mutex_t lock;
    pthread_cond_t some;
    struct srv_task ring;
    int count, cap, closed;
};

enum pend_status srv_queue_new(struct srv_queue **queue, int cap) {
    struct srv_queue *made = *queue = calloc(1, sizeof *made);
    if (!made) return PEND_NO_MEMORY;
    pthread_mutex_init(&made->lock, NULL);
    pthread_cond_init(&made->some, NULL);
    made->ring.next = made->ring.previous = &made->ring;
    made->cap = cap;
    return PEND_OK;
}

void srv_queue_free(struct srv_queue **queue) {
    struct srv_queue *gone = *queue;
    *queue = NULL;
    if (!gone) return;
    assert(!gone->count);
    pthread_cond_destroy(&gone->some);
    pthread_mutex_destroy(&gone->lock);
    free(gone);
}

enum pend_status srv_queue_push(struct srv_queue *queue, struct srv_task *task) {
    pthread_mutex_lock(&queue->lock);
    int room = queue->count < queue->cap && !queue->closed;
    if (room) {
        assert(!task->queued);
        task->next = &queue->ring;
        task->previous = queue->ring.previous;
        task->previous->next = queue->ring.previous = task;
        task->queued = 1;
        queue->count++;
        pthread_cond_signal(&queue->some);
    }
    pthread_mutex_unlock(&queue->lock);
    return room ? PEND_OK : PEND_LIMIT;
}

/* called with the lock */
static void queue_unlink(struct srv_queue *queue, struct srv_task *task) {
    task->previous->next = task->next;
    task->next->previous = task->previous;
    task->next = task->previous = NULL;
    task->queued = 0;
    queue->count--;
}

struct srv_task *srv_queue_pop(struct srv_queue *queue) {
    pthread_mutex_lock(&queue->lock);
    while (!queue->count && !queue->closed) pthread_cond_wait(&queue->some, &queue->lock);
    struct srv_task *task = queue->count ? queue->ring.next : NULL;
    if (task) queue_unlink(queue, task);
    pthread_mutex_unlock(&queue->lock);
    return task;
}

int srv_queue_remove(struct srv_queue *queue, struct srv_task *task) {
    pthread_mutex_lock(&queue->lock);
    int there = task->queued;
    if (there) queue_unlink(queue, task);
    pthread_mutex_unlock(&queue->lock);
    return there;
}

int srv_queue_count(struct srv_queue *queue) {
    pthread_mutex_lock(&queue->lock);
    int count = queue->count;
    pthread_mutex_unlock(&queue->lock);
    return count;
}

void srv_queue_close(struct srv_queue *queue) {
    pthread_mutex_lock(&queue->lock);
    queue->closed = 1;
    pthread_cond_broadcast(&queue->some);
    pthread_mutex_unlock(&queue->lock);
}

int srv_queue_valid(struct srv_queue *queue) {
    int count = 0, good = 1;
    pthread_mutex_lock(&queue->lock);
    for (struct srv_task *task = queue->ring.next; good && task != &queue->ring; task = task->next, count++)
        good = task->queued && task->next->previous == task && count < queue->count;
    good = good && count == queue->count && count <= queue->cap;
    pthread_mutex_unlock(&queue->lock);
    return good;
}
