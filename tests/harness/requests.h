/* Short requests that reach every operation, method, precision and representation, for the loops of
 * failures.
 * Leaves to others: how they are sent, and what fails meanwhile (test_faults of api and of server).
 * Invariant: each is answered within milliseconds; every operation is included, which the tests
 * check. */
#pragma once

#include "api/op/op.h"

#define TEST_TREE                                                                                  \
    "\"pendulum\":{\"arms\":[{\"name\":\"a\",\"length\":1,\"mass\":1},{\"parent\":\"a\","          \
    "\"length\":1,\"mass\":2}]}"
#define TEST_REAL_TREE                                                                             \
    "\"pendulum\":{\"arms\":[{\"name\":\"a\",\"length\":1,\"rod\":2,\"damping\":0.1,"              \
    "\"friction\":{\"torque\":0.1,\"speed\":0.1},\"torque\":{\"constant\":0.1,\"harmonics\":[{"    \
    "\"amplitude\":0.5,\"omega\":3}]}},{\"parent\":\"a\",\"at\":[0.5,0.1],\"length\":1,"           \
    "\"mass\":2,\"body\":{\"mass\":1,\"center\":0.5,\"inertia\":0.1},\"stiffness\":2,"             \
    "\"rest\":0.5,\"drag\":{\"linear\":0.1,\"quadratic\":0.2}}],\"drag_per_mass\":0.05,"           \
    "\"pivot\":{\"x\":{\"harmonics\":[{\"amplitude\":0.1,\"omega\":5,\"phase\":1}]},"              \
    "\"acceleration\":[0.1,0]}}"
#define TEST_CART_TREE                                                                             \
    "\"pendulum\":{\"length\":[1,0.5,0.7],\"mass\":[1,2,1],\"parent\":[0,1,0],\"damping\":[0.1,0," \
    "0.2],\"pivot\":{\"cart\":{\"mass\":2,\"angle\":0.2,\"damping\":0.3,\"stiffness\":20,"         \
    "\"force\":{"                                                                                  \
    "\"constant\":1,\"harmonics\":[{\"amplitude\":2,\"omega\":3}]}}}}"
#define TEST_TIMES "\"times\":[0,0.1,0.25]"
#define TEST_MOTION "{" TEST_TREE ",\"initial\":{\"theta\":[1,2]}," TEST_TIMES ","
#define TEST_GRID                                                                                  \
    "{" TEST_TREE ",\"duration\":0.5,\"grid\":[{\"vary\":\"theta\",\"arm\":1,\"start\":-3,"        \
    "\"stop\":3,\"count\":4},"                                                                     \
    "{\"vary\":\"theta\",\"arm\":2,\"start\":-2,\"stop\":2,\"count\":3}]"

static const struct test_request {
    enum api_op_id op;
    const char *body, *accept; /* NULL: none, which is a GET; JSON */
} test_requests[] = {
    {API_OP_TREES, "{" TEST_TREE "}", NULL},
    {API_OP_TREES, "{\"pendulum\":{\"L\":[1,1],\"m\":[1,1],\"S\":[[1,0],[1,1]]}}", NULL},
    {API_OP_TREES,
     "{\"pendulum\":{\"length\":[1,0],\"mass\":[1,\"x\"],\"parent\":[0,3],\"rod\":[null,-1],"
     "\"torque\":[{\"harmonics\":[{\"amplitude\":1,\"omega\":2}]},{}]},\"more\":1}",
     NULL},
    {API_OP_TREES, "{" TEST_REAL_TREE "}", NULL},
    {API_OP_TREES, "{" TEST_CART_TREE "}", NULL},
    {API_OP_TRAJECTORIES,
     "{" TEST_CART_TREE "," TEST_TIMES
     ",\"initial\":{\"theta\":[1,2,0],\"cart\":{\"x\":0.1}},\"output\":[\"phi\",\"z\",\"cart\"]}",
     "text/csv"},
    {API_OP_FORCES, "{" TEST_CART_TREE ",\"state\":{\"phi\":[1,2,3],\"cart\":{\"v\":1}}}", NULL},
    {API_OP_FORCES, "{" TEST_CART_TREE ",\"derivatives\":[{\"vary\":\"phi\",\"arm\":\"cart\"}]}",
     NULL},
    {API_OP_MODES, "{" TEST_CART_TREE "}", NULL},
    {API_OP_EQUATIONS, "{" TEST_CART_TREE "}", NULL},
    {API_OP_RESPONSE, "{" TEST_CART_TREE ",\"output\":[\"cart\",\"phi\"],\"poles\":true}", NULL},
    {API_OP_LYAPUNOV, "{" TEST_CART_TREE ",\"duration\":0.2,\"samples\":2,\"count\":\"all\"}",
     NULL},
    {API_OP_SECTIONS, "{" TEST_CART_TREE ",\"duration\":1,\"section\":{\"period\":0.3}}",
     "application/x-npz"},
    {API_OP_ENSEMBLES,
     "{" TEST_CART_TREE
     ",\"duration\":0.5,\"observables\":[\"cart\",\"final\"],\"grid\":[{\"vary\":\"mass\","
     "\"arm\":\"cart\",\"start\":1,\"stop\":3,\"count\":3}]}",
     NULL},
    {API_OP_TRAJECTORIES,
     "{" TEST_TREE
     ",\"initial\":{\"mode\":2,\"amplitude\":0.5},\"times\":{\"stop\":1,\"step\":0.002},"
     "\"output\":[\"phi\",\"z\",\"energy\",\"lambda\"]}",
     NULL},
    {API_OP_TRAJECTORIES, TEST_MOTION "\"digits\":6}", "text/csv"},
    {API_OP_TRAJECTORIES, TEST_MOTION "\"trust\":true}", "application/x-ndjson"},
    {API_OP_TRAJECTORIES, TEST_MOTION "\"output\":[\"phi\"]}", "application/octet-stream"},
    {API_OP_TRAJECTORIES, TEST_MOTION "\"output\":[\"phi\",\"z\"]}", "application/x-npz"},
    {API_OP_TRAJECTORIES, TEST_MOTION "\"output\":[\"theta\"]}", "application/x-matlab-data"},
    {API_OP_TRAJECTORIES, "{" TEST_TREE "," TEST_TIMES ",\"method\":\"linear\"}", NULL},
    {API_OP_TRAJECTORIES,
     TEST_MOTION "\"output\":[\"phi\",\"z\",\"energy\"],\"derivatives\":[{\"vary\":\"length\","
                 "\"arm\":\"a\"},{\"vary\":\"phi\",\"arm\":2}]}",
     "application/x-matlab-data"},
    {API_OP_TRAJECTORIES,
     TEST_MOTION "\"rows\":\"events\",\"events\":[{\"of\":\"distance\",\"arm\":1,\"to\":2,"
                 "\"value\":1},{\"of\":\"kinetic\",\"value\":1,\"stop\":1}]}",
     NULL},
    {API_OP_TRAJECTORIES,
     "{" TEST_REAL_TREE "," TEST_TIMES
     ",\"rows\":\"events\",\"events\":[{\"of\":\"phid\",\"arm\":1,\"bound\":0.1}]}",
     "application/x-npz"},
    {API_OP_FORCES,
     "{" TEST_REAL_TREE
     ",\"derivatives\":[{\"vary\":\"damping\",\"arm\":1},{\"vary\":\"gravity\"}]}",
     NULL},
    {API_OP_TRAJECTORIES, TEST_MOTION "\"method\":\"ode23\"}", NULL},
    {API_OP_TRAJECTORIES, TEST_MOTION "\"method\":\"rkf45\"}", NULL},
    {API_OP_TRAJECTORIES, TEST_MOTION "\"method\":\"rk8pd\",\"digits\":3}", NULL},
    {API_OP_TRAJECTORIES, TEST_MOTION "\"method\":\"radau\",\"digits\":3}", NULL},
    {API_OP_TRAJECTORIES, TEST_MOTION "\"method\":\"msadams\"}", NULL},
    {API_OP_TRAJECTORIES, TEST_MOTION "\"method\":\"symplectic\"}", NULL},
    {API_OP_TRAJECTORIES, TEST_MOTION "\"precision\":\"extended\",\"trust\":true}", NULL},
    {API_OP_FORCES,
     "{" TEST_TREE ",\"states\":[{},{\"theta\":[1,2]},{\"mode\":1,\"amplitude\":1}]}", NULL},
    {API_OP_FORCES, "{" TEST_TREE "}", "text/csv"},
    {API_OP_MODES,
     "{" TEST_TREE ",\"include\":[\"A\",\"M\",\"S\",\"B\"],\"initial\":{\"theta\":[1,2]}}", NULL},
    {API_OP_MODES, "{" TEST_TREE ",\"about\":[\"down\",\"up\"]}", "application/x-npz"},
    {API_OP_MODES, "{" TEST_TREE ",\"derivatives\":[{\"vary\":\"gravity\"}]}", NULL},
    {API_OP_ENSEMBLES, TEST_GRID ",\"observables\":[\"first_flip\",\"energy_drift\"]}", NULL},
    {API_OP_ENSEMBLES, TEST_GRID ",\"observables\":[\"first_flip\"]}", "image/png"},
    {API_OP_ENSEMBLES,
     "{" TEST_TREE ",\"states\":[{},{\"theta\":[1,2]}]," TEST_TIMES
     ",\"observables\":[\"trajectory\"],\"output\":[\"theta\"]}",
     "application/x-ndjson"},
    {API_OP_ENSEMBLES,
     "{" TEST_REAL_TREE ",\"energy\":90,\"initial\":{\"theta\":[1,2],\"thetad\":[1,1]},"
     "\"members\":[{},{\"length\":[1,2],\"gravity\":5,\"set\":[{\"vary\":\"rod\",\"arm\":1,"
     "\"value\":1}]}]," TEST_TIMES
     ",\"observables\":[\"trajectory\"],\"output\":[\"phidd\",\"z\",\"zd\",\"energy\"]}",
     "application/x-npz"},
    {API_OP_ENSEMBLES,
     "{" TEST_TREE ",\"duration\":0.5,\"observables\":[\"start\",\"parameters\"],\"grid\":[{"
     "\"vary\":\"mass\",\"arm\":2,\"start\":1,\"stop\":2,\"count\":3,\"with\":[{\"vary\":\"phi\","
     "\"arm\":1,\"start\":0,\"stop\":1}]}]}",
     "text/csv"},
    {API_OP_ENSEMBLES,
     "{" TEST_REAL_TREE ",\"states\":[{},{\"theta\":[1,2]}],\"duration\":0.2,\"derivatives\":[{"
     "\"vary\":\"damping\",\"arm\":1},{\"vary\":\"gravity\"}]}",
     "application/x-npz"},
    {API_OP_ENSEMBLES,
     TEST_GRID ",\"observables\":[\"first_flip\"],\"columns\":[\"first_flip_time\"],"
               "\"number\":\"float32\",\"none\":\"nan\"}",
     "application/vnd.apache.parquet"},
    {API_OP_SECTIONS,
     "{" TEST_TREE
     ",\"initial\":{\"theta\":[1,2]},\"duration\":3,\"section\":{\"arm\":1,\"theta\":0}}",
     "application/x-hdf5"},
    {API_OP_TRAJECTORIES, TEST_MOTION "\"number\":\"float32\"}", "application/vnd.apache.parquet"},
    {API_OP_TRAJECTORIES, TEST_MOTION "\"number\":\"float32\"}", "application/x-hdf5"},
    {API_OP_EQUATIONS, "{" TEST_TREE ",\"initial\":{\"phi\":[1,2]}}", NULL},
    {API_OP_LYAPUNOV, "{" TEST_TREE ",\"duration\":1,\"samples\":4,\"count\":3}", NULL},
    {API_OP_SECTIONS,
     "{" TEST_TREE
     ",\"initial\":{\"theta\":[1,2]},\"duration\":3,\"section\":{\"arm\":1,\"theta\":0}}",
     NULL},
    {API_OP_EQUATIONS, "{" TEST_REAL_TREE "}", NULL},
    {API_OP_LYAPUNOV, "{" TEST_REAL_TREE ",\"start\":2,\"duration\":0.2,\"samples\":2}",
     "text/csv"},
    {API_OP_SECTIONS,
     "{" TEST_REAL_TREE ",\"start\":-1,\"duration\":1,\"section\":{\"period\":0.3,\"first\":2}}",
     "application/x-npz"},
    {API_OP_RESPONSE,
     "{" TEST_TREE ",\"drive\":{\"pivot\":{\"y\":1}},\"omega\":[0,1],\"initial\":{\"theta\":[0,3]},"
     "\"poles\":true}",
     NULL},
    {API_OP_FITS,
     "{" TEST_TREE ",\"data\":{\"t\":[0,0.1,0.2,0.3,0.4,0.5],\"series\":[{\"theta\":1,\"values\":["
     "1,0.95,0.8,0.58,0.3,0]}]},\"unknowns\":[{\"vary\":\"length\",\"arm\":1},{\"vary\":\"theta\","
     "\"arm\":1}],\"iterations\":5}",
     NULL},
    {API_OP_FITS,
     "{\"pendulum\":{\"length\":[0.5,0.4],\"mass\":[1,1],\"parent\":[0,1]},\"data\":{\"modes\":[{"
     "\"mode\":1,\"omega\":6},{\"mode\":2,\"omega\":7}]},\"unknowns\":[{\"vary\":\"length\","
     "\"arm\":1},{\"vary\":\"length\",\"arm\":2,\"low\":0.3,\"high\":0.45}]}",
     NULL},
    {API_OP_FITS,
     "{" TEST_TREE
     ",\"data\":{\"csv\":\"a,b,c\\n0,1,2\\n1,0.5,2\\n2,0,1\\n3,-1,0\\n\",\"columns\":[\"t\","
     "\"thetad_1\",\"joint_2\"]},\"unknowns\":[{\"vary\":\"zero\",\"arm\":2},{\"vary\":\"bias\","
     "\"arm\":1}],\"fixed\":[{\"vary\":\"theta\",\"arm\":1},{\"vary\":\"theta\",\"arm\":2},{"
     "\"vary\":\"thetad\",\"arm\":1},{\"vary\":\"thetad\",\"arm\":2}],\"iterations\":5}",
     NULL},
    {API_OP_TABLES, "{" TEST_TREE ",\"data\":{\"csv\":\"t,theta_1,x_2\\n0,1,2\\n1,2,3\\n\"}}",
     NULL},
    {API_OP_TRIALS,
     "{\"trials\":[{\"length\":1,\"period\":2.01},{\"length\":0.5,\"period\":1.42},{\"length\":2}]"
     "}",
     NULL},
    {API_OP_ORBITS, "{" TEST_TREE ",\"mode\":1,\"amplitude\":0.2,\"branch\":true,\"points\":4}",
     NULL},
    {API_OP_ORBITS,
     "{\"pendulum\":{\"length\":[1],\"mass\":[1],\"parent\":[0],\"damping\":[0.5],\"torque\":[{"
     "\"harmonics\":[{\"amplitude\":1,\"omega\":2}]}]},\"periods\":1}",
     "application/x-npz"},
    {API_OP_RESPONSE, "{" TEST_REAL_TREE ",\"output\":[\"z\",\"lambda\"]}", "application/x-npz"},
    {API_OP_TRAJECTORIES,
     "{\"pendulum\":{\"length\":[1],\"mass\":[1],\"parent\":[0],\"pivot\":{\"cart\":{\"mass\":1}},"
     "\"control\":[{\"cart\":true,\"law\":{\"swing_up\":{\"gain\":9,\"within\":{\"theta\":0.3,"
     "\"thetad\":2},\"then\":{\"feedback\":{\"gains\":[1,2,3,4],\"reference\":{\"t\":[0,1],"
     "\"value\":[[3,0,0,0],[3.1,0,0,0]]}}}}},\"period\":0.02,\"limit\":[-5,5]},{\"joint\":1,"
     "\"law\":{\"pid\":{\"p\":1,\"reference\":0.3}},\"period\":0.1,\"delay\":2}]},\"initial\":{"
     "\"theta\":[3]},\"times\":[0,0.1,0.3],\"output\":[\"theta\",\"control\"]}",
     NULL},
    {API_OP_ENSEMBLES,
     "{\"pendulum\":{\"arms\":[{\"length\":1,\"mass\":1,\"friction\":{\"torque\":0.5},\"stop\":{"
     "\"max\":0.5,\"restitution\":0.5}}],\"control\":[{\"joint\":1,\"period\":0.1,\"law\":{"
     "\"feedback\":{\"gains\":[3,1]}}}]},\"states\":[{\"theta\":[-1]},{\"theta\":[1]}],"
     "\"duration\":1,\"observables\":[\"final\",\"settled\",\"energy_drift\"],\"within\":0.3,"
     "\"events\":[{\"of\":\"theta\",\"arm\":1,\"value\":0}]}",
     NULL},
    {API_OP_CONTROLLERS,
     "{" TEST_CART_TREE ",\"equilibrium\":{\"theta\":[3.1,3.1,3.2],\"cart\":{\"x\":0.3}},"
     "\"actuators\":{\"joints\":[2],\"cart\":true},\"sensors\":{\"arms\":[1]},\"period\":0.02,"
     "\"delay\":1,\"Q\":[1,1,1,0,0,0,1,0],\"R\":[1,2]}",
     NULL},
    {API_OP_PRESETS, NULL, NULL},
    {API_OP_PRESET, NULL, NULL},
};
enum { TEST_REQUESTS = sizeof test_requests / sizeof *test_requests };
