// English: the words of the resonance curve in the drawer Modes.

export default {
  "resonance.intro":
    "How far and how late an arm swings in the end, when something drives it a little at each frequency. Without friction peaks have no top.",
  "resonance.drive": "Driven by",
  "resonance.x": "the pivot, sideways",
  "resonance.y": "the pivot, up and down",
  "resonance.cart": "a force on the cart",
  "resonance.joint": "a motor at the joint of arm {arm}",
  "resonance.frequency": "frequency, Hz",
  "resonance.per.cm": "° per cm",
  "resonance.per.N": "° per N",
  "resonance.per.Nm": "° per N·m",
  "resonance.far": "Amplitude over frequency",
  "resonance.late": "Phase over frequency (below 0: it comes late)",
};
