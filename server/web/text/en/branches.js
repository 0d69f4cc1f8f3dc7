// English: the words of the branches of modes in the drawer Modes.

export default {
  "branches.intro":
    "How fast each mode swings when it swings far: its frequency along its branch, whole where the swing is stable, broken where the least push leads away from it.",
  "branches.running": "The branches are being computed.",
  "branches.hint": "Click a point of a branch, or choose one below: it is set in motion.",
  "branches.plot": "Frequency of the modes over how far they swing",
  "branches.far": "Follow them up to",
  "branches.over": "Over",
  "branches.amplitude": "how far it swings",
  "branches.energy": "the energy",
  "branches.amplitude.axis": "farthest arm, °",
  "branches.energy.axis": "energy above the rest, J",
  "branches.along": "Which orbit of the branch",
  "branches.begin": "Set this orbit in motion",
  "branches.moving": "The orbit of mode {mode} moves on the stage.",
  "branches.stable": "Up to {angle}°, {energy} J: {frequency} Hz, period {period} s; stable.",
  "branches.unstable":
    "Up to {angle}°, {energy} J: {frequency} Hz, period {period} s; unstable: the least push grows.",
  "branches.fold": "Mode {mode} at {angle}°: the branch turns back.",
  "branches.branch": "Mode {mode} at {angle}°: another branch crosses it.",
  "branches.symmetry":
    "Mode {mode} at {angle}°: swings that are not alike on both sides branch off.",
  "branches.doubling": "Mode {mode} at {angle}°: swings of twice the period branch off.",
  "branches.torus": "Mode {mode} at {angle}°: its stability changes by a rotating disturbance.",
  "branches.driven.intro":
    "How far the pendulum swings over the frequency of its drive, from half of it to twice: whole where the swing is stable, broken where the least push leads away from it.",
  "branches.driven.name": "Swing under the drive",
  "branches.driven.axis": "frequency of the drive, Hz",
  "branches.driven.swing": "farthest arm, half of its way, °",
  "branches.driven.stable":
    "Drive {frequency} Hz: {angle}° to each side, period {period} s; stable.",
  "branches.driven.unstable":
    "Drive {frequency} Hz: {angle}° to each side, period {period} s; unstable: the least push grows.",
  "branches.driven.none":
    "No swing was found that keeps step with the drive near the pendulum's rest.",
  "branches.driven.fold": "{frequency} Hz, {angle}°: the branch turns back.",
  "branches.driven.branch": "{frequency} Hz, {angle}°: another branch crosses it.",
  "branches.driven.symmetry":
    "{frequency} Hz, {angle}°: swings that are not alike on both sides branch off.",
  "branches.driven.doubling": "{frequency} Hz, {angle}°: swings of twice the period branch off.",
  "branches.driven.torus":
    "{frequency} Hz, {angle}°: its stability changes by a rotating disturbance.",
};
