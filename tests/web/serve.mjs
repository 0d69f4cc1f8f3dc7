// The page from its sources, without a build: serves server/web as the daemon would (same URLs, same policy) and passes
// all else on to a daemon.  `node tests/web/serve.mjs [port] [daemon's URL]`; without a URL it starts one.
// For tests it takes the bundles of the build (build/web/bundles) before the sources, as a daemon does: a page of three files
// is opened with half the work of one of sixty.
// Leaves to others: the daemon's own serving of the page, which server/http/assets does.
// Invariant: listens on loopback only.

import { createServer, request } from "node:http";
import { existsSync, readdirSync, statSync } from "node:fs";
import { readFile, readdir } from "node:fs/promises";
import { extname, join, normalize, relative } from "node:path";
import { fileURLToPath } from "node:url";

const ROOT = fileURLToPath(new URL("../../", import.meta.url));
const WEB = join(ROOT, "server/web");
const LIB = join(ROOT, "build/web/bundles/lib");
const BUNDLES = join(ROOT, "build/web/bundles");
const ENGINE = join(ROOT, "build/web/engine.wasm");

const TYPES = { ".html": "text/html; charset=utf-8", ".js": "text/javascript; charset=utf-8", ".css": "text/css; charset=utf-8",
  ".svg": "image/svg+xml", ".woff2": "font/woff2", ".json": "application/json", ".wasm": "application/wasm", ".png": "image/png", ".webmanifest": "application/manifest+json" };

const POLICY = {
  "Content-Security-Policy": "default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; style-src 'self'; img-src 'self' data: blob:; media-src blob:; font-src 'self'; "
    + "connect-src 'self'; manifest-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
  "X-Content-Type-Options": "nosniff",
  "Referrer-Policy": "no-referrer",
};

/** Whether the bundles are there and made of the sources as they are now. */
export function bundlesAreNew() {
  const made = join(ROOT, "build/web/bundled");
  if (!existsSync(made) || !existsSync(BUNDLES)) return false;
  const { mtimeMs } = statSync(made);
  return readdirSync(WEB, { recursive: true }).every((name) => !/\.(js|css)$/.test(name) || statSync(join(WEB, name)).mtimeMs <= mtimeMs);
}

/** The file that a path stands for, null if the page has none there. */
function fileOf(path, { home, worker, bundles }) {
  if (path === "/") return join(WEB, "index.html");
  if (path === "/docs") return join(WEB, "docs.html");
  if (path === "/sw.js" && worker) return join(WEB, "sw.js");
  if (!path.startsWith(`${home}/`)) return null;
  const inner = normalize(path.slice(home.length + 1));
  if (inner.startsWith("..")) return null;
  if (inner === "engine.wasm") return ENGINE;
  if (inner.startsWith("lib/")) return join(LIB, inner.slice(4));
  const bundle = join(BUNDLES, inner);
  return bundles && existsSync(bundle) ? bundle : join(WEB, inner);
}

/** What the service worker may keep, by the names under the page's path. */
async function filesOf({ engine }) {
  const names = async (folder) => (await readdir(folder, { recursive: true, withFileTypes: true }))
    .filter((entry) => entry.isFile() && TYPES[extname(entry.name)]).map((entry) => relative(folder, join(entry.parentPath ?? entry.path, entry.name)));
  const own = (await names(WEB)).filter((name) => !/node_modules|package|\.html$|\.d\.ts$|^sw\.js$/.test(name));
  return [...own, ...(await names(LIB)).map((name) => `lib/${name}`), ...(engine ? ["engine.wasm"] : [])];
}

async function sendFile(reply, file, page) {
  try {
    let bytes = await readFile(file);
    if (extname(file) === ".html" || file === join(WEB, "sw.js")) {
      const text = bytes.toString().replaceAll("@PAGE@", page.home.slice(1)).replace("@ENGINE@", page.engine ? " data-engine" : "").replace("@OFFLINE@", page.worker ? " data-offline" : "");
      bytes = Buffer.from(text.replace("@FILES@", (await filesOf(page)).join(" ")));
    }
    reply.writeHead(200, { "Content-Type": TYPES[extname(file)] ?? "application/octet-stream", "Cache-Control": "no-cache", ...POLICY });
    reply.end(bytes);
  } catch {
    reply.writeHead(404, { "Content-Type": "text/plain" }).end("not here\n");
  }
}

function passOn(asked, reply, daemon) {
  const { hostname, port } = new URL(daemon);
  const onward = request({ hostname, port, method: asked.method, path: asked.url, headers: asked.headers }, (answer) => {
    const { trailer, ...headers } = answer.headers; // no page can read what is behind a body
    reply.writeHead(answer.statusCode, headers);
    answer.pipe(reply);
  });
  onward.on("error", () => (reply.headersSent ? reply.destroy() : reply.writeHead(502).end()));
  reply.on("close", () => onward.destroy());
  asked.pipe(onward);
}

/** {url, close(), fault, engine, worker, home, bundles}; fault(asked, reply) may answer instead: true if it did; engine: whether
 *  the page has one; worker: whether it has a service worker; home: the path of its files, which stands for the page's version;
 *  bundles: whether they go before the sources. */
export async function servePage(daemon, port = 0, bundles = false) {
  const page = { daemon, fault: null, engine: false, worker: false, home: "/page/sources", bundles };
  const server = createServer((asked, reply) => {
    if (page.fault?.(asked, reply)) return;
    const file = fileOf(new URL(asked.url, "http://page").pathname, page);
    file ? sendFile(reply, file, page) : passOn(asked, reply, page.daemon);
  });
  server.keepAliveTimeout = 0; // a connection that a browser keeps is there when it asks again, however late
  await new Promise((ready) => server.listen(port, "127.0.0.1", ready));
  page.url = `http://127.0.0.1:${server.address().port}`;
  page.close = () => {
    server.closeAllConnections();
    server.close();
  };
  return page;
}

if (process.argv[1] === fileURLToPath(import.meta.url)) {
  const [port = "8090", given] = process.argv.slice(2);
  const daemon = given ?? (await (await import("./rig.mjs")).startDaemon()).url;
  const page = await servePage(daemon, Number(port));
  console.log(`${page.url} with ${daemon}`);
}
