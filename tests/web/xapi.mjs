// The shape of an xAPI statement, as the specification 1.0.3 (Data, section 2) has it for what the page writes.
// Leaves to others: which statements there must be (test_embed.mjs, test_worksheet.mjs).
// Invariant: what a store of statements must refuse, fails here: properties that are not known, null, ids that are no IRIs.

import assert from "node:assert/strict";

const UUID = /^[0-9a-f]{8}-[0-9a-f]{4}-[1-5][0-9a-f]{3}-[89ab][0-9a-f]{3}-[0-9a-f]{12}$/;
const INTERACTIONS = ["true-false", "choice", "fill-in", "long-fill-in", "matching", "performance", "sequencing", "likert", "numeric", "other"];
const TIME = /^\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d(\.\d+)?Z$/;

function only(thing, needed, allowed = []) {
  assert.equal(typeof thing, "object");
  for (const [key, value] of Object.entries(thing)) {
    assert.ok([...needed, ...allowed].includes(key), `the property ${key} is not known there`);
    assert.ok(value !== null && value !== undefined, `${key} is null`);
  }
  for (const key of needed) assert.ok(key in thing, `${key} is missing`);
}

const iri = (text) => assert.match(text, /^https?:\/\/[^\s<>"]+$/);

function words(map) {
  for (const [tag, text] of Object.entries(map)) {
    assert.ok(Intl.getCanonicalLocales(tag).length === 1, tag);
    assert.equal(typeof text, "string");
  }
}

function activity(object) {
  only(object, ["id"], ["objectType", "definition"]);
  iri(object.id);
  assert.equal(object.objectType ?? "Activity", "Activity");
  if (!object.definition) return;
  const { definition } = object;
  only(definition, ["type", "name"], ["description", "interactionType", "choices", "correctResponsesPattern"]);
  iri(definition.type);
  words(definition.name);
  words(definition.description ?? {});
  if (!("interactionType" in definition)) return;
  assert.ok(INTERACTIONS.includes(definition.interactionType), definition.interactionType);
  assert.ok((definition.correctResponsesPattern ?? []).every((one) => typeof one === "string"));
  for (const choice of definition.choices ?? []) {
    only(choice, ["id"], ["description"]);
    words(choice.description ?? {});
  }
  const ids = (definition.choices ?? []).map(({ id }) => id);
  assert.equal(new Set(ids).size, ids.length);
}

function result({ score, ...rest }) {
  only(rest, [], ["success", "completion", "response"]);
  for (const name of ["success", "completion"]) assert.ok(["boolean", "undefined"].includes(typeof rest[name]));
  assert.ok(["string", "undefined"].includes(typeof rest.response));
  if (!score) return;
  only(score, [], ["scaled", "raw", "min", "max"]);
  assert.ok(score.scaled >= -1 && score.scaled <= 1 && score.min < score.max && score.raw >= score.min && score.raw <= score.max);
}

/** Throws where a store of statements (1.0.3) would refuse it. */
export function checkStatement(statement) {
  only(statement, ["id", "actor", "verb", "object"], ["result", "context", "timestamp"]);
  assert.match(statement.id, UUID);
  only(statement.actor, ["account"], ["objectType"]);
  only(statement.actor.account, ["homePage", "name"]);
  iri(statement.actor.account.homePage);
  assert.ok(typeof statement.actor.account.name === "string" && statement.actor.account.name);
  only(statement.verb, ["id"], ["display"]);
  assert.match(statement.verb.id, /^http:\/\/adlnet\.gov\/expapi\/verbs\/(answered|completed)$/);
  words(statement.verb.display);
  activity(statement.object);
  result(statement.result);
  only(statement.context, ["platform"], ["contextActivities"]);
  for (const one of statement.context.contextActivities?.parent ?? []) activity(one);
  assert.match(statement.timestamp, TIME);
}
