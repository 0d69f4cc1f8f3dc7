#include "core/modes/modes_symmetry.h"

#include <assert.h>
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

struct branch {
    uint64_t hash;
    int arm, n; /* first arm of the branch; number of its arms after merging */
};

/* like branches found so far, and scratch of the search */
struct found {
    struct branch kind;
    struct pend_likes likes;
};

struct finder {
    struct pend_symmetry *symmetry;
    const unsigned char *up;
    uint64_t *hash;         /* n: sums over the children, then the branch's own */
    int *merged_n;          /* n numbers: how many arms the branch has after merging */
    struct branch *sibling; /* scratch for the children of one joint */
    struct found *found;
    int found_count, branch_count;
};

static uint64_t symmetry_mix(uint64_t x) {
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ull;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebull;
    return x ^ (x >> 31);
}

static uint64_t symmetry_bits(double value) {
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    return bits;
}

static int symmetry_order(const struct branch *a, const struct branch *b) {
    if (a->n != b->n) return a->n < b->n ? -1 : 1;
    if (a->hash != b->hash) return a->hash < b->hash ? -1 : 1;
    return a->arm < b->arm ? -1 : a->arm > b->arm;
}

static int symmetry_by_branch(const void *a, const void *b) { return symmetry_order(a, b); }

static int symmetry_by_kind(const void *a, const void *b) {
    return symmetry_order(&((const struct found *)a)->kind, &((const struct found *)b)->kind);
}

/* an insertion sort, because siblings are few */
static void symmetry_sort(struct branch sibling[], int count) {
    if (count > 16) {
        qsort(sibling, (size_t)count, sizeof *sibling, symmetry_by_branch);
        return;
    }
    for (int i = 1; i < count; i++) {
        struct branch moving = sibling[i];
        int j = i;
        for (; j > 0 && symmetry_order(&moving, &sibling[j - 1]) < 0; j--)
            sibling[j] = sibling[j - 1];
        sibling[j] = moving;
    }
}

/* the smallest number, in the caller's numbering, of an arm in a branch */
static int symmetry_caller_first(const struct pend_tree *tree, int arm) {
    int first = tree->order[arm];
    for (int k = arm + 1; k < tree->end[arm]; k++)
        if (tree->order[k] < first) first = tree->order[k];
    return first;
}

/* stores a group of like siblings, in the caller's order */
static void symmetry_file(struct finder *f, struct branch run[], int count) {
    struct pend_symmetry *s = f->symmetry;
    struct branch kind = run[0];
    for (int i = 0; i < count; i++) {
        s->copies[run[i].arm] = count;
        s->merged[run[i].arm] = i > 0;
        run[i].n = symmetry_caller_first(s->tree, run[i].arm);
    }
    symmetry_sort(run, count);
    f->found[f->found_count++] = (struct found){kind, {f->branch_count, count}};
    for (int i = 0; i < count; i++) s->branch[f->branch_count++] = run[i].arm;
}

/* at one joint: sorts its branches, merges like ones, and assigns each branch its index */
static void symmetry_joint(struct finder *f, int arm) {
    const struct pend_tree *tree = f->symmetry->tree;
    int count = 0, place = 1;
    for (int k = arm + 1; k < tree->end[arm]; k = tree->end[k])
        f->sibling[count++] = (struct branch){f->hash[k], k, f->merged_n[k]};
    symmetry_sort(f->sibling, count);
    for (int i = 0, end; i < count; i = end) {
        int n = f->sibling[i].n;
        for (end = i;
             end < count && f->sibling[end].n == n && f->sibling[end].hash == f->sibling[i].hash;
             end++)
            f->symmetry->offset[f->sibling[end].arm] = place;
        if (end > i + 1) symmetry_file(f, f->sibling + i, end - i);
        place += n;
    }
    assert(place <= tree->end[arm] - arm);
    f->merged_n[arm] = place;
}

static void symmetry_find(struct finder *f) {
    const struct pend_tree *tree = f->symmetry->tree;
    for (int k = tree->n - 1; k >= 0; k--) {
        symmetry_joint(f, k);
        uint64_t hash = f->hash[k] + symmetry_bits(tree->len[k]);
        hash = symmetry_mix(hash) + symmetry_bits(tree->mass[k]);
        hash = symmetry_mix(hash) + (f->up && f->up[k]);
        f->hash[k] = symmetry_mix(hash);
        if (k) f->hash[tree->parent[k]] += symmetry_mix(f->hash[k] + 0x9e3779b97f4a7c15ull);
    }
}

/* true if two branches of the same hash are equal arm by arm; place, at: n ints of scratch */
static int symmetry_alike(const struct finder *f, int a, int b, int place[], int at[]) {
    const struct pend_symmetry *s = f->symmetry;
    const struct pend_tree *tree = s->tree;
    /* records the index of each arm of a, then looks up the arms of b */
    for (int k = a; k < tree->end[a]; k++) {
        place[k] = k == a ? 0 : place[tree->parent[k]] + s->offset[k];
        at[place[k]] = k;
    }
    if (tree->end[a] - a != tree->end[b] - b) return 0;
    for (int k = b; k < tree->end[b]; k++) {
        place[k] = k == b ? 0 : place[tree->parent[k]] + s->offset[k];
        if (place[k] >= f->merged_n[a]) return 0;
        int other = at[place[k]];
        if (tree->len[k] != tree->len[other] || tree->mass[k] != tree->mass[other]) return 0;
        if (f->up && !f->up[k] != !f->up[other]) return 0;
        if (f->merged_n[k] != f->merged_n[other] || (k != b && s->copies[k] != s->copies[other]))
            return 0;
    }
    return 1;
}

static int symmetry_by_lead(const void *a, const void *b) {
    int x = ((const struct pend_contrast *)a)->lead, y = ((const struct pend_contrast *)b)->lead;
    return x < y ? -1 : x > y;
}

/* sorts the like branches by kind, creates a part for each kind; returns 0 if hashes collide */
static int symmetry_parts(struct finder *f, int place[], int at[]) {
    struct pend_symmetry *s = f->symmetry;
    qsort(f->found, (size_t)f->found_count, sizeof *f->found, symmetry_by_kind);
    s->part[0] = (struct pend_part){0, f->merged_n[0], 1, 0};
    s->part_count = 1;
    s->likes_count = f->found_count;
    for (int i = 0; i < f->found_count; i++) {
        struct branch kind = f->found[i].kind;
        s->likes[i] = f->found[i].likes;
        struct pend_part *last = &s->part[s->part_count - 1], *part = last;
        if (!i || kind.hash != f->found[i - 1].kind.hash || kind.n != f->found[i - 1].kind.n) {
            part = &s->part[s->part_count++];
            *part = (struct pend_part){kind.arm, kind.n, 0, i ? last->first + last->times : 0};
        }
        for (int j = 0; j < s->likes[i].count; j++)
            if (!symmetry_alike(f, part->root, s->branch[s->likes[i].first + j], place, at))
                return 0;
        for (int from = 0; from < s->likes[i].count - 1; from++) {
            int lead = symmetry_caller_first(s->tree, s->branch[s->likes[i].first + from]);
            s->contrast[part->first + part->times++] = (struct pend_contrast){i, from, lead};
        }
    }
    for (int i = 1; i < s->part_count; i++)
        qsort(s->contrast + s->part[i].first, (size_t)s->part[i].times, sizeof *s->contrast,
              symmetry_by_lead);
    return 1;
}

/* the symmetry of a tree without equal branches: one part, in which arms keep their index */
static void symmetry_none(struct pend_symmetry *s) {
    s->part[0] = (struct pend_part){0, s->tree->n, 1, 0};
    s->part_count = 1;
    s->likes_count = 0;
    for (int k = 0; k < s->tree->n; k++) {
        s->offset[k] = k ? k - s->tree->parent[k] : 0;
        s->copies[k] = 1;
        s->merged[k] = 0;
    }
}

/* allocates an empty symmetry: no equal branches, no parts; NULL if memory is short */
static struct pend_symmetry *symmetry_allocate(const struct pend_tree *tree, size_t bound) {
    size_t n = (size_t)tree->n;
    struct pend_symmetry *s = malloc(sizeof *s);
    if (!s) return NULL;
    *s = (struct pend_symmetry){.tree = tree};
    s->part = malloc((bound / 2 + 2) * sizeof *s->part);
    s->likes = malloc((bound / 2 + 1) * sizeof *s->likes);
    s->contrast = malloc((bound + 1) * sizeof *s->contrast);
    s->branch = malloc((bound + 1) * sizeof *s->branch);
    s->offset = malloc(2 * n * sizeof *s->offset);
    s->merged = calloc(n, 1);
    if (!s->part || !s->likes || !s->contrast || !s->branch || !s->offset || !s->merged) {
        pend_symmetry_free(&s);
        return NULL;
    }
    s->copies = s->offset + n;
    s->offset[0] = 0;
    for (size_t k = 0; k < n; k++) s->copies[k] = 1;
    return s;
}

enum pend_status pend_symmetry_new(struct pend_symmetry **symmetry, const struct pend_tree *tree,
                                   const unsigned char up[]) {
    size_t n = (size_t)tree->n, bound = 0; // at most so many like branches: children with siblings
    for (int k = 1; k < tree->n; k++)
        bound += k > tree->parent[k] + 1 || tree->end[k] < tree->end[tree->parent[k]];
    enum pend_status status = PEND_NO_MEMORY;
    struct finder f = {.up = up};
    f.symmetry = *symmetry = symmetry_allocate(tree, bound);
    f.hash = calloc(n, sizeof *f.hash);
    f.merged_n = malloc(3 * n * sizeof *f.merged_n);
    f.sibling = malloc((bound + 1) * sizeof *f.sibling);
    f.found = malloc((bound / 2 + 1) * sizeof *f.found);
    if (!f.symmetry || !f.hash || !f.merged_n || !f.sibling || !f.found) goto out;
    symmetry_find(&f);
    if (!f.found_count || !symmetry_parts(&f, f.merged_n + n, f.merged_n + 2 * n))
        symmetry_none(f.symmetry);
    assert((size_t)f.branch_count <= bound && pend_symmetry_valid(f.symmetry));
    status = PEND_OK;
out:
    free(f.hash);
    free(f.merged_n);
    free(f.sibling);
    free(f.found);
    if (status) pend_symmetry_free(symmetry);
    return status;
}

int pend_symmetry_valid(const struct pend_symmetry *symmetry) {
    long modes = 0;
    for (int i = 0; i < symmetry->part_count; i++) {
        const struct pend_part *part = &symmetry->part[i];
        if (part->root < 0 || part->n < 1 || part->times < 1) return 0;
        modes += (long)part->n * part->times;
    }
    return modes == symmetry->tree->n;
}

void pend_symmetry_free(struct pend_symmetry **symmetry) {
    struct pend_symmetry *s = *symmetry;
    if (!s) return;
    free(s->part);
    free(s->likes);
    free(s->contrast);
    free(s->branch);
    free(s->offset);
    free(s->merged);
    free(s);
    *symmetry = NULL;
}

enum pend_status pend_symmetry_laplacian(struct pend_laplacian **laplacian,
                                         const struct pend_symmetry *symmetry, int part,
                                         const struct pend_loads *loads, const unsigned char up[],
                                         int place[]) {
    assert(part >= 0 && part < symmetry->part_count);
    const struct pend_tree *tree = symmetry->tree;
    int root = symmetry->part[part].root;
    PEND_TRY(pend_laplacian_alloc(laplacian, symmetry->part[part].n));
    struct pend_laplacian *l = *laplacian;
    /* sets the indices of the representing arms; until the next loop `end` contains the arm, and
     * `mass` the number of arms that it represents */
    for (int k = root; k < tree->end[root];) {
        if (k != root && symmetry->merged[k]) {
            k = tree->end[k];
            continue;
        }
        int from = k == root ? -1 : place[tree->parent[k]],
            at = k == root ? 0 : from + symmetry->offset[k];
        place[k] = at;
        l->parent[at] = from;
        l->end[at] = k;
        l->mass[at] = k == root ? 1 : l->mass[from] * symmetry->copies[k];
        k++;
    }
    for (int at = 0; at < l->n; at++) {
        int k = l->end[at];
        double times = l->mass[at];
        l->spring[at] = times * pend_laplacian_spring(tree, loads, up, k);
        l->mass[at] = times * tree->mass[k];
        l->len[at] = tree->len[k];
        l->end[at] = at + 1;
    }
    for (int at = l->n - 1; at > 0; at--)
        if (l->end[at] > l->end[l->parent[at]]) l->end[l->parent[at]] = l->end[at];
    pend_laplacian_close(l);
    return PEND_OK;
}

static void symmetry_branch_places(const struct pend_symmetry *s, int root, int place[]) {
    const struct pend_tree *tree = s->tree;
    place[root] = 0;
    for (int k = root + 1; k < tree->end[root]; k++)
        place[k] = place[tree->parent[k]] + s->offset[k];
}

void pend_symmetry_places(const struct pend_symmetry *symmetry, int part, int place[]) {
    assert(part >= 0 && part < symmetry->part_count);
    const struct pend_part *p = &symmetry->part[part];
    if (part == 0) symmetry_branch_places(symmetry, 0, place);
    for (int i = 0; part && i < p->times; i++) {
        const struct pend_contrast *contrast = &symmetry->contrast[p->first + i];
        const struct pend_likes *likes = &symmetry->likes[contrast->likes];
        /* the indices are the same for all contrasts of a joint */
        for (int j = 0; contrast->from == 0 && j < likes->count; j++)
            symmetry_branch_places(symmetry, symmetry->branch[likes->first + j], place);
    }
}

/* writes the angles of a part, times a factor, to the arms of one branch */
static void symmetry_spread_branch(const struct pend_symmetry *s, int root, const double angle[],
                                   double factor, const int place[], double vector[]) {
    for (int k = root, end = s->tree->end[root]; k < end; k++) vector[k] = factor * angle[place[k]];
}

int pend_symmetry_spread(const struct pend_symmetry *symmetry, int part, int which,
                         const double angle[], double zero, const int place[], double vector[]) {
    assert(part >= 0 && part < symmetry->part_count);
    assert(which >= 0 && which < symmetry->part[part].times);
    const struct pend_tree *tree = symmetry->tree;
    const struct pend_contrast *contrast = &symmetry->contrast[symmetry->part[part].first + which];
    int lead = part ? contrast->lead : 0;
    double first = angle[place[tree->place[lead]]], sign = copysign(1, first);
    if (!(fabs(first) > zero)) lead = -1;
    if (part == 0) {
        symmetry_spread_branch(symmetry, 0, angle, sign, place, vector);
        return lead;
    }
    /* Helmert's contrast, normalized: one branch against the mean of the `rest` later ones */
    const struct pend_likes *likes = &symmetry->likes[contrast->likes];
    double rest = likes->count - 1 - contrast->from, head = sign * sqrt(rest / (rest + 1));
    memset(vector, 0, (size_t)tree->n * sizeof *vector);
    for (int j = contrast->from; j < likes->count; j++)
        symmetry_spread_branch(symmetry, symmetry->branch[likes->first + j], angle,
                               j == contrast->from ? head : -head / rest, place, vector);
    return lead;
}
