// German: the keys of en/resonance.js.

export default {
  "resonance.intro":
    "Wie weit und wie spät ein Arm am Ende schwingt, wenn ihn etwas bei jeder Frequenz ein wenig antreibt. Ohne Reibung haben Spitzen kein Ende.",
  "resonance.drive": "Angetrieben durch",
  "resonance.x": "die Aufhängung, seitwärts",
  "resonance.y": "die Aufhängung, auf und ab",
  "resonance.cart": "eine Kraft am Wagen",
  "resonance.joint": "einen Motor am Gelenk von Arm {arm}",
  "resonance.frequency": "Frequenz, Hz",
  "resonance.per.cm": "° je cm",
  "resonance.per.N": "° je N",
  "resonance.per.Nm": "° je N·m",
  "resonance.far": "Amplitude über der Frequenz",
  "resonance.late": "Phase über der Frequenz (unter 0: er kommt später)",
};
