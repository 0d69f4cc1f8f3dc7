// The peer: a Node.js service as one writes it when it shall be fast: typed arrays, classical RK4 with a tenth of the
// sample step on the paper's matrix equation (aaa), Cholesky in place, nothing allocated in the loop. POST answers t, phi, phid.
// Leaves to others: everything else; what it is measured against is the daemon (tests/load).
'use strict';
const http = require('http');

const SUBSTEPS = 10, GRAVITY = 9.81;

/** A tree's constants, and the room that its equation needs: one function serves all trees, so that it stays compiled. */
class Tree {
  constructor(length, mass, path) {
    const n = this.n = length.length;
    this.load = new Float64Array(n), this.factor = new Float64Array(n * n);
    this.c = new Float64Array(n), this.s = new Float64Array(n);
    this.a = new Float64Array(n * n), this.x = new Float64Array(n);
    for (let j = 0; j < n; j++) {
      for (let i = 0; i < n; i++) this.load[j] += GRAVITY * length[j] * path[i][j] * mass[i];
      for (let k = 0; k < n; k++) {
        let sum = 0;
        for (let i = 0; i < n; i++) sum += path[i][j] * mass[i] * path[i][k];
        this.factor[j * n + k] = length[j] * length[k] * sum;
      }
    }
  }
}

/** (aaa): y = [phi, phi'] to out = [phi', phi'']. */
function equation(tree, y, out) {
  const { n, load, factor, c, s, a, x } = tree;
  for (let k = 0; k < n; k++) {
    c[k] = Math.cos(y[k]);
    s[k] = Math.sin(y[k]);
  }
  for (let j = 0; j < n; j++) {
    let sum = -load[j] * c[j];
    for (let k = 0; k < n; k++) {
      const f = factor[j * n + k], rate = y[n + k];
      a[j * n + k] = f * (c[j] * c[k] + s[j] * s[k]);
      sum += f * (c[j] * s[k] - s[j] * c[k]) * rate * rate;
    }
    x[j] = sum;
  }
  // a = L L^T, then two triangular solutions
  for (let j = 0; j < n; j++) {
    for (let k = 0; k <= j; k++) {
      let sum = a[j * n + k];
      for (let i = 0; i < k; i++) sum -= a[j * n + i] * a[k * n + i];
      a[j * n + k] = j === k ? Math.sqrt(sum) : sum / a[k * n + k];
    }
    let sum = x[j];
    for (let i = 0; i < j; i++) sum -= a[j * n + i] * x[i];
    x[j] = sum / a[j * n + j];
  }
  for (let j = n - 1; j >= 0; j--) {
    let sum = x[j];
    for (let i = j + 1; i < n; i++) sum -= a[i * n + j] * x[i];
    x[j] = sum / a[j * n + j];
    out[j] = y[n + j];
    out[n + j] = x[j];
  }
}

/** One step of classical Runge-Kutta, in place; k are four slopes, at is a state between. */
function advance(tree, y, h, k, at) {
  const [k1, k2, k3, k4] = k, count = 2 * tree.n;
  equation(tree, y, k1);
  for (let i = 0; i < count; i++) at[i] = y[i] + h / 2 * k1[i];
  equation(tree, at, k2);
  for (let i = 0; i < count; i++) at[i] = y[i] + h / 2 * k2[i];
  equation(tree, at, k3);
  for (let i = 0; i < count; i++) at[i] = y[i] + h * k3[i];
  equation(tree, at, k4);
  for (let i = 0; i < count; i++) y[i] += h / 6 * (k1[i] + 2 * k2[i] + 2 * k3[i] + k4[i]);
}

function solve(request) {
  const { L, m, S } = request.pendulum, { start, stop, step } = request.times;
  const n = L.length, rows = Math.round((stop - start) / step) + 1, h = step / SUBSTEPS;
  const tree = new Tree(L, m, S), y = new Float64Array(2 * n), at = new Float64Array(2 * n);
  const k = Array.from({ length: 4 }, () => new Float64Array(2 * n));
  const t = [], phi = [], phid = [];
  for (let row = 0; row < rows; row++) {
    for (let turn = 0; row && turn < SUBSTEPS; turn++) advance(tree, y, h, k, at);
    t.push(start + row * step);
    phi.push(Array.from(y.subarray(0, n)));
    phid.push(Array.from(y.subarray(n)));
  }
  return JSON.stringify({ t, phi, phid });
}

const server = http.createServer((request, response) => {
  const parts = [];
  request.on('data', part => parts.push(part));
  request.on('end', () => {
    let status = 200, answer;
    try {
      answer = solve(JSON.parse(Buffer.concat(parts)));
    } catch (error) {
      status = 400, answer = '{"error":"bad request"}';
    }
    response.writeHead(status, { 'Content-Type': 'application/json', 'Content-Length': Buffer.byteLength(answer) });
    response.end(answer);
  });
});
server.listen(0, '127.0.0.1', () => console.log(server.address().port));
process.on('SIGTERM', () => process.exit(0));
