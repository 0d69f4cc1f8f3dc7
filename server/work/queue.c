#include "server/work/queue.h"

#include <pthread.h>
#include <semaphore.h>
#include <stdatomic.h>
#include <stdlib.h>

/* Workers wait for a semaphore, whose count is at least the number of tasks. A condition variable
 * would do, but the one of the C library before 2.41 can lose a signal if several threads wait
 * (its bug 25847); a task would then stay in the queue until the next one arrives. */
struct srv_queue {
    pthread_mutex_t lock;
    sem_t some, read; /* `some` wakes workers, `read` wakes the reader */
    struct srv_turns level[SRV_QUEUE_LINES];
    int cap, lane_cap, closed;
    unsigned turn;                         /* the number of tasks taken so far */
    atomic_int count, at[SRV_QUEUE_LINES]; /* the number of waiting tasks, in total and per level */
};

static struct srv_road *queue_road_of(struct srv_lane *lane) {
    return lane->road ? lane->road : &lane->own;
}

/* --- the queue --- */

enum pend_status srv_queue_new(struct srv_queue **queue, int cap, int lane_cap) {
    struct srv_queue *made = *queue = calloc(1, sizeof *made);
    if (!made) return PEND_NO_MEMORY;
    pthread_mutex_init(&made->lock, NULL);
    sem_init(&made->some, 0, 0);
    sem_init(&made->read, 0, 0);
    assert(cap >= 1 && lane_cap >= 1);
    made->cap = cap;
    made->lane_cap = lane_cap;
    return PEND_OK;
}

void srv_queue_bound(struct srv_queue *queue, int cap, int lane_cap) {
    assert(cap >= 1 && lane_cap >= 1);
    pthread_mutex_lock(&queue->lock);
    queue->cap = cap;
    queue->lane_cap = lane_cap;
    pthread_mutex_unlock(&queue->lock);
}

void srv_queue_free(struct srv_queue **queue) {
    struct srv_queue *gone = *queue;
    *queue = NULL;
    if (!gone) return;
    assert(srv_queue_valid(gone) && !srv_queue_count(gone));
    sem_destroy(&gone->some);
    sem_destroy(&gone->read);
    pthread_mutex_destroy(&gone->lock);
    free(gone);
}

static void queue_count(struct srv_queue *queue, const struct srv_task *task, int change) {
    assert(task->level >= 0 && task->level < SRV_QUEUE_LINES);
    task->lane->count += change;
    queue_road_of(task->lane)->count += change;
    atomic_fetch_add_explicit(&queue->count, change, memory_order_relaxed);
    atomic_fetch_add_explicit(&queue->at[task->level], change, memory_order_relaxed);
    assert(task->lane->count >= 0 && queue_road_of(task->lane)->count >= task->lane->count);
    assert(srv_queue_count(queue) >= srv_queue_waiting(queue, task->level));
    assert(srv_queue_waiting(queue, task->level) >= 0);
}

/* The caller holds the lock. */
static void queue_add(struct srv_queue *queue, struct srv_task *task) {
    struct srv_lane *lane = task->lane;
    assert(!task->queued && lane && task->level >= 0 && task->level < SRV_QUEUE_LINES);
    srv_turns_add(&queue->level[task->level], &queue_road_of(lane)->at[task->level],
                  &lane->at[task->level], &task->link);
    task->queued = 1;
    queue_count(queue, task, 1);
}

/* The caller holds the lock. */
static void queue_unlink(struct srv_queue *queue, struct srv_task *task) {
    struct srv_lane *lane = task->lane;
    assert(task->queued && lane->count > 0);
    srv_turns_remove(&queue_road_of(lane)->at[task->level], &lane->at[task->level], &task->link);
    task->queued = 0;
    queue_count(queue, task, -1);
}

static void queue_tell(struct srv_queue *queue, int level) {
    sem_post(level == SRV_QUEUE_READ ? &queue->read : &queue->some);
}

static int queue_road_cap(const struct srv_queue *queue) {
    int most = queue->cap - queue->cap / 4;
    return most > queue->lane_cap ? most : queue->lane_cap;
}

enum pend_status srv_queue_push(struct srv_queue *queue, struct srv_task *task) {
    enum pend_status status = PEND_OK;
    int level = task->level;
    pthread_mutex_lock(&queue->lock);
    if (srv_queue_count(queue) >= queue->cap || queue->closed)
        status = PEND_LIMIT;
    else if (task->lane->count >= queue->lane_cap ||
             queue_road_of(task->lane)->count >= queue_road_cap(queue))
        status = PEND_INVALID;
    else
        queue_add(queue, task);
    task->road_full = status == PEND_INVALID && task->lane->count < queue->lane_cap;
    pthread_mutex_unlock(&queue->lock);
    if (status == PEND_OK) queue_tell(queue, level);
    return status;
}

void srv_queue_again(struct srv_queue *queue, struct srv_task *task) {
    pthread_mutex_lock(&queue->lock);
    int level = task->level;
    queue_add(queue, task);
    pthread_mutex_unlock(&queue->lock);
    queue_tell(queue, level);
}

/* The level whose turn it is. The caller holds the lock, and there is a task. */
static int queue_level(struct srv_queue *queue) {
    unsigned turn = queue->turn++;
    int first = turn % SRV_QUEUE_SHARE == SRV_QUEUE_SHARE - 1
                    ? (int)(turn / SRV_QUEUE_SHARE % SRV_QUEUE_LEVELS)
                    : 0;
    while (srv_list_empty(&queue->level[first].roads)) first = (first + 1) % SRV_QUEUE_LEVELS;
    return first;
}

/* Takes the next task of a level. The caller holds the lock. */
static struct srv_task *queue_take(struct srv_queue *queue, int level) {
    struct srv_task *task =
        SRV_CONTAINER_OF(srv_turns_next(&queue->level[level]), struct srv_task, link);
    queue_unlink(queue, task);
    return task;
}

/* Waits for a task, of any level except SRV_QUEUE_READ, or only of that level. */
static struct srv_task *queue_pop(struct srv_queue *queue, int reads) {
    struct srv_task *task = NULL;
    sem_t *some = reads ? &queue->read : &queue->some;
    int closed = 0;
    while (!task && !closed) {
        if (sem_wait(some)) continue;
        pthread_mutex_lock(&queue->lock);
        /* There is no task if it was withdrawn meanwhile. */
        if (reads ? srv_queue_waiting(queue, SRV_QUEUE_READ)
                  : srv_queue_shorter(queue, SRV_QUEUE_LEVELS))
            task = queue_take(queue, reads ? SRV_QUEUE_READ : queue_level(queue));
        closed = queue->closed;
        pthread_mutex_unlock(&queue->lock);
    }
    /* The next worker must find the queue closed, too. */
    if (!task) sem_post(some);
    return task;
}

struct srv_task *srv_queue_pop(struct srv_queue *queue) {
    return queue_pop(queue, 0);
}

struct srv_task *srv_queue_pop_read(struct srv_queue *queue) {
    return queue_pop(queue, 1);
}

struct srv_task *srv_queue_swap(struct srv_queue *queue, struct srv_task *task) {
    pthread_mutex_lock(&queue->lock);
    queue_add(queue, task);
    struct srv_task *next = queue_take(queue, queue_level(queue));
    pthread_mutex_unlock(&queue->lock);
    return next;
}

int srv_queue_remove(struct srv_queue *queue, struct srv_task *task) {
    pthread_mutex_lock(&queue->lock);
    int there = task->queued;
    if (there) queue_unlink(queue, task);
    pthread_mutex_unlock(&queue->lock);
    return there;
}

int srv_queue_count(const struct srv_queue *queue) {
    return atomic_load_explicit(&queue->count, memory_order_relaxed);
}

int srv_queue_waiting(const struct srv_queue *queue, int level) {
    return atomic_load_explicit(&queue->at[level], memory_order_relaxed);
}

int srv_queue_shorter(const struct srv_queue *queue, int level) {
    int shorter = 0;
    while (level-- > 0) shorter |= srv_queue_waiting(queue, level) > 0;
    return shorter;
}

void srv_queue_close(struct srv_queue *queue) {
    pthread_mutex_lock(&queue->lock);
    queue->closed = 1;
    pthread_mutex_unlock(&queue->lock);
    sem_post(&queue->some);
    sem_post(&queue->read);
}

static struct srv_road *queue_road(struct srv_list *link, int level) {
    return SRV_CONTAINER_OF(link, struct srv_road, at[level].link);
}

/* Returns the number of tasks of a lane at a level, -1 if a link is wrong. Visits at most `most`
 * tasks. */
static int queue_lane_valid(const struct srv_lane *lane, int level, int most) {
    int count = 0;
    SRV_LIST_EACH (link, &lane->at[level].waiting) {
        const struct srv_task *task = SRV_CONTAINER_OF(link, struct srv_task, link);
        if (!srv_list_valid(link) || !task->queued || task->lane != lane || task->level != level)
            return -1;
        if (++count > most) return -1;
    }
    return count ? count : -1;
}

/* Returns the number of tasks of a road at a level, -1 if a link or a count is wrong. */
static int queue_road_valid(struct srv_road *road, int level, int most) {
    int count = 0, busy = 0;
    SRV_LIST_EACH (link, &road->at[level].lanes) {
        struct srv_lane *lane = SRV_CONTAINER_OF(link, struct srv_lane, at[level].link);
        int some = queue_lane_valid(lane, level, most);
        if (some < 0 || !srv_list_valid(link) || queue_road_of(lane) != road || ++busy > most)
            return -1;
        count += some;
    }
    return busy == road->at[level].busy && count <= road->count ? count : -1;
}

int srv_queue_valid(struct srv_queue *queue) {
    int all = 0, good = 1;
    pthread_mutex_lock(&queue->lock);
    int most = srv_queue_count(queue);
    for (int level = 0; level < SRV_QUEUE_LINES; level++) {
        SRV_LIST_EACH (link, &queue->level[level].roads) {
            int count = queue_road_valid(queue_road(link, level), level, most);
            good = good && count > 0 && srv_list_valid(link);
            all += count;
            if (!good) break;
        }
    }
    pthread_mutex_unlock(&queue->lock);
    return good && all == most;
}
