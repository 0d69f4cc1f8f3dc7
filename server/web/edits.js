// What a hand or a key does to the pendulum: turn, lengthen, weigh, add, remove; each one step of history.
// Leaves to others: which hand (hands.js, arms.js, card.js).
// Invariant: whoever turns an arm turns the pendulum that is seen: its shape of now becomes the start, at rest.

import { still } from "./theme.js";
import { path, reach, removable, withArm, withoutBranch } from "./tree.js";

const SHORTEST = 0.05;
const LIGHTEST = 0.001;
const MOST_TRAILS = 5;

const tidy = (value) => Number(value.toPrecision(4));

/** The angle of the full turns nearest to `before`. */
export function nearest(angle, before) {
  return angle + 2 * Math.PI * Math.round((before - angle) / (2 * Math.PI));
}

export function createEdits(app) {
  const { store, motion, clock, text } = app;
  let grabbed = false;
  let resume = 0;

  const replaced = (list, k, value) => list.map((old, i) => (i === k ? value : old));

  const edits = {
    get grabbed() {
      return grabbed;
    },

    /** Takes hold of the pendulum: it stands still, as it is now, until release(). */
    grab() {
      clearTimeout(resume);
      if (grabbed) return;
      grabbed = true;
      clock.pause();
      motion.hold();
      store.settle();
      if (clock.time === 0) return;
      const { phi } = motion.at(clock.time);
      store.set(
        { initial: { phi: [...phi], phid: [...phi].map(() => 0) } },
        { label: "turn", merge: "grab" },
      );
    },
    /** Lets it go, now or in so many seconds: it moves. */
    release(seconds = 0) {
      clearTimeout(resume);
      if (seconds) {
        resume = setTimeout(edits.release, seconds * 1000);
        return;
      }
      if (!grabbed) return;
      grabbed = false;
      store.settle();
      motion.release();
      if (!still.matches) clock.play();
    },
    /** Lets it go and takes back what has been done since grab(). */
    cancel() {
      if (!grabbed) return;
      store.undo();
      edits.release();
    },
    /** While grabbed: the arm's angle, and its length where one is given. */
    turn(arm, angle, length = null) {
      const { initial, pendulum } = store.get();
      const phi = nearest(angle, initial.phi[arm - 1]);
      const patch = { initial: { ...initial, phi: replaced(initial.phi, arm - 1, phi) } };
      if (length !== null) {
        patch.pendulum = {
          ...pendulum,
          length: replaced(pendulum.length, arm - 1, Math.max(SHORTEST, tidy(length))),
        };
      }
      store.set(patch, { label: length === null ? "turn" : "length", merge: "grab" });
    },
    angle: (arm) => store.get().initial.phi[arm - 1],

    setLength(arm, length, merge = null) {
      const { pendulum } = store.get();
      store.set(
        {
          pendulum: {
            ...pendulum,
            length: replaced(pendulum.length, arm - 1, Math.max(SHORTEST, length)),
          },
        },
        { label: "length", merge },
      );
    },
    setMass(arm, mass, merge = null) {
      const { pendulum } = store.get();
      store.set(
        {
          pendulum: {
            ...pendulum,
            mass: replaced(pendulum.mass, arm - 1, Math.max(LIGHTEST, mass)),
          },
        },
        { label: "mass", merge },
      );
    },
    lengthen(arm, by) {
      edits.setLength(arm, tidy(store.get().pendulum.length[arm - 1] + by), `length ${arm}`);
    },
    weigh(arm, factor) {
      edits.setMass(arm, tidy(store.get().pendulum.mass[arm - 1] * factor), `mass ${arm}`);
    },
    setGravity(gravity) {
      store.set({ pendulum: { ...store.get().pendulum, gravity } }, { label: "gravity" });
    },
    /** The start's angle or angular velocity of an arm: name is "phi" or "phid". */
    setStart(arm, name, value) {
      const { initial } = store.get();
      store.set(
        { initial: { ...initial, [name]: replaced(initial[name], arm - 1, value) } },
        { label: name === "phi" ? "turn" : "spin" },
      );
    },

    add(carrier) {
      const doc = store.get();
      const { pendulum, initial } = doc;
      const siblings = pendulum.parent.filter((k) => k === carrier).length;
      const lean = [0.5, -0.5, 1.1, -1.1, 1.7, -1.7][siblings % 6];
      const arm = {
        length: tidy(pendulum.length[carrier - 1] * 0.75),
        mass: pendulum.mass[carrier - 1],
        phi: initial.phi[carrier - 1] + lean,
      };
      const number = pendulum.length.length + 1;
      const trails = doc.view.trails.map((tip) => (tip === carrier ? number : tip));
      store.set(
        { ...withArm(doc, carrier, arm), view: { selected: number, trails } },
        { label: "add" },
      );
      app.announce(text("said.added", { arm: number, carrier }));
    },
    remove(arm) {
      const doc = store.get();
      if (!removable(doc.pendulum.parent, arm)) return app.announce(text("said.last"));
      const patch = withoutBranch(doc, arm);
      const count = doc.pendulum.parent.length - patch.pendulum.parent.length;
      if (!patch.view.trails.length) patch.view.trails = [farthest(patch.pendulum)];
      store.set(patch, { label: "remove" });
      app.announce(text(count === 1 ? "said.removed" : "said.removed.branch", { arm, count }));
    },
    trail(arm) {
      const { trails } = store.get().view;
      const on = trails.includes(arm);
      store.set({
        view: {
          trails: on ? trails.filter((tip) => tip !== arm) : [...trails, arm].slice(-MOST_TRAILS),
        },
      });
      app.announce(text(on ? "said.trail.off" : "said.trail.on", { arm }));
    },
    select(arm) {
      if (store.get().view.selected !== arm) store.set({ view: { selected: arm } });
    },
    /** A pendulum of one arm, to build on. */
    begin() {
      store.set(
        {
          title: "",
          preset: null,
          ghosts: [],
          pendulum: { length: [1], mass: [1], parent: [0], gravity: 9.81 },
          initial: { phi: [-0.5], phid: [0] },
          view: { selected: 1, trails: [1] },
        },
        { label: "new" },
      );
    },
  };
  return edits;
}

/** The tip that can be farthest from the pivot: its trail is worth watching. */
export function farthest(tree) {
  const most = reach(tree) - 1e-9;
  const far = (arm) => path(tree.parent, arm).reduce((sum, k) => sum + tree.length[k - 1], 0);
  return Math.max(1, tree.length.findIndex((_, k) => far(k + 1) >= most) + 1);
}
