// How long the page's functions and files may be, and how much they may branch; the same for the tests that drive them.
// Leaves to others: layout (prettier), names and types (tsc).
// Invariant: the limits are those of the C sources.

const limits = {
  "max-lines-per-function": ["error", { max: 60 }],
  "max-lines": ["error", { max: 500 }],
  complexity: ["error", { max: 15 }],
  "max-statements-per-line": ["error", { max: 1 }],
  "max-len": ["error", { code: 100, ignoreStrings: true, ignoreTemplateLiterals: true, ignoreUrls: true }],
};

export default [
  { files: ["server/web/**/*.js"], rules: { ...limits, "no-unused-vars": "error", "no-var": "error", eqeqeq: "error" } },
  { files: ["tests/web/**/*.mjs"], rules: { ...limits, "max-statements-per-line": "off", "max-len": "off" } },
];
