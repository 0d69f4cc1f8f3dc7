// Spanish: the keys of en/resonance.js.

export default {
  "resonance.intro":
    "Amplitud y fase de un brazo en régimen permanente, para una pequeña excitación en cada frecuencia. Sin rozamiento los picos son infinitos.",
  "resonance.drive": "Impulsado por",
  "resonance.x": "el pivote, de lado",
  "resonance.y": "el pivote, arriba y abajo",
  "resonance.cart": "una fuerza en el carro",
  "resonance.joint": "un motor en la articulación del brazo {arm}",
  "resonance.frequency": "frecuencia, Hz",
  "resonance.per.cm": "° por cm",
  "resonance.per.N": "° por N",
  "resonance.per.Nm": "° por N·m",
  "resonance.far": "Amplitud según la frecuencia",
  "resonance.late": "Fase según la frecuencia (bajo 0: llega tarde)",
};
