// English: what the examples show, and their groups; words of the drawer of examples.

export default {
  "examples.first": "First steps",
  "examples.surprising": "Surprising",
  "examples.driven": "Drives and friction",
  "examples.trees": "Trees and chains",
  "examples.more": "More",
  "preset.single.words":
    "One arm, released at 40°. Its period is 2.07 s, 3 % longer than the formula for small swings says.",
  "preset.side-by-side.words":
    "Two pendulums that do not touch. One is four times as long as the other, so its period is twice as long. Change a length or a mass and compare.",
  "preset.double.words":
    "Two equal arms in a small swing: a slow mode and a fast one at the same time.",
  "preset.upright.words":
    "Released 5° from upright: it lingers at the top, and its period is far longer than that of a small swing.",
  "preset.kapitza.words":
    "The pivot shakes up and down 32 times a second, which keeps the pendulum upside down. With an amplitude below 11 mm it falls.",
  "preset.coupled.words":
    "Two equal pendulums hang from a frame that a spring holds upright. The first passes its swing on to the second, and gets it back.",
  "preset.two-to-one.words":
    "Masses of 0.64 kg and 0.36 kg make one mode exactly twice as fast as the other: the tips return after each slow period.",
  "preset.chaotic-double.words":
    "Released from above the horizontal. Two starts that differ by a hair separate within seconds: Compare shows it.",
  "preset.double-bars.words":
    "Two uniform bars without masses at their tips, like most double pendulums on a table.",
  "preset.driven-damped.words":
    "A motor turns it back and forth, and friction slows it. With 0.9 N m it follows the motor, with 1.07 N m it takes two periods to repeat, and with 1.15 N m, as here, it never repeats: the route to chaos.",
  "preset.laboratory-double.words":
    "A rig with bearings and a motor in the second joint, described by fifteen numbers.",
  "preset.metronome-cart.words":
    "The arm of a metronome, with a weight above the joint and a heavier one below, on a cart that rolls: arm and cart swing against each other, slightly faster than on a table.",
  "preset.bar-on-stop.words": "Each impact leaves 80 % of its speed: bounces shorten, and end.",
  "preset.clock.words": "A motor pushes it at its lowest point, while its swing is below 12°.",
  "preset.paper-four-arms.words":
    "The example of the paper: two arms hang from the second joint. Released at rest from the horizontal.",
  "preset.triple.words": "Three equal arms, one below the other, released from the horizontal.",
  "preset.non-standard-triple.words":
    "Two arms hang from the tip of the first. In one mode they swing against each other and the first arm does not move: this start is close to it.",
  "preset.chain-10.words":
    "Ten equal arms, released straight and horizontal. The pull runs along the chain to its end, which snaps through.",
  "preset.star.words":
    "Eight arms around one tip, spread like spokes. They act on each other only through the hub.",
  "preset.binary-4.words": "Every arm carries two shorter and lighter ones, four levels deep.",
  "preset.whip.words":
    "Sixteen arms that become lighter towards the tip. A flick of the heavy end runs outwards, and the tip lashes.",
  "preset.thor.words":
    "A light trunk with two heavy arms that whirl in opposite directions and throw the joint about.",
  "preset.octopus.words": "Four tentacles of four arms each, on a heavy head.",
  "preset.mobile.words":
    "Arms of very different length and weight: a slow heavy swing with fast light ones on top.",
};
