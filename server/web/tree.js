// A pendulum tree as arrays {length, mass, parent, gravity}: where its tips are, and trees made from it.
// Leaves to others: forces and motion, which only the server computes.
// Invariant: arms are numbered from 1, 0 is the pivot; trees made here are valid, what is given stays as it was.

/** Indices (from 0) of all arms such that every parent comes before its children. */
export function order(parent) {
  const rows = [];
  const kids = children(parent);
  const wait = [...kids[0]];
  while (wait.length) {
    const arm = wait.shift();
    rows.push(arm - 1);
    wait.push(...kids[arm]);
  }
  return rows;
}

/** children(parent)[arm]: the arms that hang on it; [0] those at the pivot. */
export function children(parent) {
  const rows = Array.from({ length: parent.length + 1 }, () => []);
  parent.forEach((carrier, k) => rows[carrier].push(k + 1));
  return rows;
}

/** Writes the tips of all arms into x, y (metres, pivot at 0, y upwards); phi from offset on. No allocation. */
export function tips(tree, rows, phi, offset, x, y) {
  for (let i = 0; i < rows.length; i++) {
    const k = rows[i];
    const carrier = tree.parent[k];
    const angle = phi[offset + k];
    x[k] = (carrier ? x[carrier - 1] : 0) + tree.length[k] * Math.cos(angle);
    y[k] = (carrier ? y[carrier - 1] : 0) + tree.length[k] * Math.sin(angle);
  }
}

/** The arms from the pivot to this arm, this arm last. */
export function path(parent, arm) {
  const rows = [];
  for (let k = arm; k > 0; k = parent[k - 1]) rows.unshift(k);
  return rows;
}

/** How far the farthest tip can be from the pivot. */
export function reach(tree) {
  const far = new Float64Array(tree.length.length);
  let most = 0;
  for (const k of order(tree.parent)) {
    far[k] = (tree.parent[k] ? far[tree.parent[k] - 1] : 0) + tree.length[k];
    if (far[k] > most) most = far[k];
  }
  return most;
}

/** The arm and all that hangs on it. */
export function branch(parent, arm) {
  const kids = children(parent);
  const rows = [arm];
  for (let i = 0; i < rows.length; i++) rows.push(...kids[rows[i]]);
  return rows;
}

/** Whether the branch may be taken away: something must stay. */
export function removable(parent, arm) {
  return branch(parent, arm).length < parent.length;
}

/** {pendulum, initial, ghosts} with one more arm on `carrier`, its number the last. */
export function withArm(doc, carrier, { length, mass, phi }) {
  const { pendulum } = doc;
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

/** {pendulum, initial, ghosts, view} without the arm and its branch; the others close up. */
export function withoutBranch(doc, arm) {
  const { pendulum } = doc;
  const gone = new Set(branch(pendulum.parent, arm));
  const keep = pendulum.parent.map((_, k) => k).filter((k) => !gone.has(k + 1));
  const number = new Map(keep.map((k, i) => [k + 1, i + 1]));
  const pick = (list) => keep.map((k) => list[k]);
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
      trails: doc.view.trails.filter((tip) => !gone.has(tip)).map((tip) => number.get(tip)),
    },
  };
}
