// A part of a drawer that is loaded when it is opened.
// Leaves to others: what the part is.
// Invariant: a part whose files do not come closes again, says so, and is asked for again when it
// is opened again.

import { said } from "../../client.js";
import { h } from "../../dom.js";
import { isStatic } from "../../root.js";
import { serverless } from "./kit.js";

/**
 * {element, open, hide, destroy}; open() opens it and resolves with what its script's default
 * export has made.
 * @param {App} app @param {string} part its script, as folder/name; the name stands in `data-part`
 * @param {string} words what it is called @param {boolean} served whether it needs a server
 */
export function lazyPart(app, part, words, served = false) {
  const { files, text } = app;
  const name = part.replace(/.*\//, "");
  /** @type {Promise<any> | null} */
  let coming = null;
  const details = h("details", { class: "lazy", "data-part": name }, h("summary", {}, words));
  const lacks = served && isStatic;
  if (lacks) details.firstElementChild?.classList.add("greyed");
  const come = async () => {
    if (lacks) {
      details.append(serverless(text));
      return { destroy() {} };
    }
    const { default: mount } = await files.script(`drawers/${part}.js`);
    const made = await mount(app);
    details.append(made.element);
    return made;
  };
  const open = () => {
    details.open = true;
    coming ??= come();
    coming.catch((error) => {
      coming = null;
      details.open = false;
      app.complain(said(error.kind ? error : { kind: "file" }, text));
    });
    return coming;
  };
  details.addEventListener("toggle", () => details.open && open());
  const ended = () => {};
  return {
    element: details,
    open,
    hide: () => coming?.then((made) => made.hide?.(), ended),
    destroy: () => coming?.then((made) => made.destroy(), ended),
  };
}
