/* Tests of server/base/list and server/base/container_of. */
#include "server/base/list.h"

#include "tests/harness/test.h"

struct thing {
    int number;
    struct srv_list link, other;
};

static struct thing *thing_of(struct srv_list *link) {
    return SRV_CONTAINER_OF(link, struct thing, link);
}

/* the numbers of a list's things as digits; -1 if a link is wrong */
static int things(const struct srv_list *list) {
    int digits = 0;
    SRV_LIST_EACH (link, list) {
        if (!srv_list_valid(link)) return -1;
        digits = 10 * digits + thing_of(link)->number;
    }
    return srv_list_valid(list) ? digits : -1;
}

TEST(a_member_leads_to_the_structure_that_it_lies_in) {
    struct thing thing = {.number = 7};
    CHECK(SRV_CONTAINER_OF(&thing.link, struct thing, link) == &thing);
    CHECK(SRV_CONTAINER_OF(&thing.other, struct thing, other) == &thing);
    CHECK(SRV_CONTAINER_OF(&thing.number, struct thing, number) == &thing);
}

TEST(a_list_keeps_the_order_in_which_links_were_put_in) {
    struct srv_list list = {0};
    struct thing thing[4] = {{.number = 1}, {.number = 2}, {.number = 3}, {.number = 4}};
    CHECK(srv_list_empty(&list) && !srv_list_take(&list));
    CHECK_INT(things(&list), 0);
    srv_list_append(&list, &thing[1].link);
    srv_list_append(&list, &thing[2].link);
    srv_list_insert(&list, &thing[0].link);
    CHECK_INT(things(&list), 123);
    srv_list_insert(&thing[1].link, &thing[3].link);
    CHECK_INT(things(&list), 1243);
    srv_list_remove(&thing[1].link);
    CHECK_INT(things(&list), 143);
    CHECK(!thing[1].link.next && !thing[1].link.previous && srv_list_valid(&thing[1].link));
    CHECK(thing_of(srv_list_take(&list)) == &thing[0]);
    CHECK(thing_of(srv_list_take(&list)) == &thing[3]);
    CHECK(!srv_list_empty(&list));
    CHECK(thing_of(srv_list_take(&list)) == &thing[2]);
    CHECK(srv_list_empty(&list) && !srv_list_take(&list));
    CHECK_INT(things(&list), 0);
}

TEST(a_list_is_moved_behind_another_and_is_empty_then) {
    struct srv_list from = {0}, to = {0};
    struct thing thing[3] = {{.number = 1}, {.number = 2}, {.number = 3}};
    srv_list_move(&from, &to);
    CHECK(srv_list_empty(&to));
    srv_list_append(&to, &thing[0].link);
    srv_list_append(&from, &thing[1].link);
    srv_list_append(&from, &thing[2].link);
    srv_list_move(&from, &to);
    CHECK(srv_list_empty(&from));
    CHECK_INT(things(&to), 123);
}

TEST(an_object_is_in_several_lists_by_several_links) {
    struct srv_list one = {0}, two = {0};
    struct thing thing = {.number = 5};
    srv_list_append(&one, &thing.link);
    srv_list_append(&two, &thing.other);
    srv_list_remove(&thing.link);
    CHECK(srv_list_empty(&one) && two.next == &thing.other);
}

TEST(a_link_whose_neighbour_does_not_lead_back_is_not_valid) {
    struct srv_list list = {0};
    struct thing thing[2] = {{.number = 1}, {.number = 2}};
    srv_list_append(&list, &thing[0].link);
    srv_list_append(&list, &thing[1].link);
    thing[0].link.next = &list;
    CHECK(!srv_list_valid(&thing[0].link) && !srv_list_valid(&thing[1].link));
}
