#include "core/ensemble/member.h"

#include <assert.h>

struct pend_tree pend_member_tree(const struct pend_tree *shape, const struct pend_member *member,
                                  double subtree[]) {
    struct pend_tree tree = *shape;
    assert(shape->n >= 1);
    tree.len = member->length, tree.mass = member->mass, tree.subtree_mass = subtree;
    tree.length_total = 0;
    for (int i = 0; i < tree.n; i++) tree.length_total += tree.len[tree.place[i]];
    for (int k = 0; k < tree.n; k++) subtree[k] = tree.mass[k];
    for (int k = tree.n - 1; k > 0; k--) subtree[tree.parent[k]] += subtree[k];
    return tree;
}
