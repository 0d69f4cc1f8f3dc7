// French: the keys of en/route.js.

export default {
  "route.intro":
    "Comment l’entraînement mène au chaos : l’angle une fois par période de l’entraînement, après ses 80 premières périodes, selon la force de l’entraînement. Un point est une oscillation qui suit l’entraînement, deux en font une de période double, un nuage est le chaos.",
  "route.from": "Force de",
  "route.to": "Force jusqu’à",
  "route.strength": "force de l’entraînement, {unit}",
  "route.plot": "Angle une fois par période de l’entraînement, selon sa force",
  "route.hint":
    "Cliquez sur une force : elle entraîne le pendule. Les curseurs plus haut font de même.",
  "route.none":
    "Rien n’entraîne ce pendule de façon périodique : donnez-lui un moteur ou secouez son pivot.",
};
