// English: the words of the route to chaos in the drawer Physics.

export default {
  "route.intro":
    "How the drive leads to chaos: the angle once in every period of the drive, after the first 80 periods, against the strength of the drive. One point is a swing in the period of the drive, two points are a swing of twice that period, a cloud is chaos.",
  "route.from": "Strength from",
  "route.to": "Strength to",
  "route.strength": "strength of the drive, {unit}",
  "route.plot": "Angle once in every period of the drive, against its strength",
  "route.hint": "Click a strength to drive the pendulum with it. The sliders above do the same.",
  "route.none": "This pendulum has no periodic drive: add a motor or shake its pivot.",
};
