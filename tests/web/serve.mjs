// The page from its sources, without a build: serves server/web as the daemon would (same URLs, same policy) and passes
// all else on to a daemon.  `node tests/web/serve.mjs [port] [daemon's URL]`; without a URL it starts one.
// Leaves to others: the daemon's own serving of the page, which server/http/assets does.
// Invariant: listens on loopback only.

import { createServer, request } from "node:http";
import { readFile } from "node:fs/promises";
import { extname, join, normalize } from "node:path";
import { fileURLToPath } from "node:url";

const ROOT = fileURLToPath(new URL("../../", import.meta.url));
const WEB = join(ROOT, "server/web");
const LIB = join(ROOT, "build/web/lib");
const ENGINE = join(ROOT, "build/web/engine.wasm");
const PAGE = "/page/sources";

const TYPES = { ".html": "text/html; charset=utf-8", ".js": "text/javascript; charset=utf-8", ".css": "text/css; charset=utf-8",
  ".svg": "image/svg+xml", ".woff2": "font/woff2", ".json": "application/json", ".wasm": "application/wasm" };

const POLICY = {
  "Content-Security-Policy": "default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; style-src 'self'; img-src 'self' data: blob:; font-src 'self'; "
    + "connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
  "X-Content-Type-Options": "nosniff",
  "Referrer-Policy": "no-referrer",
};

/** The file that a path stands for, null if the page has none there. */
function fileOf(path) {
  if (path === "/") return join(WEB, "index.html");
  if (path === "/docs") return join(WEB, "docs.html");
  if (!path.startsWith(`${PAGE}/`)) return null;
  const inner = normalize(path.slice(PAGE.length + 1));
  if (inner.startsWith("..")) return null;
  if (inner === "engine.wasm") return ENGINE;
  return inner.startsWith("lib/") ? join(LIB, inner.slice(4)) : join(WEB, inner);
}

async function sendFile(reply, file, engine) {
  try {
    let bytes = await readFile(file);
    if (extname(file) === ".html") bytes = Buffer.from(bytes.toString().replaceAll("@PAGE@", PAGE).replace("@ENGINE@", engine ? " data-engine" : ""));
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

/** {url, close(), fault, engine}; fault(asked, reply) may answer instead: true if it did; engine: whether the page has one. */
export async function servePage(daemon, port = 0) {
  const page = { daemon, fault: null, engine: false };
  const server = createServer((asked, reply) => {
    if (page.fault?.(asked, reply)) return;
    const file = fileOf(new URL(asked.url, "http://page").pathname);
    file ? sendFile(reply, file, page.engine) : passOn(asked, reply, page.daemon);
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
