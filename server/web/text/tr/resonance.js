// Turkish: the keys of en/resonance.js.

export default {
  "resonance.intro":
    "Bir şey onu her frekansta biraz sürdüğünde bir kolun sonunda ne kadar ve ne kadar geç salındığı. Sürtünmesiz tepelerin sonu yoktur.",
  "resonance.drive": "Süren",
  "resonance.x": "askı noktası, yana",
  "resonance.y": "askı noktası, yukarı aşağı",
  "resonance.cart": "arabaya bir kuvvet",
  "resonance.joint": "{arm}. kolun eklemindeki motor",
  "resonance.frequency": "frekans, Hz",
  "resonance.per.cm": "cm başına °",
  "resonance.per.N": "N başına °",
  "resonance.per.Nm": "N·m başına °",
  "resonance.far": "Frekansa göre genlik",
  "resonance.late": "Frekansa göre faz (0'ın altı: geç kalır)",
};
