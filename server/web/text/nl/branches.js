// Dutch: the keys of en/branches.js.

export default {
  "branches.intro":
    "De frequentie van elke modus bij groeiende amplitude: doorgetrokken waar de trilling stabiel is, gestreept waar het kleinste duwtje groeit.",
  "branches.running": "De takken worden berekend.",
  "branches.hint":
    "Klik op een punt van een tak, of kies er hieronder een: het wordt in beweging gezet.",
  "branches.plot": "Frequentie van de eigentrillingen tegen hoe ver ze slingeren",
  "branches.far": "Volgen tot de amplitude",
  "branches.over": "Tegen",
  "branches.amplitude": "de amplitude",
  "branches.energy": "de energie",
  "branches.amplitude.axis": "grootste hoek van een arm, °",
  "branches.energy.axis": "energie boven het evenwicht, J",
  "branches.along": "Baan van de tak",
  "branches.begin": "Deze baan in beweging zetten",
  "branches.moving": "De baan van eigentrilling {mode} beweegt op het toneel.",
  "branches.stable": "Tot {angle}°, {energy} J: {frequency} Hz, periode {period} s; stabiel.",
  "branches.unstable":
    "Tot {angle}°, {energy} J: {frequency} Hz, periode {period} s; instabiel: de kleinste duw groeit.",
  "branches.fold": "Eigentrilling {mode} bij {angle}°: de tak keert om.",
  "branches.branch": "Eigentrilling {mode} bij {angle}°: een andere tak kruist hem.",
  "branches.symmetry":
    "Eigentrilling {mode} bij {angle}°: slingeringen die niet aan beide kanten gelijk zijn takken af.",
  "branches.doubling":
    "Eigentrilling {mode} bij {angle}°: slingeringen met de dubbele periode takken af.",
  "branches.torus":
    "Eigentrilling {mode} bij {angle}°: haar stabiliteit verandert door een ronddraaiende verstoring.",
  "branches.driven.intro":
    "Hoe ver de slinger slingert tegen de frequentie van zijn aandrijving, van de helft tot het dubbele: doorgetrokken waar de slingering stabiel is, gestreept waar de kleinste duw ervan wegvoert.",
  "branches.driven.name": "Slingering onder de aandrijving",
  "branches.driven.axis": "frequentie van de aandrijving, Hz",
  "branches.driven.swing": "verste arm, helft van zijn weg, °",
  "branches.driven.stable":
    "Aandrijving {frequency} Hz: {angle}° naar elke kant, periode {period} s; stabiel.",
  "branches.driven.unstable":
    "Aandrijving {frequency} Hz: {angle}° naar elke kant, periode {period} s; instabiel: de kleinste duw groeit.",
  "branches.driven.none":
    "Dicht bij het evenwicht is geen slingering gevonden die met de aandrijving in de pas loopt.",
  "branches.driven.fold": "{frequency} Hz, {angle}°: de tak keert om.",
  "branches.driven.branch": "{frequency} Hz, {angle}°: een andere tak kruist hem.",
  "branches.driven.symmetry":
    "{frequency} Hz, {angle}°: slingeringen die niet aan beide kanten gelijk zijn takken af.",
  "branches.driven.doubling":
    "{frequency} Hz, {angle}°: slingeringen van de dubbele periode takken af.",
  "branches.driven.torus":
    "{frequency} Hz, {angle}°: de stabiliteit verandert door een rondgaande verstoring.",
};
