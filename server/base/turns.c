#include "server/base/turns.h"

void srv_turns_add(struct srv_turns *turns, struct srv_turns_road *road,
                   struct srv_turns_lane *lane, struct srv_list *link) {
    if (srv_list_empty(&lane->waiting)) {
        if (srv_list_empty(&road->lanes)) srv_list_append(&turns->roads, &road->link);
        srv_list_append(&road->lanes, &lane->link);
        road->busy++;
    }
    srv_list_append(&lane->waiting, link);
}

void srv_turns_remove(struct srv_turns_road *road, struct srv_turns_lane *lane,
                      struct srv_list *link) {
    assert(road->busy > 0 && lane->link.next);
    srv_list_remove(link);
    if (!srv_list_empty(&lane->waiting)) return;
    srv_list_remove(&lane->link);
    road->busy--;
    if (!srv_list_empty(&road->lanes)) return;
    srv_list_remove(&road->link);
    road->turns = 0;
}

struct srv_list *srv_turns_next(struct srv_turns *turns) {
    if (srv_list_empty(&turns->roads)) return NULL;
    struct srv_turns_road *road = SRV_CONTAINER_OF(turns->roads.next, struct srv_turns_road, link);
    struct srv_turns_lane *lane = SRV_CONTAINER_OF(road->lanes.next, struct srv_turns_lane, link);
    int most = road->busy < SRV_TURNS_ROW ? road->busy : SRV_TURNS_ROW;
    /* The lane goes to the end of its road; the road goes to the end of all roads after its last
     * turn. */
    srv_list_remove(&lane->link);
    srv_list_append(&road->lanes, &lane->link);
    if (++road->turns >= most) {
        road->turns = 0;
        srv_list_remove(&road->link);
        srv_list_append(&turns->roads, &road->link);
    }
    return lane->waiting.next;
}
