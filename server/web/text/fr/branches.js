// French: the keys of en/branches.js.

export default {
  "branches.intro":
    "La fréquence de chaque mode quand son amplitude augmente : en trait plein où l’oscillation est stable, en tirets où la moindre poussée s’amplifie.",
  "branches.running": "Les branches sont en cours de calcul.",
  "branches.hint":
    "Cliquez sur un point d’une branche, ou choisissez-le plus bas : il est mis en mouvement.",
  "branches.plot": "Fréquence des modes selon l’ampleur de leur oscillation",
  "branches.far": "Suivre jusqu’à l’amplitude",
  "branches.over": "Selon",
  "branches.amplitude": "l’amplitude",
  "branches.energy": "l’énergie",
  "branches.amplitude.axis": "plus grand angle d’un bras, °",
  "branches.energy.axis": "énergie au-dessus du repos, J",
  "branches.along": "Orbite de la branche",
  "branches.begin": "Mettre cette orbite en mouvement",
  "branches.moving": "L’orbite du mode {mode} se déroule sur la scène.",
  "branches.stable": "Jusqu’à {angle}°, {energy} J : {frequency} Hz, période {period} s ; stable.",
  "branches.unstable":
    "Jusqu’à {angle}°, {energy} J : {frequency} Hz, période {period} s ; instable : la moindre poussée grandit.",
  "branches.fold": "Mode {mode} à {angle}° : la branche fait demi-tour.",
  "branches.branch": "Mode {mode} à {angle}° : une autre branche la croise.",
  "branches.symmetry":
    "Mode {mode} à {angle}° : des oscillations différentes des deux côtés s’en détachent.",
  "branches.doubling":
    "Mode {mode} à {angle}° : des oscillations de période double s’en détachent.",
  "branches.torus": "Mode {mode} à {angle}° : sa stabilité change par une perturbation tournante.",
  "branches.driven.intro":
    "Jusqu’où le pendule oscille selon la fréquence de son excitation, de la moitié au double : en trait plein où l’oscillation est stable, en tirets où la moindre poussée en éloigne.",
  "branches.driven.name": "Oscillation sous l’excitation",
  "branches.driven.axis": "fréquence de l’excitation, Hz",
  "branches.driven.swing": "bras le plus écarté, moitié de sa course, °",
  "branches.driven.stable":
    "Excitation {frequency} Hz : {angle}° de chaque côté, période {period} s ; stable.",
  "branches.driven.unstable":
    "Excitation {frequency} Hz : {angle}° de chaque côté, période {period} s ; instable : la moindre poussée grandit.",
  "branches.driven.none":
    "Près du repos, aucune oscillation au pas de l’excitation n’a été trouvée.",
  "branches.driven.fold": "{frequency} Hz, {angle}° : la branche fait demi-tour.",
  "branches.driven.branch": "{frequency} Hz, {angle}° : une autre branche la croise.",
  "branches.driven.symmetry":
    "{frequency} Hz, {angle}° : des oscillations différentes des deux côtés s’en séparent.",
  "branches.driven.doubling":
    "{frequency} Hz, {angle}° : des oscillations de période double s’en séparent.",
  "branches.driven.torus":
    "{frequency} Hz, {angle}° : sa stabilité change par une perturbation tournante.",
};
