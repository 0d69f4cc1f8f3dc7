// English: the words of the resonance curve in the drawer Modes.

export default {
  "resonance.intro":
    "Amplitude and phase of an arm in the steady state, for a small drive at each frequency. Without friction the peaks are infinite.",
  "resonance.drive": "Driven by",
  "resonance.x": "the pivot, sideways",
  "resonance.y": "the pivot, up and down",
  "resonance.cart": "a force on the cart",
  "resonance.joint": "a motor at the joint of arm {arm}",
  "resonance.frequency": "frequency, Hz",
  "resonance.per.cm": "° per cm",
  "resonance.per.N": "° per N",
  "resonance.per.Nm": "° per N·m",
  "resonance.far": "Amplitude against frequency",
  "resonance.late": "Phase against frequency (below 0: lags the drive)",
};
