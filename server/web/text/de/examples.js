// German: what the examples show, and their groups.

export default {
  "examples.first": "Erste Schritte",
  "examples.surprising": "Überraschend",
  "examples.driven": "Antrieb und Reibung",
  "examples.trees": "Bäume und Ketten",
  "examples.more": "Weitere",
  "preset.single.words":
    "Ein Arm, bei 40° losgelassen. Seine Periode ist 2,07 s, 3 % länger als nach der Formel für kleine Ausschläge.",
  "preset.side-by-side.words":
    "Zwei Pendel, die sich nicht berühren. Das eine ist viermal so lang wie das andere, seine Periode also doppelt so lang. Ändere eine Länge oder eine Masse und vergleiche.",
  "preset.double.words":
    "Zwei gleiche Arme bei kleinem Ausschlag: eine langsame und eine schnelle Eigenschwingung zugleich.",
  "preset.upright.words":
    "5° neben der Senkrechten nach oben losgelassen: Es verweilt oben, und seine Periode ist viel länger als bei kleinen Ausschlägen.",
  "preset.kapitza.words":
    "Die Aufhängung rüttelt 32 Mal in der Sekunde auf und ab: So bleibt das Pendel oben stehen. Mit einer Amplitude unter 11 mm fällt es.",
  "preset.coupled.words":
    "Zwei gleiche Pendel hängen an einem Rahmen, den eine Feder aufrecht hält. Das erste gibt seine Schwingung an das zweite ab und bekommt sie wieder.",
  "preset.two-to-one.words":
    "Mit 0,64 kg und 0,36 kg ist eine Eigenschwingung genau doppelt so schnell wie die andere: Die Enden kehren nach jeder langsamen Periode zurück.",
  "preset.chaotic-double.words":
    "Von oberhalb der Waagrechten losgelassen. Zwei Starts, die sich um ein Haar unterscheiden, trennen sich in Sekunden: Vergleichen zeigt es.",
  "preset.double-bars.words":
    "Zwei Stäbe ohne Gewichte an den Enden, wie die meisten Doppelpendel auf einem Tisch.",
  "preset.driven-damped.words":
    "Ein Motor dreht es hin und her, Reibung bremst es. Mit einem Motor von 0,9 N m schwingt es im Takt des Motors, mit 1,07 N m wiederholt es sich erst nach zwei Perioden, und mit 1,15 N m, wie hier, wiederholt es sich nie: der Weg ins Chaos.",
  "preset.laboratory-double.words":
    "Ein Versuchsstand mit Lagern und einem Motor im zweiten Gelenk, beschrieben durch fünfzehn Zahlen.",
  "preset.metronome-cart.words":
    "Der Arm eines Metronoms, mit seinem Gewicht oben und einem schwereren unten, auf einem Wagen, der rollt: Arm und Wagen schwingen gegeneinander, ein wenig schneller als auf einem Tisch.",
  "preset.bar-on-stop.words": "Jeder Stoß lässt ihm 80 % der Geschwindigkeit, bis er liegt.",
  "preset.clock.words": "Ein Motor stößt sie ganz unten an, solange sie unter 12° schwingt.",
  "preset.paper-four-arms.words":
    "Das Beispiel des Aufsatzes: Zwei Arme hängen am zweiten Gelenk. Aus der Waagrechten losgelassen, ohne Schwung.",
  "preset.triple.words": "Drei gleiche Arme untereinander, aus der Waagrechten losgelassen.",
  "preset.non-standard-triple.words":
    "Zwei Arme hängen am Ende des ersten. In einer Eigenschwingung schwingen sie gegeneinander, und der erste Arm ruht: Dieser Start kommt ihr nahe.",
  "preset.chain-10.words":
    "Zehn gleiche Arme, gestreckt aus der Waagrechten losgelassen. Der Zug läuft die Kette entlang bis an ihr Ende, das ausschlägt.",
  "preset.star.words":
    "Acht Arme um ein Ende, gespreizt wie Speichen. Sie wirken nur über die Nabe aufeinander.",
  "preset.binary-4.words": "Jeder Arm trägt zwei kürzere und leichtere, vier Stufen tief.",
  "preset.whip.words":
    "Sechzehn Arme, die zum Ende hin leichter werden. Ein Ruck am schweren Ende läuft nach außen, und die Spitze peitscht.",
  "preset.thor.words":
    "Ein leichter Stamm mit zwei schweren Armen, die gegenläufig wirbeln und das Gelenk umherwerfen.",
  "preset.octopus.words": "Vier Fangarme aus je vier Armen an einem schweren Kopf.",
  "preset.mobile.words":
    "Arme von sehr verschiedener Länge und Masse: eine langsame schwere Schwingung mit schnellen leichten darauf.",
};
