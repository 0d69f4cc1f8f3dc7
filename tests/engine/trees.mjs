// Requests about random pendulums, the same on every machine.
// Leaves to others: asking (bits.mjs).
// Invariant: a seed gives one list.

/** Numbers in [0, 1) of a seed. @param {number} seed */
export function random(seed) {
  let state = seed >>> 0;
  return () => {
    state = (state + 0x6d2b79f5) >>> 0;
    let x = Math.imul(state ^ (state >>> 15), state | 1);
    x ^= x + Math.imul(x ^ (x >>> 7), x | 61);
    return ((x ^ (x >>> 14)) >>> 0) / 2 ** 32;
  };
}

const SHAPES = {
  attached: (k, draw) => Math.floor(draw() * k) + 1,
  chain: (k) => k,
  star: () => 1,
  binary: (k) => Math.floor((k - 1) / 2) + 1,
  caterpillar: (k) => (k % 2 ? k : Math.max(1, k - 1)),
};

/** A pendulum of n arms. */
export function tree(n, shape, draw) {
  const parent = Array.from({ length: n }, (_, k) => (k ? SHAPES[shape](k, draw) : 0));
  const list = (make) => Array.from({ length: n }, make);
  return {
    pendulum: {
      length: list(() => 10 ** (0.6 * draw() - 0.3)),
      mass: list(() => 10 ** (2 * draw() - 1)),
      parent,
    },
    initial: {
      phi: list(() => 6 * draw() - 3 - Math.PI / 2),
      phid: list(() => 6 * draw() - 3),
    },
  };
}

/** What is real of a real pendulum, in each of a few ways. */
function real(motion, draw) {
  const n = motion.pendulum.length.length;
  const list = (size) => Array.from({ length: n }, () => size * draw());
  const ways = [
    () => ({ damping: list(0.1) }),
    () => ({ stiffness: list(3), rest: list(1) }),
    () => ({ damping: list(0.1), stiffness: list(3), rest: list(1) }),
  ];
  const more = ways[Math.floor(draw() * ways.length)]();
  return { ...motion, pendulum: { ...motion.pendulum, ...more } };
}

const OUTPUTS = [
  ["phi", "phid", "lambda", "energy"],
  ["phi", "lambda"],
  ["phi", "phid", "z", "energy"],
];

/** What is asked of a motion for `seconds`. */
function trajectory(motion, i, seconds) {
  const accept = i % 4 ? "application/octet-stream" : "application/json";
  const times = { start: 0, stop: seconds, step: 0.05 };
  return { operation: "trajectories", accept, body: { ...motion, times, output: OUTPUTS[i % OUTPUTS.length] } };
}

/** Request i of a list: {operation, accept, body}. */
export function request(i, draw) {
  const shapes = Object.keys(SHAPES);
  const shape = shapes[i % shapes.length];
  const motion = tree(1 + Math.floor(draw() ** 3 * 70), shape, draw);
  const { pendulum, initial } = motion;
  const accept = "application/json";
  switch (i % 20) {
    case 14:
      return trajectory({ ...tree(1 + (i % 6), shape, draw), method: "symplectic" }, i, 0.2);
    case 13:
      return {
        operation: "trajectories",
        accept: "application/octet-stream",
        body: {
          ...trajectory(real(tree(1 + (i % 6), shape, draw), draw), i, 0.5).body,
          method: "radau",
          output: ["phi", "phid", "lambda"],
        },
      };
    case 15:
    case 16:
      // places and energies of these take sines of the C library, whose last digits differ
      return {
        operation: "trajectories",
        accept: "application/octet-stream",
        body: { ...trajectory(real(motion, draw), i, 0.5).body, output: ["phi", "phid", "lambda"] },
      };
    case 17:
      return { operation: "forces", accept, body: { pendulum, states: [initial] } };
    case 18:
      return { operation: "modes", accept, body: { pendulum } };
    case 19:
      return { operation: "trees", accept, body: { pendulum } };
    default:
      return trajectory(motion, i, 0.5 + draw());
  }
}
