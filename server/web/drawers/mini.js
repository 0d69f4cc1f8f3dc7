// A tree in the small, on a canvas of its own: the thumbnails of modes and maps.
// Leaves to others: the angles, and when to draw.
// Invariant: all of the tree fits whatever the angles, unless it was told of less (fit).

import { h } from "../dom.js";
import { order, reach, tips } from "../tree.js";
import { cssValue } from "./kit.js";

/** {canvas, draw(phi, pale)}: a tree by its angles, over pale ones; `top` is how high the pivot stands, 0.5 the middle. */
export function createMini(tree, { width, height, top = 0.5, label = null }) {
  const ratio = Math.min(devicePixelRatio, 2);
  const canvas = h("canvas", {
    class: "mini",
    width: width * ratio,
    height: height * ratio,
    ...(label ? { role: "img", "aria-label": label } : { "aria-hidden": "true" }),
  });
  canvas.style.width = `${width}px`;
  canvas.style.height = `${height}px`;
  const context = canvas.getContext("2d");
  const rows = order(tree.parent);
  const n = rows.length;
  const x = new Float64Array(n);
  const y = new Float64Array(n);
  const thin = Math.max(1, Math.min(2.4, 14 / Math.sqrt(n)));
  let scale = Math.min(width / 2 - 8, height * (1 - top) - 8) / reach(tree);
  const heaviest = Math.max(...tree.mass);
  let colours = null;

  function strokes(phi, colour, tipColour) {
    tips(tree, rows, phi, 0, x, y);
    context.beginPath();
    for (let k = 0; k < n; k++) {
      const carrier = tree.parent[k];
      context.moveTo(
        scale * (carrier ? x[carrier - 1] : 0),
        -scale * (carrier ? y[carrier - 1] : 0),
      );
      context.lineTo(scale * x[k], -scale * y[k]);
    }
    context.strokeStyle = colour;
    context.lineWidth = thin;
    context.stroke();
    context.beginPath();
    for (let k = 0; k < n; k++) {
      const r = Math.max(thin * 0.9, thin * 1.8 * Math.cbrt(tree.mass[k] / heaviest));
      context.moveTo(scale * x[k] + r, -scale * y[k]);
      context.arc(scale * x[k], -scale * y[k], r, 0, 2 * Math.PI);
    }
    context.fillStyle = tipColour;
    context.fill();
  }

  return {
    canvas,
    recolour() {
      colours = null;
    },
    /** As large as the place allows for a tree that swings as far aside as in this pose. */
    fit(phi) {
      tips(tree, rows, phi, 0, x, y);
      const aside = x.reduce((most, value) => Math.max(most, Math.abs(value)), 1e-9);
      scale = Math.min((width / 2 - 8) / aside, (height * (1 - top) - 8) / reach(tree));
    },
    draw(phi, pale = []) {
      colours ??= {
        arm: cssValue("--accent"),
        mass: cssValue("--mass"),
        ghost: cssValue("--line"),
        pivot: cssValue("--quiet"),
      };
      context.setTransform(ratio, 0, 0, ratio, 0, 0);
      context.clearRect(0, 0, width, height);
      context.translate(width / 2, height * top);
      context.lineCap = "round";
      for (const angles of pale) strokes(angles, colours.ghost, colours.ghost);
      context.beginPath();
      context.moveTo(-10, 0);
      context.lineTo(10, 0);
      context.strokeStyle = colours.pivot;
      context.lineWidth = 1;
      context.stroke();
      strokes(phi, colours.arm, colours.mass);
    },
  };
}
