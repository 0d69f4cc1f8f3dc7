// German: the keys of en/route.js.

export default {
  "route.intro":
    "Wie der Antrieb ins Chaos führt: der Winkel einmal in jeder Periode des Antriebs, nach seinen ersten 80 Perioden, über der Stärke des Antriebs. Ein Punkt ist eine Schwingung mit dem Antrieb, zwei sind eine der doppelten Periode, eine Wolke ist Chaos.",
  "route.from": "Stärke von",
  "route.to": "Stärke bis",
  "route.strength": "Stärke des Antriebs, {unit}",
  "route.plot": "Winkel einmal in jeder Periode des Antriebs, über seiner Stärke",
  "route.hint":
    "Klicke auf eine Stärke: Das Pendel wird damit angetrieben. Die Regler oben tun dasselbe.",
  "route.none":
    "Nichts treibt dieses Pendel hin und her: Gib ihm einen Motor oder rüttle die Aufhängung.",
};
