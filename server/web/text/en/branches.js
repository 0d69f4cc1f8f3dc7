// English: the words of the branches of modes in the drawer Modes.

export default {
  "branches.intro":
    "The frequency of each mode as its amplitude grows: solid where the oscillation is stable, dashed where it is unstable.",
  "branches.running": "The branches are being computed.",
  "branches.hint": "Click a point of a branch, or choose one below, to set it in motion.",
  "branches.plot": "Frequency of the modes against amplitude",
  "branches.far": "Trace up to an amplitude of",
  "branches.over": "Horizontal axis",
  "branches.amplitude": "amplitude",
  "branches.energy": "energy",
  "branches.amplitude.axis": "largest arm angle, °",
  "branches.energy.axis": "energy above equilibrium, J",
  "branches.along": "Orbit of the branch",
  "branches.begin": "Set this orbit in motion",
  "branches.moving": "The orbit of mode {mode} moves on the stage.",
  "branches.stable": "Up to {angle}°, {energy} J: {frequency} Hz, period {period} s; stable.",
  "branches.unstable": "Up to {angle}°, {energy} J: {frequency} Hz, period {period} s; unstable.",
  "branches.fold": "Mode {mode} at {angle}°: the branch turns back.",
  "branches.branch": "Mode {mode} at {angle}°: another branch crosses it.",
  "branches.symmetry": "Mode {mode} at {angle}°: asymmetric oscillations branch off.",
  "branches.doubling": "Mode {mode} at {angle}°: period-doubled oscillations branch off here.",
  "branches.torus": "Mode {mode} at {angle}°: its stability changes (complex multipliers).",
  "branches.driven.intro":
    "The amplitude against the frequency of the drive, from half to twice its frequency: solid where the oscillation is stable, dashed where it is unstable.",
  "branches.driven.name": "Response to the drive",
  "branches.driven.axis": "frequency of the drive, Hz",
  "branches.driven.swing": "amplitude of the arm that swings most, °",
  "branches.driven.stable":
    "Drive {frequency} Hz: {angle}° to each side, period {period} s; stable.",
  "branches.driven.unstable":
    "Drive {frequency} Hz: {angle}° to each side, period {period} s; unstable.",
  "branches.driven.none": "No oscillation with the period of the drive was found near equilibrium.",
  "branches.driven.fold": "{frequency} Hz, {angle}°: the branch turns back.",
  "branches.driven.branch": "{frequency} Hz, {angle}°: another branch crosses it.",
  "branches.driven.symmetry": "{frequency} Hz, {angle}°: asymmetric oscillations branch off.",
  "branches.driven.doubling":
    "{frequency} Hz, {angle}°: oscillations of twice the period branch off.",
  "branches.driven.torus": "{frequency} Hz, {angle}°: quasiperiodic oscillations branch off.",
};
