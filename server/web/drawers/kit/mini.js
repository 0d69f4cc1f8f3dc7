// A tree in the small, on a canvas of its own: the thumbnails of modes and maps.
// Leaves to others: the angles, and when to draw.
// Invariant: all of the tree fits whatever the angles, unless it was told of less (fit).

import { h } from "../../dom.js";
import { paintHook, paintSmall } from "../../preset_picture.js";
import { massOf } from "../../terms.js";
import { createSpots, order, reach, tips } from "../../tree.js";
import { cssValue } from "./kit.js";

/** @typedef {{width: number, height: number, top?: number, label?: string | null}} MiniOptions */

/**
 * @typedef {{canvas: HTMLCanvasElement, recolour(): void, fit(phi: ArrayLike<number>): void,
 * draw(phi: ArrayLike<number>, pale?: ArrayLike<number>[]): void}} Mini
 */

/** What it is drawn with. @typedef {{
 *   context: CanvasRenderingContext2D, tree: Tree, rows: number[], spots: Spots,
 *   thin: number, heaviest: number, scale: number,
 * }} Sketch */

/** @param {MiniOptions} options */
function canvasOf({ width, height, label = null }) {
  const ratio = Math.min(devicePixelRatio, 2);
  const name = label ? { role: "img", "aria-label": label } : { "aria-hidden": "true" };
  const canvas = h("canvas", {
    class: "mini",
    width: width * ratio,
    height: height * ratio,
    ...name,
  });
  canvas.style.width = `${width}px`;
  canvas.style.height = `${height}px`;
  return { canvas, ratio };
}

/**
 * @param {Sketch} sketch @param {ArrayLike<number>} phi @param {string} colour @param {string}
 * tipColour
 */
function strokes({ context, tree, rows, spots, thin, heaviest, scale }, phi, colour, tipColour) {
  tips(tree, rows, phi, 0, spots);
  paintSmall(context, tree, spots, { x: 0, y: 0, scale }, thin, heaviest, colour, tipColour);
}

const readColours = () => ({
  arm: cssValue("--accent"),
  mass: cssValue("--mass"),
  ghost: cssValue("--line"),
  pivot: cssValue("--quiet"),
});

/** @param {Tree} tree @param {CanvasRenderingContext2D} context @returns {Sketch} */
function sketchOf(tree, context) {
  const rows = order(tree.parent);
  const n = rows.length;
  const thin = Math.max(1, Math.min(2.4, 14 / Math.sqrt(n)));
  const heaviest = Math.max(...tree.mass.map((_, k) => massOf(tree, k)));
  return { context, tree, rows, spots: createSpots(n), thin, heaviest, scale: 1 };
}

/**
 * A tree by its angles, over pale ones; `top` is how high the pivot stands, 0.5 the middle.
 * @param {Tree} tree @param {MiniOptions} options @returns {Mini}
 */
export function createMini(tree, options) {
  const { width, height, top = 0.5 } = options;
  const { canvas, ratio } = canvasOf(options);
  const context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
  const sketch = sketchOf(tree, context);
  sketch.thin *= Math.max(1, width / 200);
  const deep = (height * (1 - top) - 8) / reach(tree);
  sketch.scale = Math.min((width / 2 - 8) / reach(tree), deep);
  /** @type {ReturnType<typeof readColours> | null} */
  let colours = null;

  return {
    canvas,
    recolour() {
      colours = null;
    },
    /** As large as the place allows for a tree that swings as far aside as in this pose. */
    fit(phi) {
      tips(tree, sketch.rows, phi, 0, sketch.spots);
      const aside = sketch.spots.x.reduce((most, value) => Math.max(most, Math.abs(value)), 1e-9);
      sketch.scale = Math.min((width / 2 - 8) / aside, deep);
    },
    draw(phi, pale = []) {
      colours ??= readColours();
      context.setTransform(ratio, 0, 0, ratio, 0, 0);
      context.clearRect(0, 0, width, height);
      context.translate(width / 2, height * top);
      for (const angles of pale) strokes(sketch, angles, colours.ghost, colours.ghost);
      paintHook(context, 0, 0, colours.pivot);
      strokes(sketch, phi, colours.arm, colours.mass);
    },
  };
}
