// What a hand or a key does to the pendulum: turn, lengthen, weigh, add, remove; each one step of
// history.
// Leaves to others: which hand (hands.js, arms.js, card.js).
// Invariant: whoever turns an arm turns the pendulum that is seen: its shape of now becomes the
// start, at rest.

import { foldedTheta, phiOf } from "./angles.js";
import { still } from "./screen.js";
import { isBeside } from "./state.js";
import { massOf } from "./terms.js";
import { path, reach, removable, tipMass, withArm, withoutBranch } from "./tree.js";

const SHORTEST = 0.05;
const LIGHTEST = 0.001;
const MOST_TRAILS = 5;

/** @param {number} value */
const tidy = (value) => Number(value.toPrecision(4));

/** The angle of the full turns nearest to `before`. @param {number} angle @param {number} before */
export function nearest(angle, before) {
  return angle + 2 * Math.PI * Math.round((before - angle) / (2 * Math.PI));
}

/** @param {number[]} list @param {number} k @param {number} value */
const replaced = (list, k, value) => list.map((old, i) => (i === k ? value : old));

/** An instant's shape, at rest. @param {Tree} tree @param {Instant} instant @returns {State} */
function restOf({ pivot }, { phi, cart }) {
  const rest = { phi: [...phi], phid: [...phi].map(() => 0) };
  return pivot?.cart ? { ...rest, cart: { x: cart, v: 0 } } : rest;
}

/** Taking hold of the pendulum, turning it, letting it go. @param {App} app */
function holding({ store, motion, clock }) {
  let grabbed = false;
  let resume = 0;

  const verbs = {
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
      const initial = restOf(store.get().pendulum, motion.at(clock.time));
      store.set({ initial }, { label: "turn", merge: "grab" });
    },
    /** Lets it go, now or in so many seconds: it moves. */
    release(seconds = 0) {
      clearTimeout(resume);
      if (seconds) {
        resume = window.setTimeout(() => verbs.release(), seconds * 1000);
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
      verbs.release();
    },
    /**
     * While grabbed: the arm's angle, and its length where one is given.
     * @param {number} arm @param {number} angle @param {number | null} length
     */
    turn(arm, angle, length = null) {
      const { initial, pendulum } = store.get();
      const k = arm - 1;
      const phi = replaced(initial.phi, k, nearest(angle, initial.phi[k]));
      /** @type {Patch} */
      const patch = { initial: { ...initial, phi } };
      if (length !== null) {
        const longer = replaced(pendulum.length, k, Math.max(SHORTEST, tidy(length)));
        patch.pendulum = { ...pendulum, length: longer };
      }
      store.set(patch, { label: length === null ? "turn" : "length", merge: "grab" });
    },
  };
  return verbs;
}

/** Numbers that are set, and those that are changed by keys. @param {App} app */
function numbers({ store }) {
  /** @param {number} arm @param {number} length @param {string | null} merge */
  function setLength(arm, length, merge = null) {
    const { pendulum } = store.get();
    const changed = replaced(pendulum.length, arm - 1, Math.max(SHORTEST, length));
    store.set({ pendulum: { ...pendulum, length: changed } }, { label: "length", merge });
  }
  /** @param {number} arm @param {number} mass @param {string | null} merge */
  function setMass(arm, mass, merge = null) {
    const { pendulum } = store.get();
    // a bar or a body needs no mass at its tip
    const heavy = massOf(pendulum, arm - 1) > pendulum.mass[arm - 1];
    const changed = replaced(pendulum.mass, arm - 1, Math.max(heavy ? 0 : LIGHTEST, mass));
    store.set({ pendulum: { ...pendulum, mass: changed } }, { label: "mass", merge });
  }
  return {
    setLength,
    setMass,
    /** @param {number} arm */
    angle: (arm) => store.get().initial.phi[arm - 1],
    /** @param {number} arm @param {number} by */
    lengthen(arm, by) {
      setLength(arm, tidy(store.get().pendulum.length[arm - 1] + by), `length ${arm}`);
    },
    /** @param {number} arm @param {number} factor */
    weigh(arm, factor) {
      setMass(arm, tidy(store.get().pendulum.mass[arm - 1] * factor), `mass ${arm}`);
    },
    /** @param {number} gravity */
    setGravity(gravity) {
      store.set({ pendulum: { ...store.get().pendulum, gravity } }, { label: "gravity" });
    },
    /**
     * The start's angle or angular velocity of an arm.
     * @param {number} arm @param {"phi" | "phid"} name @param {number} value
     */
    setStart(arm, name, value) {
      const { initial } = store.get();
      const changed = { ...initial, [name]: replaced(initial[name], arm - 1, value) };
      store.set({ initial: changed }, { label: name === "phi" ? "turn" : "spin" });
    },
  };
}

/**
 * The document with an arm more on `carrier`: as long as that, a round angle aside.
 * @param {Doc} doc @param {number} carrier
 */
function grown(doc, carrier) {
  const { pendulum, initial } = doc;
  const siblings = pendulum.parent.filter((k) => k === carrier).length;
  const lean = [30, -30, 60, -60, 90, -90][siblings % 6];
  return withArm(doc, carrier, {
    length: pendulum.length[carrier - 1],
    mass: tipMass(pendulum, carrier),
    phi: phiOf(Math.round(foldedTheta(initial.phi[carrier - 1])) + lean),
  });
}

/** The last arm that carries none. @param {number[]} parent */
const lastTip = (parent) => parent.findLastIndex((_, k) => !parent.includes(k + 1)) + 1;

/** Arms that are added, taken away, chosen, followed by a trail. @param {App} app */
function branches({ store, text, announce }) {
  return {
    /** @param {number} carrier */
    add(carrier) {
      const doc = store.get();
      const number = doc.pendulum.length.length + 1;
      const trails = doc.view.trails.map((tip) => (tip === carrier ? number : tip));
      const view = { selected: number, trails };
      store.set({ ...grown(doc, carrier), view }, { label: "add" });
      announce(text("said.added", { arm: number, carrier }));
    },
    /** @param {number} arm */
    remove(arm) {
      const doc = store.get();
      if (!removable(doc.pendulum.parent, arm)) return announce(text("said.last"));
      const patch = withoutBranch(doc, arm);
      const count = doc.pendulum.parent.length - patch.pendulum.parent.length;
      if (!patch.view.trails.length) patch.view.trails = [farthest(patch.pendulum)];
      store.set(patch, { label: "remove" });
      announce(text(count === 1 ? "said.removed" : "said.removed.branch", { arm, count }));
    },
    /** So many arms: more hang on the last one, or the last ones go. @param {number} count */
    resize(count) {
      let doc = store.get();
      const before = doc.pendulum.parent.length;
      for (let n = before; n < count; n++) doc = { ...doc, ...grown(doc, n) };
      for (let n = before; n > count; n--) {
        const { pendulum, initial, ghosts } = withoutBranch(doc, lastTip(doc.pendulum.parent));
        doc = { ...doc, pendulum, initial, ghosts };
      }
      const { pendulum, initial, ghosts } = doc;
      const view = { selected: 0, trails: [farthest(pendulum)] };
      store.set({ pendulum, initial, ghosts, view }, { label: count < before ? "remove" : "add" });
      announce(text.count("stage.label", count));
    },
    /** @param {number} arm */
    trail(arm) {
      const { trails } = store.get().view;
      const on = trails.includes(arm);
      const others = trails.filter((tip) => tip !== arm);
      store.set({ view: { trails: on ? others : [...trails, arm].slice(-MOST_TRAILS) } });
      announce(text(on ? "said.trail.off" : "said.trail.on", { arm }));
    },
    /** @param {number} arm */
    select(arm) {
      if (store.get().view.selected !== arm) store.set({ view: { selected: arm } });
    },
    /** A pendulum of one arm, to build on. */
    begin() {
      const pendulum = { length: [1], mass: [1], parent: [0], gravity: 9.81 };
      const initial = { phi: [phiOf(60)], phid: [0] };
      const view = { selected: 1, trails: [1] };
      store.set({ title: "", preset: null, ghosts: [], pendulum, initial, view }, { label: "new" });
    },
  };
}

/** Two pendulums side by side, of which the tools show one. @param {App} app */
function pairs({ store, motion, text, announce }) {
  const label = { label: "beside" };
  return {
    /** A second pendulum beside this one, half as long. */
    addBeside() {
      const { pendulum, initial, ghosts } = store.get();
      const half = { ...pendulum, length: pendulum.length.map((length) => tidy(length / 2)) };
      const second = { ...initial, pendulum: half, beside: 1 };
      store.set({ ghosts: [...ghosts.filter((ghost) => !isBeside(ghost)), second] }, label);
    },
    /** The tools show the other one, and this one goes on beside it. */
    swap() {
      const doc = store.get();
      const i = doc.ghosts.findIndex(isBeside);
      if (i < 0) return;
      const { phi, phid, cart, pendulum = doc.pendulum, beside = 1 } = doc.ghosts[i];
      const own = { ...doc.initial, pendulum: doc.pendulum, beside: -beside };
      const ghosts = doc.ghosts.map((ghost, k) => (k === i ? own : ghost));
      const initial = cart ? { phi, phid, cart } : { phi, phid };
      motion.exchange(i);
      const { preset, title } = doc;
      store.set({ pendulum, initial, ghosts, preset, title }, label);
      motion.exchange(-1);
      announce(text("said.swapped", { length: text.short(pendulum.length[0]) }));
    },
  };
}

/** @param {App} app @returns {Edits} */
export function createEdits(app) {
  const edits = holding(app);
  Object.assign(edits, numbers(app), branches(app), pairs(app));
  return /** @type {Edits} */ (edits);
}

/** The tip that can be farthest from the pivot: its trail is worth watching. @param {Tree} tree */
export function farthest(tree) {
  const most = reach(tree) - 1e-9;
  /** @param {number} arm */
  const far = (arm) => path(tree.parent, arm).reduce((sum, k) => sum + tree.length[k - 1], 0);
  return Math.max(1, tree.length.findIndex((_, k) => far(k + 1) >= most) + 1);
}
