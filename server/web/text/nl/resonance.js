// Dutch: the keys of en/resonance.js.

export default {
  "resonance.intro":
    "Hoe ver en hoe laat een arm uiteindelijk slingert, als iets hem bij elke frequentie een beetje aandrijft. Zonder wrijving hebben pieken geen top.",
  "resonance.drive": "Aangedreven door",
  "resonance.x": "het ophangpunt, opzij",
  "resonance.y": "het ophangpunt, op en neer",
  "resonance.cart": "een kracht op de wagen",
  "resonance.joint": "een motor in het gewricht van arm {arm}",
  "resonance.frequency": "frequentie, Hz",
  "resonance.per.cm": "° per cm",
  "resonance.per.N": "° per N",
  "resonance.per.Nm": "° per N·m",
  "resonance.far": "Amplitude tegen de frequentie",
  "resonance.late": "Fase tegen de frequentie (onder 0: later)",
};
