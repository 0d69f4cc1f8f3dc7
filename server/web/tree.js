// A pendulum tree as arrays {length, mass, parent, gravity}: where its tips are, and trees made
// from it.
// Leaves to others: forces and motion, which only the server computes.
// Invariant: arms are numbered from 1, 0 is the pivot; trees made here are valid, what is given
// stays as it was.

/**
 * Indices (from 0) of all arms such that every parent comes before its children.
 * @param {number[]} parent
 */
export function order(parent) {
  /** @type {number[]} */
  const rows = [];
  const kids = children(parent);
  const wait = [...kids[0]];
  for (let i = 0; i < wait.length; i++) {
    rows.push(wait[i] - 1);
    wait.push(...kids[wait[i]]);
  }
  return rows;
}

/**
 * children(parent)[arm]: the arms that hang on it; [0] those at the pivot.
 * @param {number[]} parent
 */
export function children(parent) {
  /** @type {number[][]} */
  const rows = Array.from({ length: parent.length + 1 }, () => []);
  parent.forEach((carrier, k) => rows[carrier].push(k + 1));
  return rows;
}

/**
 * Writes the tips of all arms into x, y (metres, pivot at 0, y upwards); phi from offset on. No
 * allocation.
 * @param {Tree} tree @param {number[]} rows @param {ArrayLike<number>} phi @param {number} offset
 * @param {Float64Array} x @param {Float64Array} y
 */
export function tips(tree, rows, phi, offset, x, y) {
  for (let i = 0; i < rows.length; i++) {
    const k = rows[i];
    const carrier = tree.parent[k];
    const angle = phi[offset + k];
    x[k] = (carrier ? x[carrier - 1] : 0) + tree.length[k] * Math.cos(angle);
    y[k] = (carrier ? y[carrier - 1] : 0) + tree.length[k] * Math.sin(angle);
  }
}

/**
 * The arms from the pivot to this arm, this arm last.
 * @param {number[]} parent @param {number} arm
 */
export function path(parent, arm) {
  /** @type {number[]} */
  const rows = [];
  for (let k = arm; k > 0; k = parent[k - 1]) rows.unshift(k);
  return rows;
}

/** How far the farthest tip can be from the pivot. @param {Tree} tree */
export function reach(tree) {
  const far = new Float64Array(tree.length.length);
  let most = 0;
  for (const k of order(tree.parent)) {
    far[k] = (tree.parent[k] ? far[tree.parent[k] - 1] : 0) + tree.length[k];
    if (far[k] > most) most = far[k];
  }
  return most;
}

/** The arm and all that hangs on it. @param {number[]} parent @param {number} arm */
export function branch(parent, arm) {
  const kids = children(parent);
  const rows = [arm];
  for (let i = 0; i < rows.length; i++) rows.push(...kids[rows[i]]);
  return rows;
}

/**
 * Whether the branch may be taken away: something must stay.
 * @param {number[]} parent @param {number} arm
 */
export function removable(parent, arm) {
  return branch(parent, arm).length < parent.length;
}

/**
 * {pendulum, initial, ghosts} with one more arm on `carrier`, its number the last.
 * @param {Doc} doc @param {number} carrier @param {{length: number, mass: number, phi: number}} arm
 */
export function withArm(doc, carrier, { length, mass, phi }) {
  const { pendulum } = doc;
  /** @template {State} Start @param {Start} state @returns {Start} */
  const longer = (state) => ({ ...state, phi: [...state.phi, phi], phid: [...state.phid, 0] });
  return {
    pendulum: {
      ...pendulum,
      length: [...pendulum.length, length],
      mass: [...pendulum.mass, mass],
      parent: [...pendulum.parent, carrier],
    },
    initial: longer(doc.initial),
    ghosts: doc.ghosts.map(longer),
  };
}

/**
 * {pendulum, initial, ghosts, view} without the arm and its branch; the others close up.
 * @param {Doc} doc @param {number} arm
 */
export function withoutBranch(doc, arm) {
  const { pendulum } = doc;
  const gone = new Set(branch(pendulum.parent, arm));
  const keep = pendulum.parent.map((_, k) => k).filter((k) => !gone.has(k + 1));
  const number = new Map(keep.map((k, i) => [k + 1, i + 1]));
  /** @param {number[]} list */
  const pick = (list) => keep.map((k) => list[k]);
  /** @template {State} Start @param {Start} state @returns {Start} */
  const shorter = (state) => ({ ...state, phi: pick(state.phi), phid: pick(state.phid) });
  return {
    pendulum: {
      ...pendulum,
      length: pick(pendulum.length),
      mass: pick(pendulum.mass),
      parent: pick(pendulum.parent).map((carrier) => number.get(carrier) ?? 0),
    },
    initial: shorter(doc.initial),
    ghosts: doc.ghosts.map(shorter),
    view: {
      ...doc.view,
      selected: number.get(pendulum.parent[arm - 1]) ?? 0,
      trails: doc.view.trails.filter((tip) => !gone.has(tip)).map((tip) => number.get(tip) ?? 0),
    },
  };
}
