// Where the page is: what stands before the paths of all that it asks for, also behind a proxy that
// gives it a path (https://school/pendulum/).
// Leaves to others: the files of one version (files.js).
// Invariant: every document of the page lies directly below it (/, /docs, /CODE), so that what they
// name is found from each of them.

/** Whether the page lies in a folder of a web host, without a server that computes (make site). */
export const isStatic = "static" in document.documentElement.dataset;

/** The reference. */
export const DOCS = isStatic ? "docs.html" : "docs";

/** With its host, and a slash at the end. */
export const ROOT = new URL("./", location.href).href;

/** The address of a path of the interface or of the page. @param {string} path begins with "/" */
export const urlOf = (path) => ROOT + path.slice(1);
