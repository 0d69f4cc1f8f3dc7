/* Tests of server/base/condition. */
#include "server/base/condition.h"

#include "server/base/clock.h"
#include "tests/harness/test.h"

struct room {
    pthread_mutex_t lock;
    pthread_cond_t some;
    int there;
};

static void room_init(struct room *room) {
    room->there = 0;
    pthread_mutex_init(&room->lock, NULL);
    srv_condition_init(&room->some);
}

static void room_clear(struct room *room) {
    pthread_cond_destroy(&room->some);
    pthread_mutex_destroy(&room->lock);
}

static void *room_enter(void *context) {
    struct room *room = context;
    pthread_mutex_lock(&room->lock);
    room->there = 1;
    pthread_cond_signal(&room->some);
    pthread_mutex_unlock(&room->lock);
    return NULL;
}

TEST(a_wait_ends_at_its_instant_and_not_before) {
    OWN(room, clear) room;
    room_init(&room);
    pthread_mutex_lock(&room.lock);
    int64_t until = srv_clock_now() + 20000000;
    while (srv_condition_wait(&room.some, &room.lock, until)) continue;
    CHECK(srv_clock_now() >= until);
    /* the wait returns at once if the instant has passed */
    CHECK(!srv_condition_wait(&room.some, &room.lock, 0));
    CHECK(!srv_condition_wait(&room.some, &room.lock, until));
    pthread_mutex_unlock(&room.lock);
}

TEST(a_signal_ends_a_wait_that_has_no_instant_or_a_late_one) {
    for (int late = 0; late < 2; late++) {
        OWN(room, clear) room;
        pthread_t thread;
        room_init(&room);
        int64_t until = late ? srv_clock_now() + srv_clock_span(600) : SRV_CONDITION_NEVER;
        pthread_mutex_lock(&room.lock);
        REQUIRE(!pthread_create(&thread, NULL, room_enter, &room));
        int early = 1;
        while (!room.there && early) early = srv_condition_wait(&room.some, &room.lock, until);
        CHECK(room.there && early);
        pthread_mutex_unlock(&room.lock);
        pthread_join(thread, NULL);
    }
}
