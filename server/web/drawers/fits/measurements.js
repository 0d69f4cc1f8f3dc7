// A table of measurements that another part of the page hands to the drawer Measure.
// Leaves to others: reading it (fit_table.js), who measures.
// Invariant: the text waits until the drawer is there, and is taken once.

/**
 * Opens the drawer Measure, where a pendulum is fitted to the table.
 * @param {App} app @param {string} csvText columns with their names above them, one of them `t`
 */
export function openMeasurements(app, csvText) {
  app.measurements = csvText;
  app.store.set({ view: { drawer: "measure" } });
}

/** The table that waits, once; null where none does. @param {App} app */
export function takeMeasurements(app) {
  const { measurements = null } = app;
  app.measurements = null;
  return measurements;
}
