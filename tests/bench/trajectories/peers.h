/* The other solvers: GSL and SUNDIALS on the paper's matrix form and on the O(n) form, and MuJoCo.
 * Leaves to others: tolerances, clocks (bench_trajectories).
 * Invariant: every peer gets the form that is best for it: the O(n) form without forces, the matrix
 * form without an unnecessary product. */
#pragma once

#include "tests/bench/trajectories/problem.h"

/** Looks for LAPACK (OpenBLAS, one thread); small trees and machines without it use a Cholesky of
 * peers.c. */
void peers_open(void);

/** The matrix form applies to ideal pendulums, and fails for others. */
problem_solver peer_rk8pd_matrix, peer_msadams_matrix, peer_rk8pd, peer_msadams;
/** SUNDIALS; these fail if it was not installed when this was built. */
problem_solver peer_cvode, peer_arkode;
/** MuJoCo, only for pendulums of rods, with viscous friction and springs, and errors of at least
 * 1e-8; fails if it is not installed. */
problem_solver peer_mujoco;
/** Returns non-zero if the peer is installed. */
int peer_sundials_there(void), peer_mujoco_there(void);
