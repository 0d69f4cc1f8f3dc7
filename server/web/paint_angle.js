// The angle of the chosen arm as schoolbooks draw it: a dashed line down from its joint, an arc
// from there to the arm, and its degrees.
// Leaves to others: which arm, and when (stage.js).
// Invariant: the arc turns as the angle is counted, counterclockwise from hanging.

import { foldedTheta, phiOf } from "./angles.js";

const LEAST = 2; // degrees, below which there is no arc to see
const MOST_RADIUS = 64; // pixels

/**
 * @param {CanvasRenderingContext2D} context @param {Look} look @param {number} arm
 * @param {string} words the angle with its name
 */
export function paintAngle(context, { shape, camera, colours }, arm, words) {
  const k = arm - 1;
  const theta = foldedTheta(shape.phi[k]);
  const long = camera.scale * shape.tree.length[k];
  const radius = Math.min(MOST_RADIUS, 0.45 * long);
  if (Math.abs(theta) < LEAST || radius < 12) return;
  const x = camera.x + camera.scale * shape.fromX[k];
  const y = camera.y - camera.scale * shape.fromY[k];
  context.strokeStyle = colours.accent;
  context.lineWidth = 1.5;
  context.setLineDash([5, 4]);
  context.beginPath();
  context.moveTo(x, y);
  context.lineTo(x, y + Math.min(long, radius + 30));
  context.stroke();
  context.setLineDash([]);
  context.beginPath();
  // a canvas counts angles clockwise
  context.arc(x, y, radius, Math.PI / 2, -phiOf(theta), theta > 0);
  context.stroke();
  // beside the dashed line, where the arm is not
  const side = theta > 0 ? -8 : 8;
  context.font = colours.font;
  context.textBaseline = "middle";
  context.textAlign = theta > 0 ? "right" : "left";
  context.lineWidth = 4;
  context.lineJoin = "round";
  context.strokeStyle = colours.glass;
  context.strokeText(words, x + side, y + radius);
  context.fillStyle = colours.ink;
  context.fillText(words, x + side, y + radius);
}
