// Spanish: the keys of en/branches.js.

export default {
  "branches.intro":
    "La frecuencia de cada modo al crecer su amplitud: línea continua donde la oscilación es estable, de trazos donde el menor empujón crece.",
  "branches.running": "Se están calculando las ramas.",
  "branches.hint": "Haz clic en un punto de una rama o elígelo abajo: se pone en movimiento.",
  "branches.plot": "Frecuencia de los modos según lo lejos que oscilan",
  "branches.far": "Seguirlas hasta la amplitud",
  "branches.over": "Según",
  "branches.amplitude": "la amplitud",
  "branches.energy": "la energía",
  "branches.amplitude.axis": "mayor ángulo de un brazo, °",
  "branches.energy.axis": "energía sobre el reposo, J",
  "branches.along": "Órbita de la rama",
  "branches.begin": "Poner esta órbita en movimiento",
  "branches.moving": "La órbita del modo {mode} se mueve en el escenario.",
  "branches.stable": "Hasta {angle}°, {energy} J: {frequency} Hz, periodo {period} s; estable.",
  "branches.unstable":
    "Hasta {angle}°, {energy} J: {frequency} Hz, periodo {period} s; inestable: el menor empujón crece.",
  "branches.fold": "Modo {mode} a {angle}°: la rama da la vuelta.",
  "branches.branch": "Modo {mode} a {angle}°: otra rama la cruza.",
  "branches.symmetry":
    "Modo {mode} a {angle}°: se separan oscilaciones que no son iguales a ambos lados.",
  "branches.doubling": "Modo {mode} a {angle}°: se separan oscilaciones de periodo doble.",
  "branches.torus": "Modo {mode} a {angle}°: su estabilidad cambia por una perturbación que gira.",
  "branches.driven.intro":
    "Hasta dónde oscila el péndulo según la frecuencia de su excitación, de la mitad al doble: en línea continua donde la oscilación es estable, discontinua donde el menor empujón la aleja.",
  "branches.driven.name": "Oscilación bajo la excitación",
  "branches.driven.axis": "frecuencia de la excitación, Hz",
  "branches.driven.swing": "brazo que llega más lejos, mitad de su recorrido, °",
  "branches.driven.stable":
    "Excitación {frequency} Hz: {angle}° a cada lado, periodo {period} s; estable.",
  "branches.driven.unstable":
    "Excitación {frequency} Hz: {angle}° a cada lado, periodo {period} s; inestable: el menor empujón crece.",
  "branches.driven.none":
    "Cerca del reposo no se encontró ninguna oscilación que siga el paso de la excitación.",
  "branches.driven.fold": "{frequency} Hz, {angle}°: la rama da la vuelta.",
  "branches.driven.branch": "{frequency} Hz, {angle}°: otra rama la cruza.",
  "branches.driven.symmetry":
    "{frequency} Hz, {angle}°: se separan oscilaciones que no son iguales a ambos lados.",
  "branches.driven.doubling": "{frequency} Hz, {angle}°: se separan oscilaciones de doble periodo.",
  "branches.driven.torus":
    "{frequency} Hz, {angle}°: su estabilidad cambia por una perturbación que gira.",
};
