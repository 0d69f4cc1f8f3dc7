// French: the keys of en/resonance.js.

export default {
  "resonance.intro":
    "Amplitude et phase d’un bras en régime permanent, pour un petit entraînement à chaque fréquence. Sans frottement les pics sont infinis.",
  "resonance.drive": "Entraîné par",
  "resonance.x": "le pivot, de côté",
  "resonance.y": "le pivot, de haut en bas",
  "resonance.cart": "une force sur le chariot",
  "resonance.joint": "un moteur à l'articulation du bras {arm}",
  "resonance.frequency": "fréquence, Hz",
  "resonance.per.cm": "° par cm",
  "resonance.per.N": "° par N",
  "resonance.per.Nm": "° par N·m",
  "resonance.far": "Amplitude selon la fréquence",
  "resonance.late": "Phase selon la fréquence (sous 0 : en retard)",
};
