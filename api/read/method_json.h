/* The integration method and its settings out of JSON: method, rtol, atol, step, precision,
 * accuracy.
 * Leaves to others: the methods and their ranges (core/integrate/method).
 * Invariant: settings that were read are in the range of the method they are for. */
#ifndef API_METHOD_JSON_H
#define API_METHOD_JSON_H

#include "api/read/tree_json.h"
#include "core/integrate/method.h"

struct api_method {
    const struct pend_method *method; /* NULL where it is faulty */
    double rtol, atol, step;          /* 0 = the method's default */
    int atol_given;                   /* atol is meant as it stands, 0 included */
    double accuracy;                  /* that the answer's horizon goes by, > 0 */
};

/**
 * Reads the fields method, rtol, atol, step, precision and accuracy of a request.
 *
 * root    the request's object.
 * tree    as it was read, for methods that need its modes; a faulty one is used as far as it is
 *         known.
 *
 * Every fault is added to the problem.
 */
void api_method_read(struct api_method *method, const struct api_value *root,
                     const struct api_tree *tree, const struct api_limits *limits,
                     struct api_problem *problem);

/** Reads the field accuracy of a request; 1e-6 where it is left out or faulty. */
double api_accuracy_read(const struct api_value *root, struct api_problem *problem);

#endif
