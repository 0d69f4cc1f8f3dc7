// Elements in one line, icons, and what a view must end when it goes.
// Leaves to others: all that has a meaning.
// Invariant: text goes in as text; nothing here reads HTML.

/** @typedef {Node | string | null | undefined | false} Child */

/**
 * h("button", {class, type, on: {click}, "aria-label": ...}, child, "text", ...)
 * @template {keyof HTMLElementTagNameMap} Tag
 * @param {Tag} tag @param {Record<string, any>} attributes @param {...Child} children
 * @returns {HTMLElementTagNameMap[Tag]}
 */
export function h(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name === "on") {
      for (const [event, listener] of Object.entries(value)) {
        element.addEventListener(event, /** @type {EventListener} */ (listener));
      }
    } else if (value === true) element.setAttribute(name, "");
    else if (value !== false && value !== null && value !== undefined)
      element.setAttribute(name, value);
  }
  element.append(
    ...children.filter((child) => child !== null && child !== undefined && child !== false),
  );
  return element;
}

/**
 * An SVG element.
 * @param {string} tag @param {Record<string, any>} attributes
 * @param {...(Node | string)} children
 */
export function svg(tag, attributes, ...children) {
  const element = document.createElementNS("http://www.w3.org/2000/svg", tag);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
  element.append(...children);
  return element;
}

// 24 x 24; F is filled, S is stroked
/** @type {Record<string, string>} */
const ICONS = {
  play: "F M8 5.2v13.6L19 12z",
  pause: "F M7 5h3.6v14H7zM13.4 5H17v14h-3.6z",
  back: "F M17 6.2v11.6L9 12zM6 6h2.2v12H6z",
  forward: "F M7 6.2v11.6L15 12zM15.8 6H18v12h-2.2z",
  start: "F M19 6.2v11.6L12 12zM12.5 6.2v11.6L5.5 12z",
  loop: "S M17 3.5l3 3-3 3M4 11.5v-1.5a3.5 3.5 0 0 1 3.5-3.5H20M7 20.5l-3-3 3-3M20 12.5v1.5a3.5 3.5 0 0 1-3.5 3.5H4",
  undo: "S M8.5 14L4 9.5 8.5 5M4 9.5h10a5 5 0 0 1 0 10h-3",
  redo: "S M15.5 14L20 9.5 15.5 5M20 9.5H10a5 5 0 0 0 0 10h3",
  help: "S M9 9.2a3 3 0 1 1 4.6 2.5c-1 .7-1.6 1.2-1.6 2.5M12 17.5h.01M12 3a9 9 0 1 0 0 18 9 9 0 0 0 0-18z",
  light:
    "S M12 3v2M12 19v2M3 12h2M19 12h2M5.6 5.6l1.4 1.4M17 17l1.4 1.4M5.6 18.4L7 17M17 7l1.4-1.4M12 8a4 4 0 1 0 0 8 4 4 0 0 0 0-8z",
  dark: "S M20 14.5A8.5 8.5 0 0 1 9.5 4 8.5 8.5 0 1 0 20 14.5z",
  plus: "S M12 5v14M5 12h14",
  menu: "S M4 7h16M4 12h16M4 17h16",
  swap: "S M4 8h14M14 4l4 4-4 4M20 16H6M10 12l-4 4 4 4",
  more: "S M5 12h.01M12 12h.01M19 12h.01",
  close: "S M6 6l12 12M18 6L6 18",
  trash: "S M5 7h14M10 7V4.5h4V7M7 7l.8 12.5h8.4L17 7M10.5 10.5v5.5M13.5 10.5v5.5",
  trail: "S M3 17c3 0 3-9 7-9s3 7 6 7 3-5 5-5",
  arrows: "S M5 19L19 5M12 5h7v7",
};

/** @param {string} name */
export function icon(name) {
  // what the style says is said here too: without it the icon would have no size and be a blot
  const filled = ICONS[name][0] === "F";
  const stroke = filled ? "none" : "currentColor";
  const plain = { width: 20, height: 20, fill: filled ? "currentColor" : "none", stroke };
  const look = { viewBox: "0 0 24 24", class: filled ? "icon filled" : "icon", ...plain };
  return svg("svg", { "aria-hidden": "true", ...look }, svg("path", { d: ICONS[name].slice(2) }));
}

/**
 * A button with an icon and no words: its label is for those who cannot see it, and its title.
 * @param {string} name @param {string} label @param {() => unknown} click @param {Record<string,
 * any>} attributes
 */
export function iconButton(name, label, click, attributes = {}) {
  return h(
    "button",
    {
      type: "button",
      class: "icon-button",
      "aria-label": label,
      title: label,
      on: { click },
      ...attributes,
    },
    icon(name),
  );
}

/** Collects what a view has begun: bag(end), and bag.end() ends it all. @returns {Bag} */
export function createBag() {
  /** @type {End[]} */
  const ends = [];
  const bag = /** @type {Bag} */ ((end) => ends.push(end));
  bag.end = () => ends.splice(0).forEach((end) => end());
  /** Listens until the view goes. */
  bag.on = (target, event, listener, options) => {
    target.addEventListener(event, listener, options);
    bag(() => target.removeEventListener(event, listener, options));
  };
  return bag;
}
