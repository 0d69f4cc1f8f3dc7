// A tree for what is to be drawn with many arms.

/** Puts a comb of 50 arms: a chain of 25 with an arm hung on each into the page. */
export const COMB = `(() => {
  const parent = [], length = [], mass = [], phi = [];
  for (let k = 0; k < 25; k++) {
    parent.push(k ? 2 * k - 1 : 0, 2 * k + 1);
    length.push(0.2, 0.3);
    mass.push(1, 0.3);
    phi.push(-0.4, -1.2);
  }
  pendulumd.store.set({ pendulum: { length, mass, parent, gravity: 9.81 }, initial: { phi, phid: phi.map(() => 0) }, preset: null,
    view: { trails: [49, 50], arrows: true, selected: 49 } });
})()`;
