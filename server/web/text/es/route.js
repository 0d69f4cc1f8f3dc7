// Spanish: the keys of en/route.js.

export default {
  "route.intro":
    "Cómo lleva la fuerza externa al caos: el ángulo una vez en cada periodo de la fuerza, después de sus primeros 80 periodos, según su intensidad. Un punto es una oscilación al compás de la fuerza, dos son una de periodo doble, una nube es caos.",
  "route.from": "Intensidad desde",
  "route.to": "Intensidad hasta",
  "route.strength": "intensidad de la fuerza, {unit}",
  "route.plot": "Ángulo una vez en cada periodo de la fuerza, según su intensidad",
  "route.hint":
    "Haz clic en una intensidad: el péndulo se mueve con ella. Los controles de arriba hacen lo mismo.",
  "route.none": "Nada mueve este péndulo de un lado a otro: dale un motor o sacude su pivote.",
};
