/* Tests of server/base/turns; that of the queue has levels and bounds too. */
#include "server/base/turns.h"

#include <stdlib.h>

#include "tests/harness/test.h"

enum { ROADS = 3, LANES = 4, EACH = 5 };

struct waiter {
    struct srv_list link;
    int road, lane, number;
};

struct street {
    struct srv_turns_road road;
    struct srv_turns_lane lane[LANES];
};

static struct waiter *waiter_take(struct srv_turns *turns, struct street street[]) {
    struct srv_list *link = srv_turns_next(turns);
    if (!link) return NULL;
    struct waiter *waiter = SRV_CONTAINER_OF(link, struct waiter, link);
    struct street *at = &street[waiter->road];
    srv_turns_remove(&at->road, &at->lane[waiter->lane], link);
    return waiter;
}

/* Road 0 has four lanes, road 1 one, road 2 one whose waiting link is removed before its turn. */
TEST(roads_take_turns_as_many_in_a_row_as_they_have_lanes) {
    struct srv_turns turns = {0};
    struct street street[ROADS] = {0};
    struct waiter waiter[LANES][2] = {0}, other[2] = {0}, gone = {.road = 2};
    /* In the second round the lanes become empty, and their road's turns end with them. */
    static const int order[][2] = {{0, 0}, {0, 1}, {0, 2}, {0, 3}, {1, 0},
                                   {0, 0}, {0, 1}, {0, 2}, {1, 0}, {0, 3}};
    for (int k = 0; k < 2; k++) {
        for (int i = 0; i < LANES; i++) {
            waiter[i][k] = (struct waiter){.lane = i, .number = k};
            srv_turns_add(&turns, &street[0].road, &street[0].lane[i], &waiter[i][k].link);
        }
        other[k] = (struct waiter){.road = 1, .number = k};
        srv_turns_add(&turns, &street[1].road, &street[1].lane[0], &other[k].link);
    }
    srv_turns_add(&turns, &street[2].road, &street[2].lane[0], &gone.link);
    srv_turns_remove(&street[2].road, &street[2].lane[0], &gone.link);
    for (int i = 0; i < 2 * LANES + 2; i++) {
        const struct waiter *next = waiter_take(&turns, street);
        REQUIRE(next);
        CHECK(next->road == order[i][0] && next->lane == order[i][1]);
        CHECK_INT(next->number, i > LANES);
    }
    CHECK(!waiter_take(&turns, street));
}

/* For any order of arrivals and removals: the links of a lane are returned in their order, and
 * while a road waits no other has more than SRV_TURNS_ROW turns before it. */
TEST(turns_are_kept_whatever_comes_and_goes) {
    struct srv_turns turns = {0};
    struct street street[ROADS] = {0};
    static struct waiter waiter[ROADS][LANES][EACH];
    int in[ROADS][LANES] = {0}, out[ROADS][LANES] = {0}, waits[ROADS] = {0};
    int passed[ROADS][ROADS] = {0}; /* turns of a road since another began to wait or had a turn */
    srand(7);
    for (int step = 0; step < 3000; step++) {
        int r = rand() % ROADS, i = rand() % LANES;
        if (rand() % 2 && in[r][i] - out[r][i] < EACH) {
            struct waiter *new = &waiter[r][i][in[r][i] % EACH];
            *new = (struct waiter){.road = r, .lane = i, .number = in[r][i]++};
            for (int other = 0; !waits[r] && other < ROADS; other++) passed[r][other] = 0;
            waits[r]++;
            srv_turns_add(&turns, &street[r].road, &street[r].lane[i], &new->link);
            continue;
        }
        const struct waiter *next = waiter_take(&turns, street);
        if (!next) continue;
        r = next->road;
        CHECK_INT(next->number, out[r][next->lane]++);
        waits[r]--;
        for (int other = 0; other < ROADS; other++) {
            passed[r][other] = 0;
            if (other == r || !waits[other]) continue;
            if (!CHECK(++passed[other][r] <= SRV_TURNS_ROW)) return;
        }
    }
    while (waiter_take(&turns, street))
        ;
    for (int r = 0; r < ROADS; r++) CHECK(!street[r].road.busy && !street[r].road.link.next);
}
