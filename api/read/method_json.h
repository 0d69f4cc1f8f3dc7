/* Reading the integration method and its settings from JSON: method, rtol, atol, step, precision,
 * accuracy.
 * Leaves to others: the methods and their ranges (core/integrate/methods/method).
 * Invariant: settings are in the range of the chosen method. */
#pragma once

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
 * tree    the result of api_tree_read, for methods that need its modes; of a faulty tree the known
 *         parts are used.
 *
 * Every fault is added to the problem.
 */
void api_method_read(struct api_method *method, const struct api_value *root,
                     const struct api_tree *tree, const struct api_limits *limits,
                     struct api_problem *problem);

/** Returns a sentence that says which supported setting gives an answer more correct digits. */
const char *api_method_advice(const struct api_method *method);

/** Reads the field accuracy of a request; returns 1e-6 if it is left out or faulty. */
double api_accuracy_read(const struct api_value *root, struct api_problem *problem);
