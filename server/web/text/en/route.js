// English: the words of the route to chaos in the drawer Physics.

export default {
  "route.intro":
    "How the drive leads to chaos: the angle once in every period of the drive, after its first 80 periods, over the strength of the drive. One point is a swing with the drive, two are one of twice its period, a cloud is chaos.",
  "route.from": "Strength from",
  "route.to": "Strength to",
  "route.strength": "strength of the drive, {unit}",
  "route.plot": "Angle once in every period of the drive, over its strength",
  "route.hint": "Click a strength: the pendulum is driven by it. The sliders above do the same.",
  "route.none": "Nothing drives this pendulum to and fro: give it a motor or shake its pivot.",
};
