// Scenes: what a link stands for. `#d=` holds all of it, `#s=` names one that the server keeps.
// Leaves to others: storing (client.storeScene), showing the link (drawers/share.js).
// Invariant: documentOf(sceneOf(doc)) has the motion of doc, to the bit.

import { fromRequest, request } from "./state.js";

/** {title, request, view} of a document, as /v1/scenes takes it. */
export function sceneOf(doc) {
  const scene = { request: request(doc), view: { ...doc.view, ghosts: doc.ghosts } };
  if (doc.title) scene.title = doc.title;
  return scene;
}

/** The patch of a scene. */
export function documentOf(scene) {
  const { ghosts = [], ...view } = scene.view ?? {};
  const arms = scene.request.pendulum.length.length;
  const fits = ghosts.filter((ghost) => ghost?.phi?.length === arms && ghost?.phid?.length === arms);
  return { ...fromRequest(scene.request), title: scene.title ?? "", preset: null, ghosts: fits, view };
}

async function through(stream, bytes) {
  const writer = stream.writable.getWriter();
  writer.write(bytes).catch(() => {});
  writer.close().catch(() => {});
  return new Uint8Array(await new Response(stream.readable).arrayBuffer());
}

/** "#d=..." : needs no store. */
export async function linkOf(doc) {
  const bytes = await through(new CompressionStream("deflate-raw"), new TextEncoder().encode(JSON.stringify(sceneOf(doc))));
  const letters = btoa(Array.from(bytes, (byte) => String.fromCharCode(byte)).join(""));
  return `#d=${letters.replaceAll("+", "-").replaceAll("/", "_").replace(/=+$/, "")}`;
}

/** The patch that a hash stands for, null without one; throws where it is damaged or the server has no such scene. */
export async function readLink(hash, client) {
  const [, kind, rest] = /^#([sd])=(.+)$/.exec(hash) ?? [];
  if (kind === "s") return documentOf(await client.scene(rest));
  if (kind !== "d") return null;
  const packed = atob(rest.replaceAll("-", "+").replaceAll("_", "/"));
  const bytes = await through(new DecompressionStream("deflate-raw"), Uint8Array.from(packed, (letter) => letter.charCodeAt(0)));
  return documentOf(JSON.parse(new TextDecoder().decode(bytes)));
}
