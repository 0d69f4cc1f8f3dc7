// German: the keys of en/resonance.js.

export default {
  "resonance.intro":
    "Amplitude und Phase eines Arms im eingeschwungenen Zustand, für einen kleinen Antrieb bei jeder Frequenz. Ohne Reibung sind die Spitzen unendlich hoch.",
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
