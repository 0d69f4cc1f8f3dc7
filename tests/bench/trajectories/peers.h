/* The other solvers: GSL and SUNDIALS on the paper's matrix form and on the O(n) form, and MuJoCo.
 * Leaves to others: tolerances, clocks (bench_trajectories).
 * Invariant: a peer gets what helps it: the O(n) form without forces, a matrix form without a
 * needless product. */
#pragma once

#include "tests/bench/trajectories/problem.h"

/** Looks for LAPACK (OpenBLAS, one thread); small trees and machines without it use a Cholesky of
 * peers.c. */
void peers_open(void);

/** The matrix form is of ideal pendulums, and fails for others. */
problem_solver peer_rk8pd_matrix, peer_msadams_matrix, peer_rk8pd, peer_msadams;
/** SUNDIALS; fail where it was not there when this was built. */
problem_solver peer_cvode, peer_arkode;
/** MuJoCo, of pendulums of rods alone, with viscous friction and springs, to errors of 1e-8 and
 * more; fails where it is not there. */
problem_solver peer_mujoco;
/** Non-zero if the peer is there. */
int peer_sundials_there(void), peer_mujoco_there(void);
