// Dutch: the keys of en/resonance.js.

export default {
  "resonance.intro":
    "Amplitude en fase van een arm in de eindtoestand, bij een kleine aandrijving op elke frequentie. Zonder wrijving zijn de pieken oneindig hoog.",
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
