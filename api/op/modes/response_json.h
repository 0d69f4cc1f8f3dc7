/* Reads a request for a response: the drives, the frequencies and the outputs.
 * Leaves to others: the tree (tree_json), the response (core/modes/response), the answer
 * (op_response).
 * Invariant: every error is added; a valid request has a drive and a frequency. */
#pragma once

#include "api/op/op.h"
#include "api/read/state_json.h"

/* The outputs, one number per arm unless noted; names of the field `output`. */
enum api_response_output {
    API_RESPONSE_PHI,
    API_RESPONSE_Z,
    API_RESPONSE_LAMBDA,
    API_RESPONSE_JOINT_FORCE,
    API_RESPONSE_TIP_FORCE,
    API_RESPONSE_TRANSMISSIBILITY,
    API_RESPONSE_CART, /* one number, the cart's position */
    API_RESPONSE_OUTPUTS
};

struct api_response {
    struct api_tree tree;
    struct api_states *start; /* start of the search for the equilibrium; NULL = all arms hang */
    int own;                  /* whether the drive is the pendulum's own harmonics */
    int apart;                /* whether each harmonic is a row, at its own frequency */
    int given;                /* whether an amplitude is given, so that the response has a scale */
    double pivot[2];          /* m, amplitudes of the pivot in x and y */
    int arm;                  /* stored number of the driven arm; 0 = a cart, if there is one; -1 =
                               * none */
    double couple;            /* amplitude of the torque, N m, or of the force on a cart, N */
    long rows;
    double *list;    /* `rows` frequencies, rad/s; NULL = the range */
    double from, to; /* ends of the range, rad/s */
    int logarithmic;
    unsigned char output[API_RESPONSE_OUTPUTS];
    int poles, digits;
};

/** The names of the outputs. */
extern const char *const api_response_outputs[API_RESPONSE_OUTPUTS + 1];

/**
 * Reads the request; released by api_response_clear, also after a failure.
 *
 * PEND_INVALID   every error was added.
 * PEND_NO_MEMORY
 */
PEND_MUST_CHECK enum pend_status api_response_read(struct api_response *asked,
                                                   const struct api_reading *reading);
void api_response_clear(struct api_response *asked);
