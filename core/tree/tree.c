#include "core/tree/tree.h"

#include <assert.h>
#include <math.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* the arrays of a tree under construction; pointers into the one block */
struct tree_parts {
    double *len, *mass, *subtree_mass;
    int *parent, *end, *depth, *order, *place;
    unsigned char *kin;
};

struct tree_block {
    struct pend_tree tree; /* the first member, so that its address is the block's */
    double data[];         /* three arrays of n doubles, then five of n ints and one of n bytes */
};

/* counts the faults of an input and reports them */
struct tree_faults {
    const struct pend_fault_sink *sink;
    long count;
};

__attribute__((format(printf, 5, 6))) static void tree_fault(struct tree_faults *faults,
                                                             enum pend_field field, int i, int j,
                                                             const char *format, ...) {
    faults->count++;
    const struct pend_fault_sink *sink = faults->sink;
    if (!sink) return;
    if (sink->worded && faults->count > sink->worded) {
        sink->report(sink->context, field, i, j, NULL);
        return;
    }
    char text[200];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    sink->report(sink->context, field, i, j, text);
}

/* reports every value that is not finite and > 0 (0 is allowed if `bare` says so); returns the sum
 * of the valid ones */
static double tree_check_values(int n, const double value[], const unsigned char bare[],
                                enum pend_field field, const char *plural,
                                struct tree_faults *faults) {
    double sum = 0;
    int bad = 0;
    for (int i = 0; i < n; i++)
        if (isfinite(value[i]) && (value[i] > 0 || (value[i] == 0 && bare && bare[i]))) {
            sum += value[i];
        } else {
            bad++;
            tree_fault(faults, field, i, -1,
                       bare && bare[i] ? "must be a finite number, at least 0, got %.17g"
                       : bare && value[i] == 0
                           ? "must be a finite number greater than 0, got %.17g: it may be 0 where "
                             "the arm has a rod or a body"
                           : "must be a finite number greater than 0, got %.17g",
                       value[i]);
        }
    if (!bad && !isfinite(sum))
        tree_fault(faults, field, -1, -1, "the %s must add up to a finite number", plural);
    return sum;
}

/* the parent if it is the index of an arm, otherwise -1 */
static int tree_parent_arm(int n, int parent) { return parent >= 0 && parent < n ? parent : -1; }

/* reports parents that are not arms, and all arms at the pivot except the first */
static void tree_check_parents(int n, const int parent[], struct tree_faults *faults) {
    int root = -1;
    assert(n >= 1);
    for (int i = 0; i < n; i++) {
        if (parent[i] < -1 || parent[i] >= n)
            tree_fault(faults, PEND_FIELD_PARENT, i, -1,
                       "must be 0 (the pivot) or the number of an arm, 1 to %d", n);
        if (parent[i] != -1) continue;
        if (root >= 0)
            tree_fault(faults, PEND_FIELD_PARENT, i, -1,
                       "only one arm can hang from the pivot (0), and arm %d already does",
                       root + 1);
        else
            root = i;
    }
    if (root < 0)
        tree_fault(faults, PEND_FIELD_PARENT, -1, -1,
                   "one arm must hang from the pivot (0), but none does");
}

/* Lists the arms so that each comes after all arms of its sub-tree; size: the number of arms in
 * each sub-tree. Returns the number of arms listed. An arm that is not listed has waiting > 0; it
 * is in a cycle, or its sub-tree contains a cycle. */
static int tree_list_from_leaves(int n, const int parent[], int waiting[], int size[], int list[]) {
    int listed = 0;
    memset(waiting, 0, (size_t)n * sizeof *waiting);
    for (int i = 0; i < n; i++) {
        size[i] = 1;
        int p = tree_parent_arm(n, parent[i]);
        if (p >= 0) waiting[p]++;
    }
    for (int i = 0; i < n; i++)
        if (!waiting[i]) list[listed++] = i;
    for (int done = 0; done < listed; done++) {
        int i = list[done], p = tree_parent_arm(n, parent[i]);
        if (p < 0) continue;
        size[p] += size[i];
        if (--waiting[p] == 0) list[listed++] = p;
    }
    assert(listed <= n);
    return listed;
}

/* reports one cycle, at its first arm, and marks its arms as visited (waiting = 0) */
static void tree_fault_cycle(const int parent[], int first, int waiting[],
                             struct tree_faults *faults) {
    char names[100] = "";
    size_t used = 0;
    int count = 0, k = first;
    do {
        waiting[k] = 0;
        if (count++ < 8)
            used += (size_t)snprintf(names + used, sizeof names - used, "%d > ", k + 1);
        k = parent[k];
    } while (k != first);
    const char *dots = count > 8 ? "... > " : "";
    if (count == 1)
        tree_fault(faults, PEND_FIELD_PARENT, first, -1, "an arm cannot hang from itself");
    else
        tree_fault(faults, PEND_FIELD_PARENT, first, -1,
                   "a cycle of %d arms that never reaches the pivot: %s%s%d", count, names, dots,
                   first + 1);
}

/* orders the arms depth first: siblings in the caller's order, except that the one with the largest
 * sub-tree is last */
static void tree_place(int n, const int parent[], const int size[], const int list[], int heavy[],
                       int used[], int place[]) {
    for (int i = 0; i < n; i++) heavy[i] = -1, used[i] = 0;
    for (int i = 0; i < n; i++) {
        int p = parent[i];
        if (p >= 0 && (heavy[p] < 0 || size[i] >= size[heavy[p]])) heavy[p] = i;
    }
    // first the offset of an arm's index from its parent's; then, parents first, the index
    for (int i = 0; i < n; i++) {
        int p = parent[i];
        if (p < 0) {
            place[i] = 0;
        } else if (heavy[p] == i) {
            place[i] = size[p] - size[i];
        } else {
            place[i] = 1 + used[p];
            used[p] += size[i];
        }
    }
    for (int done = n - 1; done >= 0; done--) {
        int i = list[done];
        if (parent[i] >= 0) place[i] += place[parent[i]];
    }
}

/* the position of stored arm k among its siblings, and its number of children */
static unsigned char tree_kin(const int parent[], const int end[], int k) {
    int p = parent[k], kin = 0;
    if (end[k] == k + 1)
        kin |= PEND_KIN_LEAF;
    else if (end[k + 1] != end[k])
        kin |= PEND_KIN_FORK;
    if (p == k - 1) kin |= PEND_KIN_FIRST;
    if (p < 0 || end[p] == end[k]) kin |= PEND_KIN_LAST;
    return (unsigned char)kin;
}

/* fills the stored arrays; requires part.place, and in part.depth the sizes of the sub-trees in the
 * caller's order */
static void tree_store(int n, const double length[], const double mass[], const int parent[],
                       const struct tree_parts *part) {
    for (int i = 0; i < n; i++) {
        int k = part->place[i];
        part->len[k] = length[i];
        part->mass[k] = part->subtree_mass[k] = mass[i];
        part->parent[k] = parent[i] < 0 ? -1 : part->place[parent[i]];
        part->end[k] = k + part->depth[i];
        part->order[k] = i;
    }
    part->depth[0] = 1;
    assert(part->parent[0] == -1 && part->end[0] == n);
    for (int k = 1; k < n; k++) part->depth[k] = part->depth[part->parent[k]] + 1;
    for (int k = n - 1; k > 0; k--) part->subtree_mass[part->parent[k]] += part->subtree_mass[k];
    for (int k = 0; k < n; k++) part->kin[k] = tree_kin(part->parent, part->end, k);
}

static struct tree_block *tree_block_new(int n, struct tree_parts *part) {
    size_t one = 3 * sizeof(double) + 5 * sizeof(int) + 1, count = (size_t)n;
    if (count > (SIZE_MAX - sizeof(struct tree_block)) / one) return NULL;
    struct tree_block *block = malloc(sizeof *block + count * one);
    if (!block) return NULL;
    part->len = block->data;
    part->mass = part->len + count;
    part->subtree_mass = part->mass + count;
    part->parent = (int *)(part->subtree_mass + count);
    part->end = part->parent + count;
    part->depth = part->end + count;
    part->order = part->depth + count;
    part->place = part->order + count;
    part->kin = (unsigned char *)(part->place + count);
    block->tree = (struct pend_tree){.n = n,
                                     .len = part->len,
                                     .mass = part->mass,
                                     .subtree_mass = part->subtree_mass,
                                     .parent = part->parent,
                                     .end = part->end,
                                     .depth = part->depth,
                                     .order = part->order,
                                     .place = part->place,
                                     .kin = part->kin};
    return block;
}

enum pend_status pend_tree_new_bare(struct pend_tree **tree, int n, const double length[],
                                    const double mass[], const unsigned char bare[],
                                    const int parent[], const struct pend_fault_sink *sink) {
    struct tree_faults faults = {sink, 0};
    struct tree_parts part;
    *tree = NULL;
    if (n < 1) {
        tree_fault(&faults, PEND_FIELD_COUNT, -1, -1, "a tree has at least one arm");
        return PEND_INVALID;
    }
    struct tree_block *block = tree_block_new(n, &part);
    if (!block) return PEND_NO_MEMORY;

    // check all arrays first: each is scratch memory until its final values are stored
    block->tree.length_total =
        tree_check_values(n, length, NULL, PEND_FIELD_LENGTH, "lengths", &faults);
    tree_check_values(n, mass, bare, PEND_FIELD_MASS, "masses", &faults);
    tree_check_parents(n, parent, &faults);
    int *size = part.depth, *list = part.order, *waiting = part.end;
    if (tree_list_from_leaves(n, parent, waiting, size, list) < n)
        for (int i = 0; i < n; i++)
            if (waiting[i]) tree_fault_cycle(parent, i, waiting, &faults);
    if (faults.count) {
        free(block);
        return PEND_INVALID;
    }

    tree_place(n, parent, size, list, part.end, part.parent, part.place);
    tree_store(n, length, mass, parent, &part);
    *tree = &block->tree;
    assert(pend_tree_valid(*tree));
    return PEND_OK;
}

enum pend_status pend_tree_new(struct pend_tree **tree, int n, const double length[],
                               const double mass[], const int parent[],
                               const struct pend_fault_sink *sink) {
    return pend_tree_new_bare(tree, n, length, mass, NULL, parent, sink);
}

void pend_tree_free(struct pend_tree **tree) {
    assert(!*tree || pend_tree_valid(*tree));
    free(*tree);
    *tree = NULL;
}

/* A path matrix while its tree is reconstructed. Arms join the tree in the order of their score. In
 * a path matrix the score rises by 2 or more from an arm to its children, so that one wrong entry
 * hardly changes the order. */
struct path_reading {
    int n;
    const double *path;
    int *score;    /* arms on the path to tip k, minus arms in k's sub-tree */
    int *arm;      /* in the order in which arms join */
    int *parent;   /* the best candidate */
    int *mismatch; /* per candidate parent j of the joining arm: differing entries */
};

/* row i; path_ones and path_read count every nonzero entry, and the diagonal, as 1 */
static const double *path_row(const struct path_reading *in, int i) {
    return in->path + (size_t)i * (size_t)in->n;
}

/* the number of ones in row i besides the diagonal */
static int path_ones(const struct path_reading *in, int i) {
    const double *row = path_row(in, i);
    int ones = 0;
    for (int j = 0; j < in->n; j++) ones += row[j] != 0;
    return ones - (row[i] != 0);
}

/* computes scores and the order of arms; ties by number */
static void path_order(const struct path_reading *in) {
    int n = in->n, *score = in->score, *arm = in->arm;
    memset(score, 0, (size_t)n * sizeof *score);
    for (int i = 0; i < n; i++) {
        const double *row = path_row(in, i);
        for (int j = 0; j < n; j++) score[j] -= row[j] != 0;
        score[i] += path_ones(in, i) + (row[i] != 0);
    }
    for (int i = 0; i < n; i++) {
        int at = i;
        for (; at > 0 && score[arm[at - 1]] > score[i]; at--) arm[at] = arm[at - 1];
        arm[at] = i;
    }
}

/* makes each arm a child of the arm whose path, including itself, differs least from the row;
 * O(n^2), because a path differs from its parent's path in one entry */
static void path_read(const struct path_reading *in) {
    in->parent[in->arm[0]] = -1;
    for (int a = 1; a < in->n; a++) {
        int i = in->arm[a], ones = path_ones(in, i), best = in->arm[0];
        const double *row = path_row(in, i);
        for (int b = 0; b < a; b++) {
            int j = in->arm[b], p = in->parent[j];
            in->mismatch[j] = (p < 0 ? ones : in->mismatch[p]) + 1 - 2 * (row[j] != 0);
            if (in->mismatch[j] < in->mismatch[best]) best = j;
        }
        assert(best != i);
        in->parent[i] = best;
    }
}

/* reports the entries of row i that differ from the path to tip i in the reconstructed tree */
static void path_check_row(const struct path_reading *in, int i, int on_way[],
                           struct tree_faults *faults) {
    const double *row = path_row(in, i);
    for (int j = i; j >= 0; j = in->parent[j]) on_way[j] = i;
    if (faults->sink && faults->sink->worded && faults->count >= faults->sink->worded) {
        // the faults are counted without composing their texts
        for (int j = 0; j < in->n; j++)
            if (row[j] != (on_way[j] == i)) tree_fault(faults, PEND_FIELD_PATH, i, -1, "is wrong");
        return;
    }
    for (int j = 0; j < in->n; j++) {
        int want = on_way[j] == i;
        if (row[j] == want) continue;
        if (row[j] != 0 && row[j] != 1)
            tree_fault(faults, PEND_FIELD_PATH, i, j, "must be 0 or 1, got %.17g", row[j]);
        else if (i == j)
            tree_fault(faults, PEND_FIELD_PATH, i, j,
                       "must be 1: an arm is on the way to its own tip");
        else if (in->parent[i] < 0)
            tree_fault(
                faults, PEND_FIELD_PATH, i, j,
                "must be 0: the other rows make arm %d the one at the pivot, so no arm precedes it",
                i + 1);
        else
            tree_fault(faults, PEND_FIELD_PATH, i, j,
                       "must be %d: row %d must be row %d (its parent) with a 1 added in column %d",
                       want, i + 1, in->parent[i] + 1, i + 1);
    }
}

enum pend_status pend_tree_parent_from_path(int n, const double path[], int parent[],
                                            const struct pend_fault_sink *sink) {
    struct tree_faults faults = {sink, 0};
    if (n < 1) {
        tree_fault(&faults, PEND_FIELD_COUNT, -1, -1, "a tree has at least one arm");
        return PEND_INVALID;
    }
    size_t count = (size_t)n;
    int *block = calloc(4 * count, sizeof *block);
    if (!block) return PEND_NO_MEMORY;
    struct path_reading in = {n, path, block, block + count, block + 2 * count, block + 3 * count};
    path_order(&in);
    path_read(&in);
    int *on_way = in.mismatch;
    for (int i = 0; i < n; i++) on_way[i] = -1;
    for (int i = 0; i < n; i++) path_check_row(&in, i, on_way, &faults);
    if (!faults.count) memcpy(parent, in.parent, count * sizeof *parent);
    free(block);
    return faults.count ? PEND_INVALID : PEND_OK;
}

void pend_tree_path(const struct pend_tree *tree, double path[]) {
    assert(pend_tree_valid(tree));
    size_t n = (size_t)tree->n;
    memset(path, 0, n * n * sizeof *path);
    for (int k = 0; k < tree->n; k++)
        for (int j = k; j >= 0; j = tree->parent[j])
            path[(size_t)tree->order[k] * n + (size_t)tree->order[j]] = 1;
}

void pend_tree_force_map(const struct pend_tree *tree, double force_map[]) {
    assert(pend_tree_valid(tree));
    size_t n = (size_t)tree->n;
    memset(force_map, 0, n * n * sizeof *force_map);
    for (int k = 0; k < tree->n; k++) {
        size_t column = (size_t)tree->order[k];
        force_map[column * n + column] = 1;
        if (k > 0) force_map[(size_t)tree->order[tree->parent[k]] * n + column] = -1;
    }
}

/* true if length and masses of arm k are valid, and `order` and `place` are inverse at k */
static int tree_values_valid(const struct pend_tree *tree, int k) {
    int order = tree->order[k];
    if (order < 0 || order >= tree->n || tree->place[order] != k) return 0;
    if (!(tree->len[k] > 0 && isfinite(tree->len[k]) && tree->mass[k] >= 0)) return 0;
    return tree->subtree_mass[k] >= tree->mass[k] && isfinite(tree->subtree_mass[k]);
}

/* true if the sub-tree of arm k is a contiguous range within its parent's, and its mass at most the
 * parent's */
static int tree_arm_valid(const struct pend_tree *tree, int k) {
    int p = tree->parent[k];
    if (tree->end[k] <= k || tree->end[k] > tree->n) return 0;
    if (p >= k || tree->kin[k] != tree_kin(tree->parent, tree->end, k)) return 0;
    if (k == 0) return p == -1 && tree->depth[0] == 1 && tree->end[0] == tree->n;
    if (p < 0 || p >= k || tree->depth[k] != tree->depth[p] + 1) return 0;
    // depth first: an arm follows its parent or the sub-tree of a sibling, and is no larger than
    // the last sibling
    return tree->end[k] <= tree->end[p] && tree->subtree_mass[k] <= tree->subtree_mass[p];
}

/* true if the ranges of the children fill the range of k, and the last child is the largest */
static int tree_children_valid(const struct pend_tree *tree, int k) {
    int next = k + 1, largest = 0, last = 0;
    for (; next < tree->end[k]; next = tree->end[next]) {
        if (tree->parent[next] != k || tree->end[next] <= next) return 0;
        last = tree->end[next] - next;
        if (last > largest) largest = last;
    }
    return next == tree->end[k] && last == largest;
}

int pend_tree_valid(const struct pend_tree *tree) {
    if (!tree || tree->n < 1 || !isfinite(tree->length_total)) return 0;
    for (int k = 0; k < tree->n; k++)
        if (!tree_values_valid(tree, k) || !tree_arm_valid(tree, k)) return 0;
    for (int k = 0; k < tree->n; k++)
        if (!tree_children_valid(tree, k)) return 0;
    return 1;
}
