// German: the keys of en/branches.js.

export default {
  "branches.intro":
    "Die Frequenz jeder Mode bei wachsender Amplitude: durchgezogen, wo die Schwingung stabil ist, gestrichelt, wo der kleinste Stoß anwächst.",
  "branches.running": "Die Zweige werden berechnet.",
  "branches.hint":
    "Klicke auf einen Punkt eines Zweigs oder wähle unten einen: Er wird in Bewegung gesetzt.",
  "branches.plot": "Frequenz der Moden darüber, wie weit sie schwingen",
  "branches.far": "Verfolgen bis zur Amplitude",
  "branches.over": "Über",
  "branches.amplitude": "die Amplitude",
  "branches.energy": "der Energie",
  "branches.amplitude.axis": "größter Winkel eines Arms, °",
  "branches.energy.axis": "Energie über der Ruhe, J",
  "branches.along": "Bahn des Zweigs",
  "branches.begin": "Diese Bahn in Bewegung setzen",
  "branches.moving": "Die Bahn der Mode {mode} bewegt sich auf der Bühne.",
  "branches.stable": "Bis {angle}°, {energy} J: {frequency} Hz, Periode {period} s; stabil.",
  "branches.unstable":
    "Bis {angle}°, {energy} J: {frequency} Hz, Periode {period} s; instabil: Der kleinste Stoß wächst.",
  "branches.fold": "Mode {mode} bei {angle}°: Der Zweig kehrt um.",
  "branches.branch": "Mode {mode} bei {angle}°: Ein anderer Zweig kreuzt ihn.",
  "branches.symmetry": "Mode {mode} bei {angle}°: unsymmetrische Schwingungen zweigen ab.",
  "branches.doubling": "Mode {mode} bei {angle}°: Schwingungen der doppelten Periode zweigen ab.",
  "branches.torus":
    "Mode {mode} bei {angle}°: Ihre Stabilität ändert sich durch eine umlaufende Störung.",
  "branches.driven.intro":
    "Wie weit das Pendel schwingt, über der Frequenz seines Antriebs, von der halben bis zur doppelten: durchgezogen, wo die Schwingung stabil ist, gestrichelt, wo der kleinste Stoß von ihr wegführt.",
  "branches.driven.name": "Antwort auf den Antrieb",
  "branches.driven.axis": "Frequenz des Antriebs, Hz",
  "branches.driven.swing": "weitester Arm, halber Weg, °",
  "branches.driven.stable":
    "Antrieb {frequency} Hz: {angle}° nach jeder Seite, Periode {period} s; stabil.",
  "branches.driven.unstable":
    "Antrieb {frequency} Hz: {angle}° nach jeder Seite, Periode {period} s; instabil: Der kleinste Stoß wächst.",
  "branches.driven.none":
    "Nahe der Ruhelage wurde keine Schwingung gefunden, die mit dem Antrieb Schritt hält.",
  "branches.driven.fold": "{frequency} Hz, {angle}°: Der Zweig kehrt um.",
  "branches.driven.branch": "{frequency} Hz, {angle}°: Ein anderer Zweig kreuzt ihn.",
  "branches.driven.symmetry":
    "{frequency} Hz, {angle}°: Schwingungen zweigen ab, die nicht auf beiden Seiten gleich sind.",
  "branches.driven.doubling":
    "{frequency} Hz, {angle}°: Schwingungen der doppelten Periode zweigen ab.",
  "branches.driven.torus":
    "{frequency} Hz, {angle}°: Die Stabilität ändert sich durch eine umlaufende Störung.",
};
