#include "api/op/tree_write.h"

static enum pend_status tree_write_arm(const struct api_tree *tree, int i, struct api_buffer *out) {
    char name[16], parent_name[16];
    int parent = api_tree_parent(tree, i), k = tree->tree->place[i];
    PEND_TRY(api_out_comma(out));
    PEND_TRY(api_buffer_text(out, "{"));
    PEND_TRY(api_out_text(out, "name", api_tree_name(tree, i, name)));
    PEND_TRY(
        api_out_text(out, "parent", parent < 0 ? NULL : api_tree_name(tree, parent, parent_name)));
    PEND_TRY(api_out_number(out, "length", tree->tree->len[k], 0));
    PEND_TRY(api_out_number(out, "mass", tree->tree->mass[k], 0));
    PEND_TRY(api_terms_write_arm(&tree->loads, k, out));
    return api_buffer_text(out, "}");
}

enum pend_status api_tree_write_arms(const struct api_tree *tree, struct api_buffer *out) {
    PEND_TRY(api_out_open(out, "arms", '['));
    for (int i = 0; i < tree->n; i++) PEND_TRY(tree_write_arm(tree, i, out));
    return api_buffer_text(out, "]");
}
