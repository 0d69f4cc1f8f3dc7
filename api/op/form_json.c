#include "api/op/form_json.h"

#include "api/read/field.h"

void api_form_read(struct api_table *table, const struct api_value *root,
                   struct api_problem *problem) {
    static const char *const numbers[] = {"float64", "float32", NULL}, *const nones[] = {"nan",
                                                                                         NULL};
    struct api_value number = api_value_member(root, "number"),
                     none = api_value_member(root, "none");
    long rounded = 0;
    int word = 0;
    (void)api_field_whole(API_MEMBER(root, "digits"), 1, 17, &rounded, problem);
    if (api_field_word(&number, numbers, &table->float32, problem) > 0 && !table->float32)
        api_value_usual(&number);
    if (api_field_word(&none, nones, &word, problem) > 0) api_value_usual(&none);
    table->digits = (int)rounded;
}
