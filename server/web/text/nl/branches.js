// Dutch: the keys of en/branches.js.

export default {
  "branches.intro":
    "Hoe snel elke eigentrilling slingert als ze ver slingert: haar frequentie langs haar tak, doorgetrokken waar de slingering stabiel is, gestreept waar de kleinste duw ervan wegvoert.",
  "branches.running": "De takken worden berekend.",
  "branches.hint":
    "Klik op een punt van een tak, of kies er hieronder een: het wordt in beweging gezet.",
  "branches.plot": "Frequentie van de eigentrillingen tegen hoe ver ze slingeren",
  "branches.far": "Volgen tot",
  "branches.over": "Tegen",
  "branches.amplitude": "hoe ver ze slingert",
  "branches.energy": "de energie",
  "branches.amplitude.axis": "verste arm, °",
  "branches.energy.axis": "energie boven de rust, J",
  "branches.along": "Welke baan van de tak",
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
};
