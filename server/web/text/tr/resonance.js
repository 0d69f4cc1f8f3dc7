// Turkish: the keys of en/resonance.js.

export default {
  "resonance.intro":
    "Her frekansta küçük bir tahrik için, kararlı durumda bir kolun genliği ve fazı. Sürtünme yoksa tepeler sonsuzdur.",
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
