/* Reading the integration method and its settings from JSON: method, rtol, atol, step, precision,
 * accuracy.
 * Leaves to others: the methods and their ranges (core/integrate/methods/method).
 * Invariant: settings that were read are in the range of the method that was chosen. */
#ifndef API_METHOD_JSON_H
#define API_METHOD_JSON_H

#include "api/read/tree_json.h"
#include "core/integrate/methods/method.h"

struct api_method {
    const struct pend_method *method; /* NULL if it is faulty */
    double rtol, atol, step;          /* 0 = the method's default */
    int atol_given;                   /* atol was given: 0 means 0, not the default */
    double accuracy;                  /* rad, > 0: the error that defines the horizon */
};

/**
 * Reads the fields method, rtol, atol, step, precision and accuracy of a request.
 *
 * root    the request's object.
 * tree    as api_tree_read left it, for methods that need its modes; of a faulty tree the parts
 * that are known are used.
 *
 * Every fault is added to the problem.
 */
void api_method_read(struct api_method *method, const struct api_value *root,
                     const struct api_tree *tree, const struct api_limits *limits,
                     struct api_problem *problem);

/** Returns a sentence on what carries the digits of an answer further, of what the method takes.
 */
const char *api_method_advice(const struct api_method *method);

/** Reads the field accuracy of a request; returns 1e-6 if it is left out or faulty. */
double api_accuracy_read(const struct api_value *root, struct api_problem *problem);

#endif
