#include "api/op/presets_real.h"

#include <assert.h>
#include <stddef.h>

static const struct api_preset_real presets[] = {
    {.name = "kapitza",
     .title = "Kapitza's pendulum",
     .description = "A pivot that shakes up and down holds a pendulum upside down, if the square "
                    "of its speed is over 2 g l. Here it is three times that; with an amplitude "
                    "below 11 mm it falls.",
     .n = 1,
     .pendulum = "{\"length\":[0.25],\"mass\":[1],\"parent\":[0],\"gravity\":9.81,"
                 "\"damping\":[0.01],\"pivot\":{\"y\":{\"harmonics\":[{\"amplitude\":0.02,"
                 "\"omega\":200,\"phase\":0}]}}}",
     .initial = "{\"phi\":[1.2707963267948966],\"phid\":[0]}",
     .stop = 6,
     .step = 0.002},
    {.name = "double-bars",
     .title = "Double pendulum of bars",
     .description = "Two uniform bars with nothing at their tips, as most double pendulums on a "
                    "table are. Released above the horizontal they turn over and over.",
     .n = 2,
     .pendulum = "{\"length\":[0.3,0.3],\"mass\":[0,0],\"parent\":[0,1],\"gravity\":9.81,"
                 "\"rod\":[0.25,0.25]}",
     .initial = "{\"phi\":[0.6,1.1],\"phid\":[0,0]}",
     .stop = 10,
     .step = 0.005},
    {.name = "driven-damped",
     .title = "Driven damped pendulum",
     .description = "The pendulum of the books on chaos in its own units: gravity, length and mass "
                    "are 1, the damping 1/2, a torque of the amplitude 1.15 with the frequency "
                    "2/3. With 0.9 it swings with the drive, with 1.07 it takes two periods to "
                    "repeat itself, and here it never does.",
     .n = 1,
     .pendulum = "{\"length\":[1],\"mass\":[1],\"parent\":[0],\"gravity\":1,\"damping\":[0.5],"
                 "\"torque\":[{\"constant\":0,\"harmonics\":[{\"amplitude\":1.15,\"omega\":"
                 "0.6666666666666666,\"phase\":0}]}]}",
     .initial = "{\"phi\":[-1.3707963267948966],\"phid\":[0]}",
     .stop = 200,
     .step = 0.05},
    {.name = "coupled",
     .title = "Coupled pendulums",
     .description = "Two equal pendulums hang from the ends of a T-shaped frame that a spring "
                    "holds upright. One begins to swing, and after eight seconds the other one has "
                    "all of its motion.",
     .n = 3,
     .pendulum = "{\"length\":[0.7,0.4,0.4],\"mass\":[0,0.5,0.5],\"parent\":[0,1,1],"
                 "\"gravity\":9.81,\"rod\":[2,null,null],\"stiffness\":[60,null,null],"
                 "\"at\":[null,[0.7,-0.2],[0.7,0.2]]}",
     .initial = "{\"phi\":[-1.5707963267948966,-1.3707963267948966,-1.5707963267948966],"
                "\"phid\":[0,0,0]}",
     .stop = 40,
     .step = 0.02},
    {.name = "laboratory-double",
     .title = "Laboratory double pendulum",
     .description =
         "Two arms of a rig with bearings and a motor, by fifteen numbers: masses, "
         "lengths, centers and inertias, viscous and dry friction of both arms, gravity, "
         "and the strength and the pace of the motor in the second joint.",
     .n = 2,
     .pendulum = "{\"length\":[0.3,0.2],\"mass\":[0,0],\"parent\":[0,1],\"gravity\":9.81,"
                 "\"body\":[{\"mass\":0.55,\"center\":0.22,\"inertia\":0.006},{\"mass\":0.6,"
                 "\"center\":0.15,\"inertia\":0.002}],\"damping\":[0.001,0.001],"
                 "\"friction\":[{\"torque\":0.02,\"speed\":0.1},{\"torque\":0.01,\"speed\":0.1}],"
                 "\"torque\":[null,{\"constant\":0,\"harmonics\":[{\"amplitude\":0.4,\"omega\":7,"
                 "\"phase\":0}]}]}",
     .initial = "{\"phi\":[-1.5707963267948966,-1.5707963267948966],\"phid\":[0,0]}",
     .stop = 20,
     .step = 0.01},
    {.name = "metronome-cart",
     .title = "Metronome on a cart",
     .description =
         "The arm of a metronome, its weight above the joint and a heavier one below, on "
         "a cart that rolls freely. Arm and cart swing against each other, a little faster than "
         "the arm would on a table.",
     .n = 1,
     .pendulum = "{\"length\":[0.15],\"mass\":[0.03],\"parent\":[0],\"gravity\":9.81,"
                 "\"body\":[{\"mass\":0.15,\"center\":-0.05,\"inertia\":0.00002}],"
                 "\"pivot\":{\"cart\":{\"mass\":0.1,\"damping\":0.01}}}",
     .initial = "{\"phi\":[2.2707963267948966],\"phid\":[0]}",
     .stop = 20,
     .step = 0.01},
};

const struct api_preset_real *api_preset_real(int i) {
    assert(i >= 0);
    return i < (int)(sizeof presets / sizeof *presets) ? &presets[i] : NULL;
}
