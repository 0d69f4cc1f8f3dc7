// The page's service worker: it keeps one version of the page in the browser, so that the page
// opens where no server answers.
// Leaves to others: asking for it, telling of another version (offline.js); computing then
// (engine.js).
// Invariant: kept are the page's documents and the files under its digest, in a cache of that
// digest; nothing else is answered here, no answer of the interface and nothing of a class. A
// server without this file (404, 410) ends it, with all that it keeps.

{
  /** @type {any} */
  const worker = self;
  /** Set where the page is made (assets_embed.py): its path, and its files with a blank between. */
  const PAGE = "@PAGE@";
  const FILES = "@FILES@".split(" ");
  const SCOPE = new URL("./", location.href);
  const MINE = `pendulumd ${SCOPE.pathname} `;
  const CACHE = MINE + PAGE;
  const DOCUMENTS = ["", "?embed=1"].map((query) => new URL(query, SCOPE).href);
  /** s that a server has for the document before what is kept is shown. */
  const PATIENCE = 6;
  /** What a visit may do without, or asks for by its language. */
  const LATER = /^(docs|class\/|text\/|sheets\/|lib\/fonts\/|lib\/licenses|icon)/;

  const addressOf = (/** @type {string} */ file) => new URL(`${PAGE}/${file}`, SCOPE).href;
  const first = FILES.filter((file) => file && !LATER.test(file)).map(addressOf);

  const keepAll = async () => {
    const cache = await caches.open(CACHE);
    await cache.addAll([
      ...DOCUMENTS.map((address) => new Request(address, { cache: "no-cache" })),
      ...first,
    ]);
  };

  /** Erases other versions, unless another window may still need theirs. */
  const tidy = async () => {
    const windows = await worker.clients.matchAll({ type: "window", includeUncontrolled: true });
    if (windows.length > 1) return;
    for (const name of await caches.keys())
      if (name.startsWith(MINE) && name !== CACHE) await caches.delete(name);
  };

  /** A server that has no such worker any more ends this one. */
  const leaveIfUnwanted = async () => {
    const reply = await fetch(location.href, { method: "HEAD", cache: "no-store" }).catch(
      () => null,
    );
    if (reply?.status !== 404 && reply?.status !== 410) return;
    for (const name of await caches.keys()) if (name.startsWith(MINE)) await caches.delete(name);
    await worker.registration.unregister();
  };

  /** What this version has kept, where the browser lets it. @param {string} address */
  const kept = async (address) => (await caches.open(CACHE)).match(address, { ignoreVary: true });
  const nothing = () => undefined;

  /** The words and worksheets of a language. @param {string} language */
  const keepLanguage = async (language) => {
    const cache = await caches.open(CACHE);
    const own = (/** @type {string} */ file) =>
      file.startsWith(`text/${language}/`) || file.startsWith("sheets/");
    const here = await Promise.all(
      FILES.filter(own)
        .map(addressOf)
        .map(async (address) => ((await cache.match(address)) ? [] : [address])),
    );
    await cache.addAll(here.flat());
  };

  /** The server's document, what is kept where it has none. @param {any} event */
  const answer = async ({ request }) => {
    const embedded = new URL(request.url).searchParams.get("embed") === "1";
    const own = () => kept(DOCUMENTS[embedded ? 1 : 0]).catch(nothing);
    try {
      const reply = await fetch(request, { signal: AbortSignal.timeout(PATIENCE * 1000) });
      // a proxy whose server is gone
      return reply.status >= 502 && reply.status <= 504 ? ((await own()) ?? reply) : reply;
    } catch (error) {
      const reply = await own();
      if (reply) return reply;
      throw error;
    }
  };

  /** A file under a digest never changes: any version's will do. @param {Request} request */
  const file = async (request) => {
    const own = await caches.match(request.url, { ignoreVary: true }).catch(nothing);
    if (own) return own;
    const reply = await fetch(request);
    if (reply.ok && request.url.startsWith(addressOf(""))) {
      const copy = reply.clone();
      const cache = await caches.open(CACHE).catch(() => null);
      // a browser that has no room keeps what it has
      cache?.put(request.url, copy).catch(() => {});
    }
    return reply;
  };

  worker.addEventListener("install", (/** @type {any} */ event) => event.waitUntil(keepAll()));
  worker.addEventListener("activate", (/** @type {any} */ event) =>
    event.waitUntil(tidy().then(() => worker.clients.claim())),
  );
  worker.addEventListener("fetch", (/** @type {any} */ event) => {
    const { request } = event;
    const { origin, pathname } = new URL(request.url);
    if (request.method !== "GET" || origin !== SCOPE.origin) return;
    if (request.mode === "navigate" && pathname === SCOPE.pathname) {
      event.respondWith(answer(event));
      event.waitUntil(leaveIfUnwanted());
    } else if (/^\/page\/\w+\//.test(pathname.slice(SCOPE.pathname.length - 1)))
      event.respondWith(file(request));
  });
  // a page that begins: of this version it may be served by it; others are told which one waits
  worker.addEventListener("message", (/** @type {any} */ event) => {
    const { page, waits, language } = event.data ?? {};
    if (page === PAGE) event.waitUntil(worker.skipWaiting().then(tidy));
    else if (page && waits) event.source?.postMessage({ newer: PAGE });
    if (language) event.waitUntil(keepLanguage(language).catch(() => {}));
  });
}
