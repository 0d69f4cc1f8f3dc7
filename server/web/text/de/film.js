// German: the keys of en/film.js.

export default {
  "film.intro":
    "Wähle einen Film deines eigenen Pendels oder lege ihn hier ab. Er bleibt in diesem Browser, nichts davon wird gesendet. Markiere zwei Punkte mit bekanntem Abstand und die Aufhängung, dann die Spitzen, Bild für Bild oder nach ihrer Farbe.",
  "film.open": "Film wählen",
  "film.opening": "Der Film wird geöffnet.",
  "film.opened": "{name}: {time} s lang.",
  "film.again": "{name}: {time} s lang, mit den Marken, die er hatte.",
  "film.kept":
    "Die Marken von {name} sind noch da. Wähle den Film noch einmal, um sie in ihm zu sehen.",
  "film.refused": "Dieser Browser kann {name} nicht als Film zeigen.",
  "film.mark": "Punkte im Film markieren",
  "film.done": "Fertig",
  "film.picture":
    "Bild des Films: Pfeile bewegen das Kreuz, mit Umschalt in größeren Schritten, Eingabe setzt die Marke, Bild ab und Bild auf führen zum nächsten und vorigen Bild, Entf nimmt die Marke weg, Escape beendet",
  "film.roles": "Film zum Markieren",
  "film.tools": "Was im Film markiert wird",
  "film.back": "Voriges Bild",
  "film.on": "Nächstes Bild",
  "film.tool": "Nächste Marke",
  "film.one": "Maßstab, erstes Ende",
  "film.two": "Maßstab, zweites Ende",
  "film.pivot": "Aufhängung",
  "film.below": "Ein Punkt senkrecht unter der Aufhängung",
  "film.tip": "Spitze von Arm {arm}",
  "film.remove": "Marke entfernen",
  "film.colour": "Einer Farbe folgen",
  "film.placed": "{what}: {x} {unit} nach rechts, {y} {unit} nach oben.",
  "film.end": "Das ist das letzte Bild des Films.",
  "film.following": "Der Farbe wird gefolgt. „Fertig“ hält an.",
  "film.followed": "Spitze {arm} ist in {count} Bildern markiert.",
  "film.lost":
    "Die Farbe ging verloren: Spitze {arm} ist in {count} Bildern markiert. Geh dort weiter, wo sie wieder zu sehen ist.",
  "film.noColour": "Von dieser Farbe ist hier zu wenig.",
  "film.metres": "Länge des Maßstabs",
  "film.slow": "Zeitlupe: wievielmal langsamer",
  "film.rate": "Bilder in einer Sekunde des Films",
  "film.tolerance": "Wie sehr eine Farbe abweichen darf",
  "film.scaled": "{scale} Pixel des Films sind ein Meter.",
  "film.unscaled":
    "Ohne Maßstab stehen Orte in Pixeln; eine Anpassung findet Längen trotzdem, aus der Schwerkraft.",
  "film.marked": "Marken der Spitze von Arm {arm}: {count}",
  "film.fit": "Das Pendel anpassen",
  "film.save": "Als CSV sichern",
  "film.clear": "Alle Marken der Spitzen entfernen",
};
